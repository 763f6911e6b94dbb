"""Plans: how an outline is to be cut up, and what fills its parts.

A plan foretells how many irregular vertices it has at most: a vertex of the whole can only
be irregular if it is in one of the parts, or if a corner was dropped there. Nothing is
expanded before a plan is carried out.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary, CornerKind
from query.construct.compose import Part, compose, split
from query.construct.lookup import Lookup
from query.construct.pentagon import pentagon_quads
from query.construct.rectangle import rectangle_quads


@dataclass(frozen=True, slots=True)
class TablePart:
    """The lookup's best fill of the outline."""

    outline: Boundary
    strict: bool
    count: int


@dataclass(frozen=True, slots=True)
class PentagonPart:
    """One interior vertex of valence 5 between five convex corners."""

    lengths: tuple[int, int, int, int, int]
    count: int = 1


@dataclass(frozen=True, slots=True)
class RectanglePart:
    """A grid of ``a`` edges along the outline from its vertex ``p``."""

    perimeter: int
    p: int
    a: int
    count: int


@dataclass(frozen=True, slots=True)
class Dropped:
    """The outline less some of its corners: ``then`` is the plan of what is left, whose loop
    begins at vertex ``turn`` of the outline. count: foretold, the dropped corners included."""

    turn: int
    then: Plan
    count: int


@dataclass(frozen=True, slots=True)
class Chord:
    """A chord of ``length`` edges from vertex ``start`` of the outline to vertex ``end``.

    left, right: the plans of the two sides of it, see :func:`query.construct.compose.split`;
    the left one's loop begins ``turn`` vertices on.
    """

    start: int
    end: int
    length: int
    left: Plan
    right: Plan
    count: int
    turn: int = 0


Plan = TablePart | PentagonPart | RectanglePart | Dropped | Chord


def chord(start: int, end: int, length: int, left: Plan, right: Plan, turn: int = 0) -> Chord:
    """A Chord with the count of its two sides."""
    return Chord(start, end, length, left, right, left.count + right.count, turn)


def dropped(boundary: Boundary, keep: Iterable[int]) -> tuple[int, Boundary]:
    """(vertex at which the outline begins, outline) with only some of the corners kept.

    keep: their numbers, ascending, at least one.
    """
    kept = list(keep)
    starts = boundary.side_starts
    at = [starts[i] for i in kept]
    ends = [*at[1:], at[0] + boundary.perimeter]
    lengths = [end - begin for begin, end in zip(at, ends, strict=True)]
    corners: list[CornerKind] = [boundary.corners[i] for i in kept]
    return at[0], Boundary(lengths, corners)


def least(plan: Plan) -> int:
    """The fewest irregular vertices the plan's fill can have; seldom less than its count.

    Vertices that are irregular in one part may meet another part's, or dropped corners, along
    chords and the boundary: then two count once, or not at all. Strict parts have none
    there. Those of one part are all different, and so are corners dropped one after another.
    """
    sizes: list[int] = []
    open_plans: list[tuple[Plan, int]] = [(plan, 0)]
    while open_plans:
        at, drops = open_plans.pop()
        if isinstance(at, Dropped):
            open_plans.append((at.then, drops + at.count - at.then.count))
            continue
        sizes.append(drops)
        if isinstance(at, Chord):
            open_plans += [(at.left, 0), (at.right, 0)]
        elif isinstance(at, RectanglePart) or (isinstance(at, TablePart) and not at.strict):
            sizes.append(at.count)
    total = sum(sizes)
    return plan.count - min(total, 2 * (total - max(sizes)))


def carry_out(plan: Plan, perimeter: int, lookup: Lookup) -> tuple[Int32Array, int]:
    """((q, 4) int32 quads, number of vertices) of the outline with that perimeter.

    Boundary vertices come first, then the chords', then the parts' own.
    """
    parts: list[Part] = []
    fresh = perimeter
    open_plans: list[tuple[Plan, Int32Array]] = [(plan, np.arange(perimeter, dtype=np.int32))]
    while open_plans:
        plan, loop = open_plans.pop()
        match plan:
            case Chord():
                inner = np.arange(fresh, fresh + plan.length - 1, dtype=np.int32)
                fresh += len(inner)
                left, right = split(loop, plan.start, plan.end, inner)
                open_plans.append((plan.left, np.roll(left, -plan.turn) if plan.turn else left))
                open_plans.append((plan.right, right))
            case Dropped():
                open_plans.append((plan.then, np.roll(loop, -plan.turn)))
            case _:
                parts.append(Part(loop, _quads(plan, lookup)))
    return compose(parts, fresh)


def _quads(part: TablePart | PentagonPart | RectanglePart, lookup: Lookup) -> Int32Array:
    match part:
        case TablePart():
            fill = lookup.best(part.outline, strict=part.strict)
            assert fill is not None, f"the lookup counted a fill of {part.outline} but has none"
            return fill.quads
        case PentagonPart():
            return pentagon_quads(part.lengths)
        case RectanglePart():
            return rectangle_quads(part.perimeter, part.p, part.a)
