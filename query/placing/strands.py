"""Strands: the strips of quads of a fill, one quad wide, from boundary edge to boundary edge.

A :class:`Strand` is one of them as a whole; :func:`count_edges_off` counts on the fill itself how
far its strands are off strokes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.placing.strands import find_far_ends, walk
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from query.errors import InvalidQueryError
from query.stroke import BoundaryEdge, Stroke

#: (low, high): positions of boundary edges around the boundary, low to high - 1.
Span = tuple[int, int]


class SidedDisk(Protocol):
    """A quad disk whose boundary has sides: what placing needs of a :class:`query.fill.Fill`.

    quads:      (q, 4) int32, counter-clockwise, the boundary's vertices 0..P - 1 first.
    n_vertices: number of vertices.
    lengths:    edges of every side; perimeter: P, their sum.
    """

    @property
    def quads(self) -> Int32Array: ...
    @property
    def n_vertices(self) -> int: ...
    @property
    def lengths(self) -> tuple[int, ...]: ...
    @property
    def perimeter(self) -> int: ...


@dataclass(frozen=True, slots=True, eq=False)
class Strand:
    """A strand of a fill.

    quads: (k,) int32, the quads passed in order; one that the strand crosses twice is there
           twice.
    edges: (m, 2) int32, the vertices of the transversal edges in order, those on the left of
           the way first. m = k + 1, and the first and last are boundary edges; for a loop
           m = k, and the first edge comes again after the last.
    ends:  the boundary edges (side, edge) where it begins and ends; None for a loop.
    """

    quads: Int32Array
    edges: Int32Array
    ends: tuple[BoundaryEdge, BoundaryEdge] | None

    @property
    def is_loop(self) -> bool:
        return self.ends is None

    def midline(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """(m, 3) midpoints of the transversal edges; a loop's last joins its first.

        vertices: (v, 3). The paper calls it the polychord's skeleton.
        """
        return vertices[self.edges].mean(axis=1)


def find_strand(fill: SidedDisk, edge: BoundaryEdge) -> Strand:
    """The strand that begins at a boundary edge of a fill.

    Raises InvalidQueryError if the boundary has no such edge.
    """
    at = locate_edge(fill.lengths, edge)
    beside = Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
    half_edges = walk_strand(beside.twin, int(beside.border[at]))
    return _strand(fill, half_edges, (edge, _edge_of(fill, beside, half_edges)))


def find_loops(fill: SidedDisk) -> list[Strand]:
    """All strands of a fill that are loops."""
    beside = Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
    return [_strand(fill, chain, None) for chain in list_loop_chains(beside.twin)]


def walk_strand(twin: Int32Array, first: int) -> Int32Array:
    """(m,) the half-edges of the transversal edges from ``first`` on, each entering a quad
    but for the last one of an open strand, which is the far side of the last quad."""
    return walk(twin, first)


def list_loop_chains(twin: Int32Array) -> list[Int32Array]:
    """The half-edges of the transversal edges of every loop strand."""
    crossed = np.zeros(len(twin), np.bool_)
    for h in np.flatnonzero(twin < 0).tolist():
        if not crossed[h]:
            chain = walk(twin, h)
            crossed[chain] = crossed[chain ^ 2] = True
    found: list[Int32Array] = []
    while not crossed.all():
        chain = walk(twin, int(crossed.argmin()))
        crossed[chain] = crossed[chain ^ 2] = True
        found.append(chain)
    return found


def find_strand_edges(quads: Int32Array, chain: Int32Array) -> Int32Array:
    """(m, 2) the vertices of a walk's transversal edges, left of the way first."""
    corners = quads.ravel()
    ends = np.stack([corners[(chain & ~3) | ((chain + 1) & 3)], corners[chain]], axis=1)
    if len(chain) > 1 and chain[-1] == chain[-2] ^ 2:
        # The far side of the last quad runs against those by which quads are entered.
        ends[-1] = ends[-1, ::-1]
    return np.ascontiguousarray(ends)


def locate_edge(lengths: tuple[int, ...], edge: BoundaryEdge) -> int:
    """The position around the boundary of an edge given as (side, edge)."""
    side, at = edge
    if not (0 <= side < len(lengths) and 0 <= at < lengths[side]):
        raise InvalidQueryError(
            f"there is no edge {at} of side {side}; the sides have {list(lengths)} edges, "
            "numbered from 0 as the sides are"
        )
    return sum(lengths[: edge[0]]) + edge[1]


