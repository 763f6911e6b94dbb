"""Planner: decides on counts alone how an outline is best cut up, and by which fills.

Where a table knows only fills with fewer sides, :func:`choose_corners` says which corners of a
boundary to keep.
"""

from __future__ import annotations

import random
from bisect import bisect_left
from collections.abc import Iterator

from query.boundary import Boundary
from query.cancellation import NEVER, CancelFlag, raise_if_cancelled
from query.construct.pentagon_cuts import Trimmed, trim_outline
from query.construct.plan import (
    DroppedCorners,
    Lookup,
    Plan,
    RectanglePart,
    TablePart,
    draw_chord,
    drop_corners,
    find_best_rectangle,
)
from query.construct.reflex_cuts import find_prolongations

#: Random choices of corners that follow the even ones.
RANDOM_CHOICES = 100

#: Few enough sides that corners are worth dropping down to.
FEWEST_KEPT = 4


def choose_corners(boundary: Boundary, most: int) -> Iterator[tuple[int, ...]]:
    """Corners to keep, as ascending numbers; at most ``most`` of them, most corners first.

    First those nearest to equally spaced points, one choice for every corner to start from;
    where there are reflex corners, also among the convex ones alone. Then random ones, the
    same for the same boundary. No choice comes twice, and none keeps all corners.
    """
    n = boundary.n_sides
    corners = list(range(n))
    convex = [i for i in corners if boundary.corners[i] == "convex"]
    pools = [corners] if boundary.convex else [corners, convex]
    seen: set[tuple[int, ...]] = set()
    # Two kept corners are the least that the table is asked about.
    fewest = min(FEWEST_KEPT, max(2, n - 1))
    sizes = range(min(most, n - 1), fewest - 1, -1)
    for size in sizes:
        for pool in pools:
            if len(pool) < size:
                continue
            if len(pool) == size < n:
                evenly: Iterator[tuple[int, ...]] = iter([tuple(pool)])
            else:
                evenly = (space_corners(boundary, pool, start, size) for start in range(len(pool)))
            for choice in evenly:
                if len(choice) == size and choice not in seen:
                    seen.add(choice)
                    yield choice
    chance = random.Random(repr((boundary.lengths, boundary.corners)))
    for _ in range(RANDOM_CHOICES if len(sizes) else 0):
        pool = chance.choice(pools)
        size = min(chance.choice(sizes), len(pool))
        choice = tuple(sorted(chance.sample(pool, size)))
        if 2 <= len(choice) < n and choice not in seen:
            seen.add(choice)
            yield choice


def space_corners(boundary: Boundary, pool: list[int], start: int, size: int) -> tuple[int, ...]:
    """The corners of the pool nearest to ``size`` equally spaced points, the first of them
    corner pool[start]; fewer than ``size`` where two points have the same nearest one."""
    starts = boundary.side_starts
    perimeter = boundary.perimeter
    turned = pool[start:] + pool[:start]
    places = [(starts[i] - starts[turned[0]]) % perimeter for i in turned]
    near: set[int] = set()
    for k in range(size):
        aim = k * perimeter / size
        at = bisect_left(places, aim)
        options = [i for i in (at - 1, at) if 0 <= i < len(places)]
        near.add(turned[min(options, key=lambda i: abs(places[i] - aim))])
    return tuple(sorted(near))


#: Choices of corners to keep that are asked about, and how many as good as can be expected
#: end the search sooner. Where the lookup answers none of them, all choices are tried.
KEPT_TRIES = 40
KEPT_TRIES_REFLEX = 12
KEPT_PLANS = 4

#: Ways to cut pentagons off: the length from which sides are long enough, and which of the
#: best cuts comes first; how many as good as can be expected end the search sooner; ways
#: tried where there are reflex corners; and sides above which corners are dropped first.
WAYS = tuple((ample, rank) for rank in range(8) for ample in (5, 3))
GOOD_WAYS = 3
WAYS_REFLEX = 4
MOST_TRIMMED = 64

#: Cuts through reflex corners that are followed up: of the boundary, of its parts, of theirs.
PROLONGED = (8, 2, 1)


