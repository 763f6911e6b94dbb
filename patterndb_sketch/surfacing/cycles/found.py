"""Found cycles: how they are oriented, which of them are walls, and what a user should know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from patterndb.geometry.points import Floats
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle, total_length
from patterndb_sketch.surfacing.cycles.closing import find_dangling
from patterndb_sketch.surfacing.cycles.packing import SIDES

#: The worst badness of a wall. In the CASSIE sketches four are found, all recorded, those of every
#: second one being unchanged; up to 0.5 there are 22, of which 8 are recorded.
WORST_WALL = 0.3

#: At least this share of a wall's length runs along curves that bound less than two others.
FREE_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class RejectedCycle:
    """A closed cycle that was not taken.

    badness: how much it bends, folds and passes curves by; worst: the most that was allowed.
    """

    cycle: Cycle
    badness: float
    worst: float

    def tell(self, network: CurveNetwork) -> str:
        """Say which curves they are, why they were not taken, and how to keep them."""
        names = ",".join(map(str, network.names(self.cycle)))
        if self.badness <= self.worst:
            why = "another choice was better"
        else:
            why = f"badness {self.badness:.2f}, the most allowed is {self.worst:g}"
        return (
            f"the curves {names} close a cycle that is not taken for a patch ({why}); add it if it "
            f"is one (--keep {names})"
        )


@dataclass(frozen=True, slots=True)
class FoundCycles:
    """The cycles of a network.

    cycles:      the cycles; neighbours walk a shared curve in opposite senses where the surface
                 can be oriented. Walls, which stand on curves of two others, come last.
    dangling:    numbers of curves that end where nothing goes on, and bound nothing.
    unused:      numbers of other curves that bound no cycle.
    once:        numbers of curves that bound one cycle only: the surface's boundary.
    candidates:  how many cycles were considered.
    cut_short:   pairs of curves for which not all closing paths were looked through.
    proven:      is there surely no better choice among the candidates that took part? False too
                 where a choice was mended because it was no surface.
    orientable:  could all cycles be oriented?
    pinches:     nodes around which a surface is closed while other cycles touch it there.
    nearest_miss: the best of the candidates whose curves bound nothing; None without one.
    notes:       the same in words, for what a user should look at; empty if all is well.
    """

    cycles: tuple[Cycle, ...]
    dangling: tuple[int, ...] = ()
    unused: tuple[int, ...] = ()
    once: tuple[int, ...] = ()
    candidates: int = 0
    cut_short: int = 0
    proven: bool = True
    orientable: bool = True
    pinches: tuple[int, ...] = ()
    nearest_miss: RejectedCycle | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)


def describe_cycles(network: CurveNetwork, found: FoundCycles) -> FoundCycles:
    """Complete found cycles by what follows from them, and by the notes."""
    gone = find_dangling(network)
    count = {curve: len(walks) for curve, walks in list_users(found.cycles).items()}
    living = np.flatnonzero(~gone).tolist()
    found = replace(
        found,
        dangling=tuple(np.flatnonzero(gone).tolist()),
        unused=tuple(curve for curve in living if curve not in count),
        once=tuple(curve for curve in living if count.get(curve) == 1),
        pinches=tuple(sorted({node for node, _ in find_pinches(network, found.cycles)})),
    )
    counted = (
        (
            len(found.dangling),
            "curve dangles and bounds no cycle",
            "curves dangle and bound no cycle",
        ),
        (len(found.unused), "other curve bounds no cycle", "other curves bound no cycle"),
        (
            found.cut_short,
            "pair of curves was not closed in all ways: too many paths",
            "pairs of curves were not closed in all ways: too many paths",
        ),
        (
            len(found.pinches),
            "node is pinched: a closed surface is touched there by another",
            "nodes are pinched: a closed surface is touched there by another",
        ),
    )
    notes = [f"1 {one}" if n == 1 else f"{n:,} {many}" if n else "" for n, one, many in counted]
    if found.nearest_miss is not None:
        notes.insert(2, found.nearest_miss.tell(network))
    if not found.proven:
        notes.append(
            "a better choice among the cycles considered may exist: this one is not proven best"
        )
    if not found.orientable:
        notes.append("the surface cannot be oriented: it turns over, as a Moebius strip does")
    return replace(found, notes=tuple(filter(None, notes)))


@dataclass(frozen=True, slots=True)
class OrientedCycles:
    """Cycles turned so that neighbours walk the curve they share in opposite senses.

    cycles:    the cycles, in order.
    surfaces:  for each the number of the surface that it is part of; neighbours share it.
    twisted:   sets of cycles, each a closed strip that turns over, so that no turning does.
    """

    cycles: tuple[Cycle, ...]
    surfaces: tuple[int, ...]
    twisted: tuple[tuple[int, ...], ...]


def list_users(cycles: Sequence[Cycle]) -> dict[int, list[tuple[int, bool]]]:
    """For every curve that cycles walk: (cycle, backward)."""
    at: dict[int, list[tuple[int, bool]]] = {}
    for i, cycle in enumerate(cycles):
        for curve, backward in cycle.steps:
            at.setdefault(curve, []).append((i, backward))
    return at


def orient_cycles(cycles: Sequence[Cycle]) -> OrientedCycles:
    """The cycles turned like the first of each surface, each curve in at most two of them."""
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in cycles]
    for walks in list_users(cycles).values():
        if len(walks) == 2 and walks[0][0] != walks[1][0]:
            (i, sense), (j, other) = walks
            neighbours[i].append((j, sense == other))
            neighbours[j].append((i, sense == other))
    surface = [-1] * len(cycles)
    turned = [False] * len(cycles)
    before = [-1] * len(cycles)
    twisted: set[tuple[int, ...]] = set()
    for first in range(len(cycles)):
        if surface[first] >= 0:
            continue
        surface[first] = first
        waiting = [first]
        for i in waiting:  # grows as it is walked through: breadth first
            for j, turn in neighbours[i]:
                if surface[j] < 0:
                    surface[j], turned[j], before[j] = first, turned[i] != turn, i
                    waiting.append(j)
                elif turned[j] != (turned[i] != turn):
                    twisted.add(_strip(before, i, j))
    result = tuple(c.turned if t else c for c, t in zip(cycles, turned, strict=True))
    return OrientedCycles(result, tuple(surface), tuple(sorted(twisted)))


def _strip(before: Sequence[int], i: int, j: int) -> tuple[int, ...]:
    """The closed strip that two neighbours make with their ways to where these part."""
    ways: list[list[int]] = []
    for k in (i, j):
        way = [k]
        while before[way[-1]] >= 0:
            way.append(before[way[-1]])
        ways.append(way[::-1])
    common = 0
    while common < min(map(len, ways)) and ways[0][common] == ways[1][common]:
        common += 1
    return tuple(sorted({*ways[0][max(common - 1, 0) :], *ways[1][max(common - 1, 0) :]}))


def find_pinches(
    network: CurveNetwork, cycles: Sequence[Cycle]
) -> list[tuple[int, tuple[int, ...]]]:
    """Where a surface is closed around a node, and yet other cycles pass it: a pinch.

    Returns (node, cycles around it) for every closed ring of cycles beside which there is
    another cycle at the node.
    """
    corners: dict[int, list[tuple[int, int, int]]] = {}
    for i, cycle in enumerate(cycles):
        for node, before, step in zip(
            network.walk(cycle), (cycle.steps[-1], *cycle.steps), cycle.steps, strict=False
        ):
            if len(cycle.steps) > 1:
                corners.setdefault(node, []).append((before[0], step[0], i))
    found: list[tuple[int, tuple[int, ...]]] = []
    for node, at in sorted(corners.items()):
        around: dict[int, list[tuple[int, int]]] = {}
        for a, b, i in at:
            around.setdefault(a, []).append((b, i))
            around.setdefault(b, []).append((a, i))
        waiting = sorted(around)
        seen: set[int] = set()
        for first in waiting:
            if first in seen:
                continue
            ring, stack = {first}, [first]
            while stack:
                for other, _ in around[stack.pop()]:
                    if other not in ring:
                        ring.add(other)
                        stack.append(other)
            seen |= ring
            members = {i for curve in ring for _, i in around[curve]}
            if all(len(around[curve]) == 2 for curve in ring) and len(members) < len(at):
                found.append((node, tuple(sorted(members))))
    return found


def find_walls(
    network: CurveNetwork,
    cycles: Sequence[Cycle],
    bad: Floats,
    folds: Mapping[tuple[int, int], float],
    chosen: Sequence[int],
) -> list[int]:
    """Find the walls: the candidates that stand on the chosen ones, or on each other.

    Walls stand on curves which bound two cycles already, such as a fin on a sheet, a partition, or
    one of two sheets that cross.

    bad: (k,) the candidates' badness. folds: what pairs of them cost that lie on each other, as
    :func:`patterndb_sketch.surfacing.cycles.measures.price_folds` has it. chosen: numbers of those
    that are.

    The best come first. A wall lies on none of the others, and shares a curve with two of them;
    where all its curves have room it was left out for other reasons.
    """
    users = {c: len(walks) for c, walks in list_users([cycles[i] for i in chosen]).items()}
    beneath: dict[int, set[int]] = {}
    for (i, j), cost in folds.items():
        if cost > 0.0:
            beneath.setdefault(i, set()).add(j)
            beneath.setdefault(j, set()).add(i)
    taken = set(chosen)
    walls: list[int] = []
    for i in np.argsort(bad, kind="stable").tolist():
        if bad[i] > WORST_WALL:
            break
        if i in taken or not taken.isdisjoint(beneath.get(i, ())):
            continue
        curves = cycles[i].curves
        free = [curve for curve in curves if users.get(curve, 0) < SIDES]
        share = total_length(network, free) / total_length(network, curves)
        if len(free) == len(curves) or share < FREE_SHARE:
            continue
        taken.add(i)
        walls.append(i)
        for curve in curves:
            users[curve] = users.get(curve, 0) + 1
    return walls
