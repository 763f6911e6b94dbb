"""Plans: how an outline is to be cut up, what fills its parts, and the mesh they make.

A plan foretells how many irregular vertices it has at most: a vertex of the whole can only
be irregular if it is in one of the parts, or if a corner was dropped there. Nothing is
expanded before a plan is carried out. Parts come from a :class:`Lookup`, which knows how good a
part can be, and then the part, or are pentagons and rectangles, which need no table.

The pentagon has one interior vertex, of valence 5; straight lines from it meet every side. Side k
is x_k + x_{k+2} edges long, x_k of them before the line that meets it, so
x_k = S/2 - L_{k+1} - L_{k+2} with S the perimeter: the pentagon exists exactly if S is even and any
two sides next to each other are shorter than half of it. The rectangle is a grid laid anywhere in a
boundary: the construction that never fails.

Two fills across a chord are one fill. Boundary and chord vertices get their numbers first. Then a
part only has to be mapped onto them, however it is turned, and parts join wherever they name the
same vertices.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Protocol

import numpy as np

from patterndb._native.query.construct.plan import find_best_places, split_loop
from patterndb._native.query.expand import expand_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from query.boundary import Boundary, CornerKind


@dataclass(frozen=True, slots=True)
class PartFill:
    """Quads that fill a part.

    quads:       (q, 4) int32, counter-clockwise. Boundary vertices are 0..P-1 in the order
                 of the boundary asked for, 0 where its side 0 begins; interior ones follow.
    n_irregular: vertices, interior and boundary, whose number of quads is not what their
                 place asks for.
    """

    quads: Int32Array
    n_irregular: int


class Lookup(Protocol):
    """The best known fills of boundaries with few sides, such as a table of marked patterns."""

    @property
    def max_sides(self) -> int:
        """It is asked about boundaries of 2 to so many sides; the fewest it may say is 4."""
        ...

    def count(self, boundary: Boundary, *, strict: bool = False) -> int | None:
        """The irregular vertices of the best fill, None where it knows none.

        strict: only fills whose corners are exactly as asked. This is asked often and
        should be quick; nothing need be expanded for it.
        """
        ...

    def best(self, boundary: Boundary, *, strict: bool = False) -> PartFill | None:
        """The best fill, with as many irregular vertices as :meth:`count` says."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class MeshPart:
    """A part of a mesh and the fill that lies in it.

    loop:  (n,) int32, the mesh's vertices along the part's boundary, counter-clockwise.
    quads: (q, 4) int32, counter-clockwise. Vertex i < n is loop[i]; interior ones follow.
    """

    loop: Int32Array
    quads: Int32Array


def compose_parts(parts: Iterable[MeshPart], n_outline: int) -> tuple[Int32Array, int]:
    """((q, 4) int32 quads, number of vertices) of all the parts as one mesh.

    n_outline: boundary and chord vertices; the loops name 0..n_outline - 1. The parts'
    interior vertices get the numbers that follow. Whether the result is a mesh,
    :func:`query.recognition.weld` tells: two parts that are each can still join two vertices by
    two edges.
    """
    pieces: list[Int32Array] = []
    fresh = n_outline
    for part in parts:
        n = len(part.loop)
        inner = int(part.quads.max()) + 1 - n
        name = np.concatenate([part.loop, np.arange(fresh, fresh + inner, dtype=np.int32)])
        pieces.append(name[part.quads])
        fresh += inner
    return np.concatenate(pieces), fresh


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
class DroppedCorners:
    """The outline less some of its corners: ``then`` is the plan of what is left, whose loop
    begins at vertex ``turn`` of the outline. count: foretold, the dropped corners included."""

    turn: int
    then: Plan
    count: int


@dataclass(frozen=True, slots=True)
class Chord:
    """A chord of ``length`` edges from vertex ``start`` of the outline to vertex ``end``.

    left, right: the plans of the two sides of it, see :func:`query.construct.plan.split_loop`;
    the left one's loop begins ``turn`` vertices on.
    """

    start: int
    end: int
    length: int
    left: Plan
    right: Plan
    count: int
    turn: int = 0


Plan = TablePart | PentagonPart | RectanglePart | DroppedCorners | Chord


def draw_chord(start: int, end: int, length: int, left: Plan, right: Plan, turn: int = 0) -> Chord:
    """A Chord with the count of its two sides."""
    return Chord(start, end, length, left, right, left.count + right.count, turn)


def drop_corners(boundary: Boundary, keep: Iterable[int]) -> tuple[int, Boundary]:
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


def count_least(plan: Plan) -> int:
    """The fewest irregular vertices the plan's fill can have; seldom less than its count.

    Vertices that are irregular in one part may meet another part's, or dropped corners, along
    chords and the boundary: then two count once, or not at all. Strict parts have none
    there. Those of one part are all different, and so are corners dropped one after another.
    """
    sizes: list[int] = []
    open_plans: list[tuple[Plan, int]] = [(plan, 0)]
    while open_plans:
        at, drops = open_plans.pop()
        if isinstance(at, DroppedCorners):
            open_plans.append((at.then, drops + at.count - at.then.count))
            continue
        sizes.append(drops)
        if isinstance(at, Chord):
            open_plans += [(at.left, 0), (at.right, 0)]
        elif isinstance(at, RectanglePart) or (isinstance(at, TablePart) and not at.strict):
            sizes.append(at.count)
    total = sum(sizes)
    return plan.count - min(total, 2 * (total - max(sizes)))