class Planner:
    """Plans for one query. It remembers what it has asked the lookup.

    Once ``cancelled`` is set, its methods raise QueryCancelledError: with a hundred sides and
    reflex corners, half of them, they search for half a minute.
    """

    def __init__(self, lookup: Lookup, cancelled: CancelFlag = NEVER) -> None:
        self.cancelled = cancelled
        self._lookup = lookup
        self._parts: dict[tuple[Boundary, bool], TablePart | None] = {}
        self._best: dict[tuple[Boundary, bool, int], Plan | None] = {}

    def plans(self, boundary: Boundary, strict: bool) -> list[Plan]:
        """Every plan for a boundary that a construction arrives at."""
        found = self.plan_rectangle(boundary, strict)
        # Where there are reflex corners, it is the chords through them that pay.
        convex = boundary.convex
        if not strict:
            found += self.plan_kept(boundary, KEPT_TRIES if convex else KEPT_TRIES_REFLEX)
        ways = len(WAYS) if convex else WAYS_REFLEX
        found += self.plan_trimmed(boundary, strict, ways)
        if not strict and boundary.n_sides > MOST_TRIMMED:
            found += self.plan_trimmed(boundary, True, ways)
        found += self.plan_prolonged(boundary, strict)
        return found

    def best(self, outline: Boundary, strict: bool, depth: int) -> Plan | None:
        """The plan of a part with fewest irregular vertices; there is none only if strict.

        depth: how many chords through reflex corners have been drawn before.
        """
        key = (outline, strict, depth)
        if key not in self._best:
            self._best[key] = self._find_best(outline, strict, depth)
        return self._best[key]

    def _find_best(self, outline: Boundary, strict: bool, depth: int) -> Plan | None:
        part = self._part(outline, strict)
        found = [part] if part is not None else self.plan_rectangle(outline, strict)
        # Gauss-Bonnet: with valences 3 and 5 there are at least so many where strict.
        needed = abs(sum(2 - k for k in outline.corner_counts) - 4)
        if part is None or (part.count > needed and not outline.convex):
            found += self.plan_trimmed(outline, strict, 1)
            found += self.plan_prolonged(outline, strict, depth)
            if not strict:
                found += self.plan_kept(outline, 2, 1)
        return min(found, key=lambda plan: plan.count, default=None)

    def _part(self, outline: Boundary, strict: bool) -> TablePart | None:
        """The lookup's own fill of an outline."""
        n = outline.n_sides
        if not 2 <= n <= self._lookup.max_sides:
            return None
        if strict and n != 4 and outline.convex and 1 in outline.lengths:
            # Peel the quad on that side off: it stays as long, and its neighbours vanish.
            return None
        key = (outline, strict)
        if key not in self._parts:
            count = self._lookup.count(outline, strict=strict)
            self._parts[key] = None if count is None else TablePart(outline, strict, count)
        return self._parts[key]

    def plan_rectangle(self, outline: Boundary, strict: bool) -> list[Plan]:
        """A grid, wherever its corners fall."""
        count, p, a = find_best_rectangle(outline)
        return [RectanglePart(outline.perimeter, p, a, count)] if count == 0 or not strict else []

    def plan_kept(
        self, boundary: Boundary, tries: int = KEPT_TRIES, wanted: int = KEPT_PLANS
    ) -> list[Plan]:
        """A fill of the lookup's in which some corners are dropped, at a cost of 1 each."""
        found: list[Plan] = []
        good = 0
        for at, keep in enumerate(choose_corners(boundary, self._lookup.max_sides)):
            if good == wanted or (at >= tries and found):
                break
            raise_if_cancelled(self.cancelled)
            turn, outline = drop_corners(boundary, keep)
            part = self._part(outline, False)
            if part is not None:
                count = part.count + boundary.n_sides - len(keep)
                found.append(DroppedCorners(turn, part, count))
                good += count <= boundary.n_sides - 5
        return sorted(found, key=lambda plan: plan.count)[:wanted]

    def plan_trimmed(self, boundary: Boundary, strict: bool, ways: int = len(WAYS)) -> list[Plan]:
        """Pentagons cut off until the lookup knows the rest, which keeps corners as asked.

        Of each way to cut, the best plan, and the best whose rest is strict. Above
        MOST_TRIMMED sides corners are dropped first, unless strict: each costs as much as the
        pentagon it saves.
        """
        found: list[Plan] = []
        good = 0
        begin: tuple[int, int] | None = None
        if not strict and boundary.n_sides > MOST_TRIMMED:
            keep = space_corners(boundary, list(range(boundary.n_sides)), 0, MOST_TRIMMED)
            turn, outline = drop_corners(boundary, keep)
            begin = turn, boundary.n_sides - len(keep)
            boundary = outline
        # Gauss-Bonnet, with valences 3 and 5.
        expected = abs(sum(2 - k for k in boundary.corner_counts) - 4)
        for ample, rank in WAYS[:ways]:
            raise_if_cancelled(self.cancelled)
            stages = trim_outline(boundary, ample, rank, self._lookup.max_sides, drop=not strict)
            tight = self._best_stage(stages, True, expected)
            if tight is not None:
                found.append(tight)
                good += tight.count <= expected
            loose = None if strict else self._best_stage(stages, False, expected - 1)
            if loose is not None and (tight is None or loose.count < tight.count):
                found.append(loose)
            if good == GOOD_WAYS:
                break
        if begin is not None:
            turn, n_dropped = begin
            return [DroppedCorners(turn, plan, plan.count + n_dropped) for plan in found]
        return found

    def _best_stage(self, stages: list[Trimmed], strict: bool, enough: int) -> Plan | None:
        """The plan with fewest irregular vertices, or the first with at most ``enough``."""
        best: tuple[int, Trimmed, TablePart] | None = None
        for stage in stages:
            raise_if_cancelled(self.cancelled)
            rest = self._part(stage.rest, strict)
            if rest is not None and (best is None or rest.count + stage.cost < best[0]):
                best = (rest.count + stage.cost, stage, rest)
                if best[0] <= enough:
                    break
        return best and best[1].plan(best[2])

    def plan_prolonged(self, boundary: Boundary, strict: bool, depth: int = 0) -> list[Plan]:
        """Reflex corners taken away by chords that prolong a side through them."""
        if boundary.convex:
            return []
        raise_if_cancelled(self.cancelled)
        most = PROLONGED[min(depth, len(PROLONGED) - 1)]
        found: list[Plan] = []
        for cut in find_prolongations(boundary, most):
            left = self.best(cut.left, strict, depth + 1)
            right = self.best(cut.right, strict, depth + 1)
            if left is not None and right is not None:
                found.append(draw_chord(cut.start, cut.end, cut.length, left, right, cut.turn))
        return found
