"""Patches as triangles: every piece, a closed polyline in space, becomes a triangulated disk.

A whole patch is its boundary, its chords, and one disk for each piece between them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.geometry.leastarea import choose_triangles, tabulate_areas
from patterndb._native.surfacing.tessellation.piece import measure_stretch, solve_heights
from patterndb._native.surfacing.tessellation.planar import (
    clip_ears,
    doubled_area,
    is_simple,
    join,
    lay_lattice,
    make_delaunay,
    smooth,
)
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points, as_points, tangents
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.sampling import Loop, check_spacing

#: How a piece was made: relaxed over a plane, or as the triangulation of least area.
PieceMethod = Literal["laplacian", "area"]

#: The most vertices of a polyline that is triangulated. The table takes 8 n**2 bytes (32 MB
#: here), and time grows with n**3: some three seconds here (benchmarks/minimal_area.py).
MAX_VERTICES = 2_000

#: What is done with a piece that is not relaxed over a plane, and why it is not.
INSTEAD = "triangulated with the least area instead, without points inside"
CROSSES = (
    "the boundary crosses or touches itself in its own plane and in that of its principal axes; "
    + INSTEAD
)

BARRED = f"too thin: its mesh in the plane joins points of one chord; {INSTEAD}"

#: Polygons are on an integer grid, with coordinates from 0 to this: every predicate is exact in 64
#: bits, so that no polygon, however noisy, nearly touching or full of vertices in a row on one
#: line, leads to an inverted triangle. A turn is a difference of two products of two differences:
#: below 2**61. One step is 1e-9 of the polygon's extent.
GRID = 1 << 30

#: The most points inside one polygon: some seconds, and a mesh that is surely a slip.
MAX_INNER = 1_000_000

#: An area vector below this part of the squared extent has no direction: rounding.
NO_AREA = 1e-12


@dataclass(frozen=True, slots=True)
class Tessellation:
    """A closed polyline of m points filled with triangles: one disk.

    inner:     (k, 3) float64, the points inside.
    triangles: (f, 3) int64, f = m - 2 + 2 k: below m a point of the polyline, m + i inner point
               i. They turn as the polyline does.
    method:    "laplacian", or "area" where no plane serves.
    note:      why it is "area", else empty.
    """

    inner: Points = field(repr=False)
    triangles: NDArray[np.int64] = field(repr=False)
    method: PieceMethod
    note: str = ""


def tessellate(
    points: ArrayLike, spacing: float, barred: NDArray[np.bool_] | None = None
) -> Tessellation:
    """Fill a closed polyline with a disk of triangles; no vertices are added on the boundary.

    points: (m, 3), m >= 3, the first not repeated at the end. spacing: about how far the points
    inside are apart, in the units of the points. barred: (m, m) pairs of points that no triangle
    may join, see :func:`minimal_area`. The polyline is projected to the plane of its
    area vector, or to that of its principal axes, the inside meshed there, and the vertices
    inside relaxed in space. If the polyline crosses or touches itself in both planes, it is
    triangulated with the least area, and the note says so; likewise if the mesh in the plane
    joins a barred pair.

    Raises InvalidNetworkError for points that are none, fewer than three, a spacing that is not
    above 0 or makes more than MAX_INNER points, and as :func:`minimal_area` does
    where that is used.

    Source: Abbasinejad et al. 2013, section 2, on their method of 2011: "projects the cycle to
    the plane, meshes the interior, and then relaxes the vertex positions".
    Differs from the paper: which plane, and what if the projection crosses itself, the paper
    leaves open; and vertices move along the plane's normal only, which for these weights is
    what relaxing in space comes to.
    """
    at = as_points(points, "the piece's points", InvalidNetworkError)
    check_spacing(spacing)
    if len(at) < 3:
        raise InvalidNetworkError(
            f"a piece with {len(at)} points encloses nothing; give three or more"
        )
    if len(at) == 3:
        return Tessellation(np.empty((0, 3)), np.array([[0, 1, 2]]), "laplacian")
    seen = project_piece(at)
    if seen is None:
        return _of_least_area(at, barred, CROSSES)
    tail, twin = triangulate_polygon(seen.grid)
    # Where the piece is steep, points in the plane are further apart in space.
    apart = spacing / seen.step / measure_stretch(seen.grid, tail, seen.heights, seen.step)
    mesh, tail, twin = fill_polygon(seen.grid, tail, twin, apart)
    heights = solve_heights(mesh, tail, twin, seen.heights)
    m, triangles = len(at), tail.reshape(-1, 3)
    if barred is not None and _joins(triangles, barred):
        return _of_least_area(at, barred, BARRED)
    return Tessellation(seen.lifted(mesh[m:], heights[m:]), triangles, "laplacian")


def triangulate_flat(points: Points) -> Int64Array | None:
    """Triangulate a closed polyline (m, 3) that lies in a plane: (m - 2, 3), as the polyline turns.

    The constrained Delaunay triangulation, without further vertices. None if the polyline crosses
    or touches itself.
    """
    if len(points) == 3:
        return np.array([[0, 1, 2]])
    seen = project_piece(points)
    return None if seen is None else triangulate_polygon(seen.grid)[0].reshape(-1, 3)


def _of_least_area(at: Points, barred: NDArray[np.bool_] | None, note: str) -> Tessellation:
    return Tessellation(np.empty((0, 3)), minimal_area(at, barred)[0], "area", note)


def _joins(triangles: NDArray[np.int64], barred: NDArray[np.bool_]) -> bool:
    """Has a triangle an edge between two boundary points that are barred and no neighbours?"""
    m = len(barred)
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    outer = (tail < m) & (head < m)
    tail, head = tail[outer], head[outer]
    neighbours = np.isin((tail - head) % m, (1, m - 1))
    return bool((barred[tail, head] & ~neighbours).any())


def minimal_area(
    points: ArrayLike, barred: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.int64], float]:
    """Find the triangulation of a closed polyline with the least summed area, and that area.

    points: (n, 3), n >= 3, the first not repeated at the end. barred: (n, n) bool, symmetric,
    the pairs of points that no triangle may join unless they are neighbours; by default none.
    Returns (n - 2, 3) int64 triangles, which name points and turn as the polyline does, and the
    area in squared units. Among the triangulations of one area (to
    ``TIE`` in rust/geometry/src/leastarea.rs) it takes from edge to
    edge the triangle with the widest angle opposite the edge, then the lowest vertex: where the
    polyline is planar and convex, that is the Delaunay triangulation. The triangles may cross
    one another.

    Raises InvalidNetworkError for points that are none, for fewer than three, for more than
    MAX_VERTICES, and if every triangulation joins a barred pair.

    Source: Barequet and Sharir 1995, "Filling gaps in the boundary of a polyhedron", section 3,
    see rust/geometry/src/leastarea.rs.
    """
    at = as_points(points, "the polyline's points", InvalidNetworkError)
    if len(at) < 3:
        raise InvalidNetworkError(
            f"a closed polyline of {len(at)} points encloses nothing; give three or more"
        )
    if len(at) > MAX_VERTICES:
        raise InvalidNetworkError(
            f"a closed polyline of {len(at):,} points is too long for the triangulation of least "
            f"area; the limit is {MAX_VERTICES:,}, so make the spacing longer"
        )
    # About the middle and of size 1: no digits are lost far from the origin, nothing overflows.
    middle = at - at.mean(axis=0)
    size = float(np.abs(middle).max()) or 1.0
    columns = np.ascontiguousarray((middle / size).T)
    if barred is None:
        barred = np.zeros((1, 1), np.bool_)
    least = tabulate_areas(columns, barred)
    if not math.isfinite(least[0, -1]):
        raise InvalidNetworkError("every triangulation joins two points that are barred")
    triangles, area = choose_triangles(columns, least)
    return triangles, area * size * size


@dataclass(frozen=True, slots=True)
class Projection:
    """A closed polyline in a plane, snapped to a grid, where it is a simple polygon.

    grid:    (m, 2) int64 in 0..GRID, counter-clockwise.
    heights: (m,) float64, of the points above the plane.
    origin:  (3,) where grid point (0, 0) is; axes: (2, 3) orthonormal; normal: (3,), with the
             axes right-handed.
    step:    the length of one step of the grid, in the units of the points.
    """

    grid: Int64Array = field(repr=False)
    heights: NDArray[np.float64] = field(repr=False)
    origin: Points
    axes: Points
    normal: Points
    step: float

    def lifted(self, grid: Int64Array, heights: NDArray[np.float64]) -> Points:
        """(k, 3) points over grid points (k, 2) at these heights (k,)."""
        return self.origin + self.step * grid @ self.axes + heights[:, None] * self.normal


def find_area_vector(points: Points) -> Points:
    """(3,) the area vector of a closed polyline (m, 3): its length is the area of its shadow
    along itself, the largest of any direction (Newell's method)."""
    spokes = points - points.mean(axis=0)
    x, y, z = spokes.T
    after = np.concatenate([spokes[1:], spokes[:1]])
    u, v, w = after.T
    return 0.5 * np.array([y @ w - z @ v, z @ u - x @ w, x @ v - y @ u])


def project_piece(points: Points) -> Projection | None:
    """The polyline (m, 3) in the first plane where it is simple; None if it is in neither.

    The planes are that of its area vector, then that of its two longest principal axes.
    """
    spokes = points - points.mean(axis=0)
    extent = float(np.abs(spokes).max())
    if extent == 0.0:
        return None
    area = find_area_vector(points)
    size = float(np.linalg.norm(area))
    if size > NO_AREA * extent * extent:
        seen = _seen_along(points, spokes, area / size)
        if seen is not None:
            return seen
    least = np.linalg.eigh(spokes.T @ spokes)[1][:, 0]
    # The side from which the polyline runs counter-clockwise.
    return _seen_along(points, spokes, -least if least @ area < 0.0 else least)


def _seen_along(points: Points, spokes: Points, normal: Points) -> Projection | None:
    axes = tangents(normal[None])[0]
    flat = spokes @ axes.T
    steps = np.concatenate([flat[1:], flat[:1]]) - flat
    # A hexagonal lattice looks the same six times in a turn: lay its rows along the boundary.
    # By a power of two, which changes no digit: their sixth powers are neither 0 nor infinite.
    steps = np.ldexp(steps, -math.frexp(float(np.abs(steps).max()))[1])
    edges = steps[:, 0] + 1j * steps[:, 1]
    lengths = np.abs(edges)
    sixfold = (edges**6)[lengths > 0.0] / lengths[lengths > 0.0] ** 5
    turned = np.exp(1j * np.angle(sixfold.sum()) / 6.0)
    axes = np.array([[turned.real, turned.imag], [-turned.imag, turned.real]]) @ axes
    flat = spokes @ axes.T
    low = flat.min(axis=0)
    step = float(np.ptp(flat, axis=0).max()) / GRID
    if step == 0.0:
        return None
    grid = np.rint((flat - low) / step).astype(np.int64)
    if not is_simple(grid):
        return None
    origin = points.mean(axis=0) + low @ axes
    return Projection(grid, spokes @ normal, origin, axes, normal, step)


def triangulate_polygon(grid: Int64Array) -> tuple[Int64Array, Int64Array]:
    """(tail, twin) of the constrained Delaunay triangulation of a simple polygon (m, 2)."""
    n = 3 * (len(grid) - 2)
    tail, twin = np.empty(n, np.int64), np.empty(n, np.int64)
    clip_ears(grid, len(grid), tail, twin)
    make_delaunay(grid, tail, twin, len(grid) - 2)
    return tail, twin


def fill_polygon(
    grid: Int64Array, tail: Int64Array, twin: Int64Array, spacing: float
) -> tuple[Int64Array, Int64Array, Int64Array]:
    """A triangulated polygon with points inside, about ``spacing`` steps of the grid apart.

    grid: (m, 2) int64, simple, counter-clockwise. tail, twin: its triangulation, see
    :func:`triangulate_polygon`. Returns the points (m + k, 2), the polygon's first, and the
    constrained Delaunay triangulation of all of them. k is 0 where the polygon has no room.

    Raises InvalidNetworkError for more than MAX_INNER points.
    """
    wanted = doubled_area(grid) / (math.sqrt(3.0) * spacing * spacing)
    if wanted > MAX_INNER:
        raise InvalidNetworkError(
            f"the spacing would make {wanted:.3g} points inside one piece; the limit is "
            f"{MAX_INNER:,}, so make it longer"
        )
    inner = lay_lattice(grid, spacing)
    if not len(inner):
        return grid, tail, twin
    at = np.concatenate([grid, inner])
    room = np.empty((2, 3 * (len(grid) - 2 + 2 * len(inner))), np.int64)
    room[0, : len(tail)], room[1, : len(twin)] = tail, twin
    joined = join(at, len(grid), room[0], room[1])
    assert joined == len(at), "a point within the polygon is in none of its triangles"
    smooth(at, len(grid), room[0], room[1])
    return at, room[0], room[1]


@dataclass(frozen=True, slots=True)
class PatchMesh:
    """A loop of n vertices filled with triangles, piece by piece.

    points:  (k, 3) float64, the vertices beyond the loop's: those along chords, then those
             inside pieces.
    faces:   for every piece its triangles (f, 3) int64: below n a position of the loop, n + i
             point i. All turn as the loop does; pieces share the vertices along their chords.
    methods: for every piece how it was made.
    notes:   what was given up, naming the piece; empty if nothing was.
    """

    points: Points = field(repr=False)
    faces: tuple[NDArray[np.int64], ...] = field(repr=False)
    methods: tuple[PieceMethod, ...]
    notes: tuple[str, ...] = ()

    @property
    def triangles(self) -> NDArray[np.int64]:
        """(f, 3) the triangles of all pieces, in the pieces' order."""
        return np.concatenate(self.faces)

    def vertices(self, loop: Loop) -> Points:
        """(n + k, 3) all vertices that the faces name; loop: the one it was made of."""
        return np.concatenate([loop.points, self.points])


def tessellate_patch(
    loop: Loop, chords: Int64Array, pieces: Sequence[ArrayLike], spacing: float
) -> PatchMesh:
    """Fill a loop that chords cut into pieces; see :func:`tessellate` for one piece.

    chords: (m, 2) int64 positions of the loop, no two chords alike and none between neighbours.
    pieces: the positions around each piece, in the loop's sense: from one to the next lies an
    edge of the loop or a chord. With no chords there is one piece, the whole loop. spacing:
    about how far new vertices are apart, in the units of the points. Chords stay straight, in
    edges of equal length, at least one; both pieces beside a chord have the same vertices
    along it.

    Raises InvalidNetworkError for pieces that do not fit: every edge of the loop must be in one
    piece, every chord in two, once in each direction. And as :func:`tessellate` does.
    """
    check_spacing(spacing)
    n = len(loop.points)
    inside, along = _sampled_chords(loop, chords, spacing)
    points = [np.empty((0, 3)), *inside]
    outline = np.concatenate([loop.points, *points])
    count = len(outline)
    faces: list[NDArray[np.int64]] = []
    methods: list[PieceMethod] = []
    notes: list[str] = []
    for number, (around, barred) in enumerate(_outlines(pieces, along, n)):
        made = tessellate(outline[around], spacing, barred)
        names = np.concatenate([around, count + np.arange(len(made.inner))])
        faces.append(names[made.triangles])
        methods.append(made.method)
        if made.note:
            notes.append(f"piece {number}: {made.note}")
        points.append(made.inner)
        count += len(made.inner)
    return PatchMesh(np.concatenate(points), tuple(faces), tuple(methods), tuple(notes))


def patch_of_least_area(loop: Loop) -> PatchMesh:
    """Fill a loop with its triangulation of least area, in one piece without new vertices.

    Raises InvalidNetworkError as :func:`minimal_area` does.
    """
    return PatchMesh(np.empty((0, 3)), (minimal_area(loop.points)[0],), ("area",))


def _sampled_chords(
    loop: Loop, chords: NDArray[np.int64], spacing: float
) -> tuple[list[Points], dict[tuple[int, int], list[int]]]:
    """The points within every chord, and per direction of a chord the vertices along it, the
    first included and the last not."""
    inside: list[Points] = []
    along: dict[tuple[int, int], list[int]] = {}
    count = len(loop.points)
    for a, b in chords.tolist():
        ends = loop.points[[a, b]]
        edges = max(1, round(float(np.linalg.norm(ends[1] - ends[0])) / spacing))
        within = list(range(count, count + edges - 1))
        inside.append(sample_polyline(ends, edges)[1:-1])
        along[a, b] = [a, *within]
        along[b, a] = [b, *reversed(within)]
        count += len(within)
    return inside, along


def _outlines(
    pieces: Sequence[ArrayLike], along: dict[tuple[int, int], list[int]], n: int
) -> list[tuple[NDArray[np.int64], NDArray[np.bool_] | None]]:
    """Around every piece the vertices (m,), those of chords included, and the pairs of them
    (m, m) that lie on one chord; checks that pieces fit.

    No triangle may join such a pair: the one on the chord's other side might join it too, and
    four triangles would meet there.
    """
    free = set(along) | {(i, (i + 1) % n) for i in range(n)}
    outlines: list[tuple[NDArray[np.int64], NDArray[np.bool_] | None]] = []
    for number, piece in enumerate(pieces):
        around = np.asarray(piece, np.int64).tolist()
        vertices: list[int] = []
        straight: list[tuple[int, int]] = []
        for a, b in zip(around, around[1:] + around[:1], strict=True):
            if (a, b) not in free:
                raise InvalidNetworkError(
                    f"piece {number} goes from position {a} to {b}, where there is neither an "
                    "edge of the loop nor a chord, or another piece goes too; list the "
                    "positions of pieces in the loop's sense"
                )
            free.remove((a, b))
            part = along.get((a, b), [a])
            if len(part) > 1:
                straight.append((len(vertices), len(part)))
            vertices += part
        barred = np.zeros((len(vertices),) * 2, np.bool_) if straight else None
        for first, edges in straight:
            on_chord = (first + np.arange(edges + 1)) % len(vertices)
            if barred is not None:
                barred[np.ix_(on_chord, on_chord)] = True
        outlines.append((np.array(vertices), barred))
    if free:
        a, b = min(free)
        raise InvalidNetworkError(f"no piece goes from position {a} to {b}; a piece is missing")
    return outlines