def carry_out_plan(plan: Plan, perimeter: int, lookup: Lookup) -> tuple[Int32Array, int]:
    """((q, 4) int32 quads, number of vertices) of the outline with that perimeter.

    Boundary vertices come first, then the chords', then the parts' own.
    """
    parts: list[MeshPart] = []
    fresh = perimeter
    open_plans: list[tuple[Plan, Int32Array]] = [(plan, np.arange(perimeter, dtype=np.int32))]
    while open_plans:
        plan, loop = open_plans.pop()
        match plan:
            case Chord():
                inner = np.arange(fresh, fresh + plan.length - 1, dtype=np.int32)
                fresh += len(inner)
                left, right = split_loop(loop, plan.start, plan.end, inner)
                open_plans.append((plan.left, np.roll(left, -plan.turn) if plan.turn else left))
                open_plans.append((plan.right, right))
            case DroppedCorners():
                open_plans.append((plan.then, np.roll(loop, -plan.turn)))
            case _:
                parts.append(MeshPart(loop, _quads(plan, lookup)))
    return compose_parts(parts, fresh)


def _quads(part: TablePart | PentagonPart | RectanglePart, lookup: Lookup) -> Int32Array:
    match part:
        case TablePart():
            fill = lookup.best(part.outline, strict=part.strict)
            assert fill is not None, f"the lookup counted a fill of {part.outline} but has none"
            return fill.quads
        case PentagonPart():
            return make_pentagon(part.lengths)
        case RectanglePart():
            return make_rectangle(part.perimeter, part.p, part.a)


@lru_cache(maxsize=1024)
def make_pentagon(lengths: tuple[int, int, int, int, int]) -> Int32Array:
    """(q, 4) int32 quads of the pentagon; boundary vertices first, 0 where side 0 begins.

    lengths: edges of the sides, for which the pentagon must exist. Plans of one boundary have
    pentagons in common: the array is kept, and not to be written to.
    """
    twin, chord, before = _make_pentagon_pattern()
    half = sum(lengths) // 2
    widths = np.empty(5, np.int32)
    for k in range(5):
        widths[before[k]] = half - lengths[(k + 1) % 5] - lengths[(k + 2) % 5]
    quads = expand_quads(twin, widths[chord], 2 * half, 0, False)[0]
    quads.flags.writeable = False
    return quads


@cache
def _make_pentagon_pattern() -> tuple[Int32Array, Int32Array, list[int]]:
    """(half-edges, polychord across each, first polychord of every side) of five quads
    around a vertex."""
    quads = [[k, 5 + k, 10, 5 + (k + 4) % 5] for k in range(5)]
    pattern = Pattern.from_disk(QuadMesh.from_quads(quads).twin)
    return pattern.twin(), pattern.polychords().of_edge, [side[0] for side in pattern.label]


def find_best_rectangle(boundary: Boundary) -> tuple[int, int, int]:
    """The rectangle with fewest irregular vertices: (irregular, p, a).

    Its corners fall on the boundary vertices p, p + a, p + P/2 and p + P/2 + a. Among equals
    the nearest to a square. There is always one.
    """
    gain = np.zeros(boundary.perimeter, np.int64)
    if boundary.n_sides:
        # A grid's corner makes a convex corner regular; at a reflex one it only falls on a
        # vertex that is irregular anyway.
        counts = np.array(boundary.corner_counts)
        gain[list(boundary.side_starts[:-1])] = np.where(counts == 1, 2, 1)
    half = boundary.perimeter // 2
    gained, p, a = find_best_places(gain[:half] + gain[half:])
    return boundary.n_sides + 4 - int(gained), int(p), int(a)


def make_rectangle(perimeter: int, p: int, a: int) -> Int32Array:
    """(q, 4) int32 quads of the grid with corners p, p + a, p + P/2 and p + P/2 + a.

    Boundary vertices are 0..perimeter - 1, interior ones follow.
    """
    b = perimeter // 2 - a
    grid = np.empty((b + 1, a + 1), np.int32)
    grid[0] = np.arange(a + 1)
    grid[:, a] = a + np.arange(b + 1)
    grid[b, ::-1] = a + b + np.arange(a + 1)
    grid[::-1, 0] = (2 * a + b + np.arange(b + 1)) % perimeter
    grid = np.where(grid < perimeter, (grid + p) % perimeter, grid).astype(np.int32)
    grid[1:b, 1:a] = perimeter + np.arange((a - 1) * (b - 1)).reshape(b - 1, a - 1)
    corners = (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
    return np.stack([c.ravel() for c in corners], axis=1)