def locate_span(lengths: tuple[int, ...], edge: BoundaryEdge, tolerance: int) -> Span:
    """The positions of the edges at most ``tolerance`` from an edge on the same side."""
    side, at = edge
    start = sum(lengths[:side])
    low, high = max(at - tolerance, 0), min(at + tolerance, lengths[side] - 1)
    return start + low, start + high + 1


def _edge_of(fill: SidedDisk, beside: Neighbours, chain: Int32Array) -> BoundaryEdge:
    return _locate_position(fill, int(np.flatnonzero(beside.border == chain[-1])[0]))


def _locate_position(fill: SidedDisk, at: int) -> BoundaryEdge:
    starts = np.r_[0, np.cumsum(fill.lengths)]
    side = int(np.searchsorted(starts, at, side="right")) - 1
    return side, at - int(starts[side])


def _strand(
    fill: SidedDisk, chain: Int32Array, ends: tuple[BoundaryEdge, BoundaryEdge] | None
) -> Strand:
    quads = chain // 4 if ends is None else chain[:-1] // 4
    return Strand(quads.astype(np.int32), find_strand_edges(fill.quads, chain), ends)


def count_edges_off(fill: SidedDisk, strokes: Sequence[Stroke], tolerance: int) -> int | None:
    """The fewest edges by which distinct strands miss all strokes; None where they cannot lie
    on them within the tolerance, or there are fewer loops than loop strokes."""
    beside = Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
    n_loops = sum(stroke.is_loop for stroke in strokes)
    if n_loops and len(list_loop_chains(beside.twin)) < n_loops:
        return None
    choices = _list_choices(fill, strokes, tolerance, beside)
    total = 0
    for name, choice in zip(assign_strands(choices), choices, strict=True):
        if name is None:
            return None
        total += choice[name]
    return total


def find_carriers(
    fill: SidedDisk, strokes: Sequence[Stroke], tolerance: int
) -> list[Strand | None]:
    """Find a strand for every stroke, each its own, that miss them by the fewest edges in all.

    None for a stroke that none can carry within the tolerance, or a loop too many.
    """
    beside = Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
    names = iter(assign_strands(_list_choices(fill, strokes, tolerance, beside)))
    loops = iter(find_loops(fill))
    found: list[Strand | None] = []
    for stroke in strokes:
        if stroke.is_loop:
            found.append(next(loops, None))
            continue
        name = next(names)
        found.append(None if name is None else find_strand(fill, _locate_position(fill, name)))
    return found


def _list_choices(
    fill: SidedDisk, strokes: Sequence[Stroke], tolerance: int, beside: Neighbours
) -> list[dict[int, int]]:
    """By how many edges each strand misses a stroke, for those near enough; for every stroke that
    is no loop. A strand goes by the smaller of the positions of its ends."""
    far = find_far_ends(beside.twin, beside.border).tolist()
    side_of = [side for side, length in enumerate(fill.lengths) for _ in range(length)]
    choices: list[dict[int, int]] = []
    for stroke in strokes:
        if stroke.start is None or stroke.end is None:
            continue
        near, end = locate_edge(fill.lengths, stroke.start), locate_edge(fill.lengths, stroke.end)
        found: dict[int, int] = {}
        for at in range(near - tolerance, near + tolerance + 1):
            if not 0 <= at < fill.perimeter or side_of[at] != side_of[near]:
                continue
            other = far[at]
            if side_of[other] != side_of[end] or abs(other - end) > tolerance:
                continue
            name = min(at, other)
            off = abs(at - near) + abs(other - end)
            found[name] = min(off, found.get(name, off))
        choices.append(found)
    return choices


def assign_strands(choices: Sequence[Mapping[int, float]]) -> list[int | None]:
    """Give each stroke a different strand, for as many as can be, at the least sum.

    choices: for every stroke what each strand that may carry it costs, by the strand's name.
    """
    nearest = [min(choice, key=lambda name: choice[name], default=None) for choice in choices]
    if len({name for name in nearest if name is not None}) == sum(map(bool, choices)):
        return nearest
    from scipy.optimize import linear_sum_assignment

    names = sorted({name for choice in choices for name in choice})
    costs = [cost for choice in choices for cost in choice.values()]
    # A column of its own for every stroke stands for no strand: dearer than all strands.
    cost = np.full((len(choices), len(names) + len(choices)), 2.0 * sum(costs) + 1.0)
    for row, choice in enumerate(choices):
        for column, name in enumerate(names):
            cost[row, column] = choice[name] if name in choice else 2.0 * cost[row, -1]
    _, columns = linear_sum_assignment(cost)
    return [names[column] if column < len(names) else None for column in columns.tolist()]
