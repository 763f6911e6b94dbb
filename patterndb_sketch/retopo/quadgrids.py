"""Cut a mesh of quads into regular grids, along its separatrices.

Read :func:`check_quads` (the mesh, checked, and how its quads are joined),
:func:`mark_separatrices` (the edges that cut it into grids), :func:`follow_curves` (these as
sequences of edges from corner to corner) and :func:`read_grid` (the vertices of one grid, with
:func:`make_grid_choice`, the fill that is such a grid).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.core.halfedge import border_vertices, fans
from patterndb._native.retopo.quadgrids import cut_regular, follow_marked, read_grid, run_all
from patterndb.core.halfedge import Int32Array, prev_edge, sort_by_edge
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Bools, Points
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling.choice import Choice
from patterndb_sketch.retopo.network import HalfChain
from query.expand import expand_pattern
from query.fill import Fill


@dataclass(frozen=True, slots=True, eq=False)
class Quads:
    """A manifold mesh of quads, all turned alike; half-edges as in :mod:`patterndb.core.halfedge`.

    points: (v, 3) float64, and quads: (q, 4) int32, as they were given; where other faces part the
            quads at a vertex, each further fan of quads has a vertex of its own, after all others.
    twin:   (4q,) int32, -1 at a border, and at faces that are no quads.
    valence: (v,) int32, quads at every vertex; 0 where none is.
    border: (v,) bool, is it on a border, or at a face that is no quad?
    given:  (v,) int32, the vertex as it was given: its own number but for those of further fans.
    others: the faces that are no quads, as they were given.
    held:   (v,) bool, vertices of these.
    """

    points: Points
    quads: Int32Array
    twin: Int32Array
    valence: Int32Array
    border: NDArray[np.bool_]
    given: Int32Array
    others: tuple[tuple[int, ...], ...]
    held: NDArray[np.bool_]

    @property
    def tail(self) -> Int32Array:
        """(4q,) int32, the vertex that a half-edge leaves."""
        return self.quads.ravel()

    @property
    def n_given(self) -> int:
        """How many vertices were given."""
        return int(self.given.max()) + 1

    @property
    def irregular(self) -> NDArray[np.bool_]:
        """(v,) bool, vertices whose number of quads is not 4 inside, or 2 on a border, and those of
        other faces.

        Differs from the program of Takayama et al. 2013, which takes a border's vertices of three
        quads for regular: curves would end on the inside of others.
        """
        wanted = np.where(self.border, 2, 4)
        return ((self.valence != wanted) | self.held) & (self.valence > 0)


def check_quads(
    vertices: ArrayLike, quads: ArrayLike, others: Sequence[Sequence[int]] = ()
) -> Quads:
    """Check (v, 3) vertices and (q, 4) quads, counter-clockwise seen from outside.

    others: faces that are no quads, turned as these are: each three vertices or more.
    Raises InvalidRetopoError, which names the face, edge or vertex, for arrays of another shape,
    indices out of range, coordinates that are not finite, faces that repeat a vertex, edges of
    more than two faces or of two that run alike, and vertices where several fans of faces meet.
    """
    points = np.array(vertices, np.float64)
    array = np.asarray(quads)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidRetopoError(f"the mesh's vertices must be (v, 3), got {points.shape}")
    if array.ndim != 2 or array.shape[1] != 4 or not np.issubdtype(array.dtype, np.integer):
        raise InvalidRetopoError(
            f"the mesh's faces must be quads, whole numbers (q, 4), got {array.dtype} "
            f"{array.shape}; give triangles and larger faces as others"
        )
    if not len(array):
        raise InvalidRetopoError("the mesh has no quads; there is nothing to import")
    wrong = np.flatnonzero(((array < 0) | (array >= len(points))).any(axis=1))
    if len(wrong):
        raise InvalidRetopoError(
            f"quad {wrong[0]} {array[wrong[0]].tolist()} names a vertex outside "
            f"0..{len(points) - 1}"
        )
    array = np.ascontiguousarray(array, np.int32)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InvalidRetopoError(f"vertex {bad[0]} of the mesh is not finite")
    ordered = np.sort(array, axis=1)
    again = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(again):
        raise InvalidRetopoError(
            f"quad {again[0]} repeats a vertex: {array[again[0]].tolist()}; it is a triangle, or "
            "less, and cannot be imported"
        )
    kept = _check_others(others, len(points))
    twin = _find_twins(array, kept)
    vertex, n_fans = fans(twin)
    source = np.empty(n_fans, np.int32)
    source[vertex] = array.ravel()
    held = np.zeros(len(points), np.bool_)
    held[[v for face in kept for v in face]] = True
    _, first, times = np.unique(source, return_index=True, return_counts=True)
    shared = source[first[times > 1]]
    if not held[shared].all():
        refuse_fans(int(shared[~held[shared]][0]))
    # The first fan of quads at a vertex keeps its number.
    further = np.setdiff1d(np.arange(n_fans), first)
    given = np.concatenate([np.arange(len(points)), source[further]]).astype(np.int32)
    own = source.copy()
    own[further] = len(points) + np.arange(len(further))
    array = np.ascontiguousarray(own[vertex].reshape(-1, 4), np.int32)
    border = np.zeros(len(given), np.bool_)
    border[own] = border_vertices(twin, vertex, n_fans)
    valence = np.bincount(array.ravel(), minlength=len(given)).astype(np.int32)
    return Quads(points[given], array, twin, valence, border, given, kept, held[given])


def _check_others(others: Sequence[Sequence[int]], n_vertices: int) -> tuple[tuple[int, ...], ...]:
    kept: list[tuple[int, ...]] = []
    for face in others:
        at = tuple(int(v) for v in face)
        if len(at) < 3:
            raise InvalidRetopoError(f"face {list(at)} has {len(at)} corners; a face has 3 or more")
        if min(at) < 0 or max(at) >= n_vertices:
            raise InvalidRetopoError(f"face {list(at)} names a vertex outside 0..{n_vertices - 1}")
        if len(set(at)) < len(at):
            raise InvalidRetopoError(
                f"face {list(at)} repeats a vertex; take it apart where it does"
            )
        kept.append(at)
    return tuple(kept)


def refuse_fans(vertex: int) -> NoReturn:
    raise InvalidRetopoError(
        f"faces meet at vertex {vertex} without an edge between them: it joins several fans; "
        "split it, one vertex to each"
    )


def _find_twins(quads: Int32Array, others: Sequence[tuple[int, ...]]) -> Int32Array:
    """(4q,) the half-edge on the other side, -1 where that is no quad's; raises for edges that are
    none of two faces, of which the quads are the first."""
    around = [np.array(face, np.int64) for face in others]
    tail = np.concatenate([quads.ravel().astype(np.int64), *around])
    head = np.roll(quads, -1, axis=1).ravel().astype(np.int64)
    head = np.concatenate([head, *(np.roll(face, -1) for face in around)])
    owner = np.repeat(np.arange(len(others)), [len(face) for face in others])

    def name(half: int) -> str:
        inside = half < 4 * len(quads)
        return (
            f"quad {half // 4}" if inside else f"face {list(others[owner[half - 4 * len(quads)]])}"
        )

    order, start = sort_by_edge(tail, head)
    first, uses = start[:-1], np.diff(start)
    many = np.flatnonzero(uses > 2)
    if len(many):
        at = order[first[many[0]]]
        raise InvalidRetopoError(
            f"the edge between vertices {tail[at]} and {head[at]} has {uses[many[0]]} faces; at "
            "most two can share one, so split the vertices there"
        )
    twin = np.full(len(tail), -1, np.int32)
    one = order[first[uses == 2]]
    two = order[first[uses == 2] + 1]
    alike = np.flatnonzero(tail[one] == tail[two])
    if len(alike):
        a, b = one[alike[0]], two[alike[0]]
        raise InvalidRetopoError(
            f"{name(int(a))} and {name(int(b))} run alike along the edge between vertices "
            f"{tail[a]} and {head[a]}: one of them is turned over; orient all faces alike"
        )
    twin[one], twin[two] = two, one
    twin = twin[: 4 * len(quads)]
    return np.where(twin < 4 * len(quads), twin, np.int32(-1))


def mark_separatrices(mesh: Quads) -> tuple[Bools, Bools]:
    """(4q,) bool, half-edges on curves between patches; (v,) bool, vertices that are corners.

    From every irregular vertex edges are followed straight ahead, to an irregular vertex or the
    border; border edges count too. A part without an irregular vertex is cut along one strip
    each way. All edges of a corner are on curves, and a curve passes every other vertex straight:
    what is left is grids of w x h quads, never with a T-junction.

    Differs from the program of Takayama et al. 2013: parts without irregular vertices are cut.
    """
    marked = mesh.twin < 0
    run_all(mesh.twin, mesh.tail, mesh.irregular, mesh.border, marked)
    cut_regular(mesh.twin, mesh.tail, mesh.irregular, mesh.border, marked)
    unmarked = np.zeros(len(mesh.points), np.bool_)
    unmarked[mesh.tail[~marked]] = True
    unmarked[np.roll(mesh.quads, -1, axis=1).ravel()[~marked]] = True
    return marked, ~unmarked & (mesh.valence > 0)


@dataclass(frozen=True, slots=True, eq=False)
class GridCurves:
    """Of c curves; half-curve 2 k runs along curve k, 2 k + 1 back.

    edges: (m,) int32 half-edges, those of curve k from start[k] to start[k + 1], in order.
    start: (c + 1,) int32.
    half:  (4q,) int32 the half-curve that a half-edge is on, -1 for none.
    """

    edges: Int32Array
    start: Int32Array
    half: Int32Array

    def __len__(self) -> int:
        return len(self.start) - 1

    def of(self, curve: int) -> Int32Array:
        """(k,) half-edges along a curve."""
        return self.edges[self.start[curve] : self.start[curve + 1]]

    def count(self, half: HalfChain) -> int:
        """Edges along a half-curve."""
        return int(self.start[(half >> 1) + 1] - self.start[half >> 1])

    def first(self, mesh: Quads, half: HalfChain) -> int:
        """The half-edge that a half-curve begins with."""
        along = self.of(half >> 1)
        return int(mesh.twin[along[-1]]) if half & 1 else int(along[0])


def follow_curves(mesh: Quads, marked: NDArray[np.bool_], corner: NDArray[np.bool_]) -> GridCurves:
    """Follow marked edges from corner to corner."""
    return GridCurves(*follow_marked(mesh.twin, mesh.tail, marked, corner))


def list_corner_curves(
    mesh: Quads, corner: NDArray[np.bool_], found: GridCurves
) -> dict[int, list[int]]:
    """The half-curves that leave every corner, by vertex, counter-clockwise; of a vertex of other
    faces those of one fan of quads alone.

    At a border the first has the mesh on its left, and the last on its right.
    """
    twin, tail = mesh.twin, mesh.tail
    leaving = np.full(len(mesh.points), -1, np.int64)
    every = np.arange(len(tail))
    leaving[tail[::-1]] = every[::-1]
    rim = every[twin < 0]
    leaving[tail[rim]] = rim
    result: dict[int, list[int]] = {}
    for vertex in np.flatnonzero(corner).tolist():
        first = h = int(leaving[vertex])
        ends: list[int] = []
        while True:
            ends.append(int(found.half[h]))
            back = int(prev_edge(h))
            h = int(twin[back])
            if h < 0:
                ends.append(int(found.half[back]) ^ 1)
            if h < 0 or h == first:
                break
        result[vertex] = ends
    return result


#: Grids of so many sizes are kept.
KEPT = 4096


@lru_cache(maxsize=KEPT)
def make_grid_choice(w: int, n: int) -> tuple[Choice, Int32Array]:
    """The fill of a patch of w x n edges by a regular grid, as the query engine gives it, taken by
    the user; and (n + 1, w + 1) the numbers of its vertices, row 0 along side 0."""
    fill = make_grid_fill(w, n)
    tail = fill.quads.ravel()
    head = np.roll(fill.quads, -1, axis=1).ravel()
    number = {(int(a), int(b)): h for h, (a, b) in enumerate(zip(tail, head, strict=True))}
    twin = np.array(
        [number.get((int(b), int(a)), -1) for a, b in zip(tail, head, strict=True)], np.int32
    )
    vertices = read_grid(twin, tail, number[0, 1], w, n)
    vertices.flags.writeable = False
    return Choice.of(fill, "user"), vertices


def make_grid_fill(w: int, n: int) -> Fill:
    """The pattern of one quad, expanded to w x n."""
    return expand_pattern(Pattern.from_code(np.zeros(4, np.uint16)), (w, n))
