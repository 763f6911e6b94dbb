"""Pentagon cuts: pentagons cut off an outline, one after another, until few sides are left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb._native.query.construct.pentagon_cuts import find_pentagon_cuts
from query.boundary import Boundary, CornerKind
from query.construct.plan import DroppedCorners, PentagonPart, Plan, draw_chord

#: An outline of fewer sides is not cut: what would be left is looked up as well as it is.
FEWEST_TRIMMED = 6

Pentagon = tuple[int, int, int, int, int]


@dataclass(frozen=True, slots=True)
class _Outline:
    """A Boundary's sides and corners, not checked again at every step."""

    lengths: tuple[int, ...]
    corners: tuple[CornerKind, ...]


@dataclass(frozen=True, slots=True)
class _Cut:
    """A pentagon cut off by a chord from vertex ``start`` to vertex ``end``."""

    start: int
    end: int
    pentagon: Pentagon


@dataclass(frozen=True, slots=True)
class _Drop:
    """A corner dropped; what is left begins at vertex ``turn``."""

    turn: int


@dataclass(frozen=True, slots=True)
class Trimmed:
    """What is left of an outline after some cuts. cost: irregular vertices of what is cut off
    and dropped, 1 for each."""

    rest: Boundary
    steps: tuple[_Cut | _Drop, ...]

    @property
    def cost(self) -> int:
        return len(self.steps)

    def plan(self, rest: Plan) -> Plan:
        """The plan of the whole, from that of what is left."""
        plan = rest
        for step in reversed(self.steps):
            match step:
                case _Cut():
                    length = step.pentagon[4]
                    part = PentagonPart(step.pentagon)
                    plan = draw_chord(step.start, step.end, length, part, plan)
                case _Drop():
                    plan = DroppedCorners(step.turn, plan, plan.count + 1)
        return plan


def trim_outline(
    boundary: Boundary, ample: int, rank: int, most_sides: int, *, drop: bool
) -> list[Trimmed]:
    """What is left of the boundary after each cut, once it has at most ``most_sides`` sides.

    ample: see :func:`patterndb._native.query.construct.pentagon_cuts`; rank: which of the best cuts
    comes first (afterwards the best does). drop: while there are more sides, drop a corner
    beside each side of one edge, and, where there is no cut, the corner between the two
    sides that are shortest together; else stop there.
    """
    outline = _Outline(boundary.lengths, boundary.corners)
    steps: list[_Cut | _Drop] = []
    stages: list[Trimmed] = []
    while len(outline.corners) >= FEWEST_TRIMMED:
        may_drop = drop and len(outline.lengths) > most_sides
        if may_drop and 1 in outline.lengths:
            step, outline = _dropped(outline, _beside(outline, outline.lengths.index(1)))
        else:
            counts = np.array([1 if kind == "convex" else 3 for kind in outline.corners])
            cuts = find_pentagon_cuts(np.array(outline.lengths), counts, ample)
            if len(cuts):
                step, outline = _cut_off(outline, *cuts[min(rank, len(cuts) - 1)].tolist())
                rank = 0
            elif may_drop:
                step, outline = _dropped(outline, _between_shortest(outline))
            else:
                break
        steps.append(step)
        if len(outline.lengths) <= most_sides:
            rest = Boundary(outline.lengths, outline.corners)
            stages.append(Trimmed(rest, tuple(steps)))
    return stages


def _cut_off(outline: _Outline, i: int, u: int, w: int, length: int) -> tuple[_Cut, _Outline]:
    """Cut sides i + 1 and i + 2 off, with u edges of side i and w of side i + 3."""
    perimeter = sum(outline.lengths)
    begin = sum(outline.lengths[:i])
    lengths = outline.lengths[i:] + outline.lengths[:i]
    corners = outline.corners[i:] + outline.corners[:i]
    start = begin + lengths[0] - u
    end = start + u + lengths[1] + lengths[2] + w
    pentagon = (u, lengths[1], lengths[2], w, length)
    rest = _Outline(
        (lengths[3] - w, *lengths[4:], lengths[0] - u, length),
        ("convex", *corners[4:], corners[0], "convex"),
    )
    return _Cut(start % perimeter, end % perimeter, pentagon), rest


def _dropped(outline: _Outline, corner: int) -> tuple[_Drop, _Outline]:
    """Merge sides corner - 1 and corner."""
    lengths, corners = outline.lengths, outline.corners
    if corner == 0:
        merged = (*lengths[1:-1], lengths[-1] + lengths[0])
        return _Drop(lengths[0]), _Outline(merged, corners[1:])
    both = lengths[corner - 1] + lengths[corner]
    merged = (*lengths[: corner - 1], both, *lengths[corner + 1 :])
    return _Drop(0), _Outline(merged, corners[:corner] + corners[corner + 1 :])


def _beside(outline: _Outline, side: int) -> int:
    """The corner between a side and the shorter of its neighbours."""
    after = (side + 1) % len(outline.lengths)
    return side if outline.lengths[side - 1] <= outline.lengths[after] else after


def _between_shortest(outline: _Outline) -> int:
    """The corner between the two neighbours that are shortest together."""
    lengths = outline.lengths
    return min(range(len(lengths)), key=lambda i: lengths[i - 1] + lengths[i])
