"""Place the fills of one hole: smoothly, in a plane, or on a surface, and along strokes.

:func:`place_fill` places a fill smoothly and measures it. Inner vertices minimise the umbrella
Laplacian over inner vertices and those of the loop, the mesh around being held: bending energy, so
that a fill goes on as its neighbourhood arrives. (Harmonic placing, which minimises stretch alone,
lets rings of regular quads sag. It is taken where fewer quads are flipped by it.)

A :class:`HoleProjector` moves such fills where they are to lie. What it needs of
:mod:`query.placing` is imported when it moves one: ranking fills that no mesh surrounds needs
measures alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.projection import laplacian_rows, measure_fill
from patterndb._native.query.holes.projection import neighbours as _neighbours
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface
from query.holes.caps import FlatCap, RimPlane, find_cap
from query.holes.loops import Hole
from query.holes.neighbourhood import Neighbourhood
from query.holes.options import HoleOptions
from query.placing.laplace import HeldQuads, lay_flat
from query.placing.leastsquares import LeastSquares, join_entries, solve_square
from query.placing.untangle import untangle
from query.stroke import Stroke

if TYPE_CHECKING:
    from query.placing.region import Region

#: What is added to the normal equations' diagonal: loops without surroundings leave a plane open.
RIDGE = 1e-9

#: The numbers of :func:`measure_fill`, in order.
MEASURES = (
    "edge_mean",
    "edge_spread",
    "loop_edge_ratio",
    "least_jacobian",
    "mean_jacobian",
    "flipped",
    "angles",
    "opposite_edges",
    "area_spread",
    "area_mean",
    "straight_loop",
    "straight_inner",
    "irregular_angles",
    "normal_jump",
    "loop_angles",
    "worst_loop_angle",
    "bending",
    "worst_aspect",
    "mean_aspect",
    "worst_angle",
    "turned",
    "least_outward",
    "worst_fold",
)


#: Where the bending energy is among them, which the solver knows.
BENDING = MEASURES.index("bending")

#: A rim that lies farther off the surface than this part of its mean edge encloses nothing there.
FAR_OFF = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class PlacedFill:
    """points: (k, 3) inner vertices in the fill's order. measures: see MEASURES. flipped: quads
    that are folded back onto the faces across two of their edges."""

    points: Floats
    measures: Floats
    flipped: int


def place_fill(around: Neighbourhood, quads: Int32Array, n_vertices: int) -> PlacedFill:
    """Place the inner vertices of a fill and measure it.

    quads: (q, 4) int32, loop vertices 0..L-1 in order, inner ones L..n_vertices - 1.
    """
    n_loop = len(around.outside)
    n_outer = len(around.points)
    inner = n_vertices - n_loop
    shifted = np.where(quads >= n_loop, quads - n_loop + n_outer, quads).astype(np.int64)
    points = np.empty((n_outer + inner, 3))
    points[:n_outer] = around.points
    points[n_outer:] = around.points[:n_loop].mean(axis=0)
    start, beside = _neighbours(
        around.corners.astype(np.int64), around.offsets, shifted, n_outer + inner
    )
    placed: PlacedFill | None = None
    for harmonic in (False, True):
        bending = 0.0
        if inner:
            row, column, weight, right = laplacian_rows(points, start, beside, n_outer, n_loop)
            rows = join_entries(row, column, weight, (len(right), inner))
            if harmonic:
                solved = solve_square(rows[:inner], right[:inner])
            else:
                solved = LeastSquares(rows, RIDGE).solve(right)
            rest = rows @ solved - right
            bending = float(np.cumsum(rest * rest)[-1])
            points[n_outer:] = solved
        measures, n_flipped = _measure_there(around, points, shifted)
        n_rows = max(inner + n_loop, 1)
        measures[BENDING] = np.log(bending / (around.scale**2) / n_rows + 1e-6)
        if placed is None or n_flipped < placed.flipped:
            placed = PlacedFill(points[n_outer:].copy(), measures, n_flipped)
        if not n_flipped or not inner:
            break
    assert placed is not None
    return placed


def mend_fill(around: Neighbourhood, quads: Int32Array, placed: PlacedFill) -> PlacedFill:
    """Untangle a fill that has quads turned over, if fewer are then; its measures stay."""
    n, n_vertices = len(around.outside), len(around.outside) + len(placed.points)
    if not placed.flipped or not len(placed.points):
        return placed
    held = HeldQuads.of(quads, n_vertices, n)
    vertices = np.vstack([around.points[:n], placed.points])
    normals = units(held.place_harmonic(around.normals))
    points = untangle(held, vertices, normals)[n:]
    count = count_flipped(around, quads, points)
    return PlacedFill(points, placed.measures, count) if count < placed.flipped else placed


def count_flipped(around: Neighbourhood, quads: Int32Array, inner: Floats) -> int:
    """Count the quads of a fill that are turned over where its inner vertices (k, 3) lie."""
    n_loop, n_outer = len(around.outside), len(around.points)
    shifted = np.where(quads >= n_loop, quads - n_loop + n_outer, quads).astype(np.int64)
    return _measure_there(around, np.vstack([around.points, inner]), shifted)[1]


def _measure_there(
    around: Neighbourhood, points: Floats, quads: NDArray[np.int64]
) -> tuple[Floats, int]:
    """Measure a fill by the points of the mesh around and its own after them."""
    return measure_fill(
        points,
        quads,
        around.corners.astype(np.int64),
        around.offsets,
        around.normals,
        around.beyond,
        len(around.outside),
        len(around.points),
        around.scale,
        around.area,
    )


@dataclass(frozen=True, slots=True, eq=False)
class LoopDisk:
    """A fill of a loop as a quad disk of one side; see :class:`query.placing.strands.SidedDisk`."""

    quads: Int32Array
    n_vertices: int
    perimeter: int

    @property
    def lengths(self) -> tuple[int, ...]:
        """The one side, all around."""
        return (self.perimeter,)


@dataclass(frozen=True, slots=True, eq=False)
class HoleProjector:
    """Where the fills of one hole are placed, and the strokes that they are pulled onto.

    around: the hole's boundary and the mesh around it.
    surface: what new vertices lie on, or None.
    region: what the boundary encloses there; None where it does not lie on it.
    cap: the plane that new vertices lie in, or None.
    tension: part of the way to a membrane that others are moved.
    strokes: strands as strokes on side 0, with points. tolerance: edges by which a strand's end may
        miss its stroke's.
    is_chosen: did the caller choose how fills lie? Else mirrored ones lie as the other side does.
    """

    around: Neighbourhood
    surface: Surface | None
    region: Region | None
    cap: FlatCap | None
    tension: float
    strokes: tuple[Stroke, ...]
    tolerance: int
    is_chosen: bool

    @classmethod
    def of(cls, hole: Hole, around: Neighbourhood, options: HoleOptions) -> HoleProjector:
        """Prepare the placing of a hole's fills."""
        surface = options.surface
        cap = None if surface is not None else find_cap(hole, options.shape)
        drawn = tuple(stroke for stroke in options.strokes if stroke.points is not None)
        region = None if surface is None else _choose_region(surface, hole.points)
        return cls(
            around=around,
            surface=surface,
            region=region,
            cap=cap,
            tension=options.tension,
            strokes=drawn,
            tolerance=options.tolerance,
            is_chosen=options.shape != "auto" or options.tension > 0,
        )

    @property
    def loop(self) -> Points:
        """(L, 3) the hole's boundary."""
        return self.around.points[: len(self.around.outside)]

    @property
    def is_flat(self) -> bool:
        """Do new vertices lie in a plane?"""
        return self.cap is not None

    def place(self, quads: Int32Array, n_vertices: int) -> tuple[Points, int]:
        """Return where the inner vertices (k, 3) of a fill come to lie, and its flipped quads.

        quads: (q, 4) int32, loop vertices 0..L-1, inner ones after.
        """
        if self.cap is not None or self.region is not None:
            points = np.zeros((n_vertices - len(self.loop), 3))
        else:
            smooth = place_fill(self.around, quads, n_vertices)
            points = mend_fill(self.around, quads, smooth).points
        points = self._move(quads, points)
        return points, self.count_flipped(quads, points)

    def place_mirrored(
        self, quads: Int32Array, points: Points, is_flat: bool
    ) -> tuple[Points, int, bool]:
        """Return where the inner vertices (k, 3) of a mirrored fill come to lie, its flipped quads,
        and whether it is flat."""
        if not self.is_chosen:
            return points, count_flipped(self.around, quads, points), is_flat
        points, count = self.place(quads, len(self.loop) + len(points))
        return points, count, self.is_flat

    def project(self, quads: Int32Array, placed: PlacedFill) -> PlacedFill:
        """Project the inner vertices of a fill that is placed smoothly, and pull its strands."""
        if not (self.surface or self.cap or self.tension or self.strokes):
            return placed
        points = self._move(quads, placed.points)
        return PlacedFill(points, placed.measures, self.count_flipped(quads, points))

    def count_flipped(self, quads: Int32Array, points: Points) -> int:
        """Count the quads of a fill that are turned over where its inner vertices (k, 3) lie."""
        if self.cap is None:
            return count_flipped(self.around, quads, points)
        vertices = np.vstack([self.loop, points])
        up = np.tile(self.cap.plane.normal, (len(vertices), 1))
        return int(flipped(quads, vertices, up).sum())

    def _move(self, quads: Int32Array, points: Points) -> Points:
        """(k, 3) the inner vertices where they are to lie."""
        n = len(self.loop)
        if not len(points):
            return points
        from query.placing.placement import place, pull_placed

        disk = LoopDisk(quads, n + len(points), n)
        if self.cap is not None:
            return self._flatten(self.cap.plane, disk)
        if self.region is not None:
            placed = place(disk, self.loop, self.region, self.strokes, tolerance=self.tolerance)
            return placed.vertices[n:]
        if self.tension:
            tight = lay_flat(disk, self.loop)[n:]
            points = (1 - self.tension) * points + self.tension * tight
        if self.strokes:
            vertices = np.vstack([self.loop, points])
            points = pull_placed(disk, vertices, self.strokes, tolerance=self.tolerance)[n:]
        return points if self.surface is None else self.surface.nearest(points).points

    def _flatten(self, plane: RimPlane, disk: LoopDisk) -> Points:
        """(k, 3) the inner vertices in a plane."""
        from query.placing.placement import place, pull_placed

        n, around = disk.perimeter, unfold(self.around, plane)
        points = plane.project(place_fill(around, disk.quads, disk.n_vertices).points)
        if self.count_flipped(disk.quads, points):
            points = plane.project(place(disk, around.points[:n]).vertices[n:])
        if self.strokes:
            vertices = np.vstack([around.points[:n], points])
            pulled = pull_placed(disk, vertices, self.strokes, tolerance=self.tolerance)
            points = plane.project(pulled[n:])
        # A boundary across an axis leaves no rounding along it.
        level = np.ptp(self.loop, axis=0) == 0
        points[:, level] = self.loop[0, level]
        return points


def _choose_region(surface: Surface, loop: Points) -> Region | None:
    """The smaller part of the surface that a rim encloses: which way the triangles of a scan turn
    tells nothing of the mesh."""
    from query.placing.region import enclose_region

    edge = float(np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1).mean())
    off = np.linalg.norm(surface.nearest(loop).points - loop, axis=1)
    if float(off.max()) > FAR_OFF * edge:
        return None
    turned = Surface.from_arrays(surface.vertices, surface.triangles[:, ::-1])
    found = [enclose_region(one, loop) for one in (surface, turned)]
    separate = [region for region in found if region.separates]
    return min(separate, key=lambda region: region.share, default=None)


def unfold(around: Neighbourhood, plane: RimPlane) -> Neighbourhood:
    """Turn what is around a hole into the plane of its boundary, as if the mesh went on there.

    Of the vertices outside only those that edges join to the boundary have a place afterwards: what
    placing looks at. One that lies in the plane stays; by as much as another is off the plane, it
    is moved outwards, up to the length of the edges at the vertex of the boundary.
    """
    n = len(around.outside)
    points = plane.project(around.points)
    height = np.abs((around.points - around.points[:n].mean(axis=0)) @ plane.normal)
    loop = points[:n]
    after = np.roll(loop, -1, axis=0) - loop
    edge = np.linalg.norm(after, axis=1)
    edge = (edge + np.roll(edge, 1)) / 2
    outward = np.cross(after, plane.normal)
    outward += np.roll(outward, 1, axis=0)
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-300)
    face = np.repeat(np.arange(len(around.offsets) - 1), np.diff(around.offsets))
    at = np.arange(len(around.corners))
    following = np.where(at + 1 == around.offsets[face + 1], around.offsets[face], at + 1)
    ends = np.stack([around.corners, around.corners[following]], axis=1).astype(np.int64)
    ends = np.concatenate([ends, ends[:, ::-1]])
    v, w = ends[(ends[:, 0] < n) & (ends[:, 1] >= n)].T
    moves = np.zeros_like(points)
    count = np.bincount(w, minlength=len(points))
    np.add.at(moves, w, outward[v] * np.minimum(height[w], edge[v])[:, None])
    points = points + moves / np.maximum(count, 1)[:, None]
    return replace(around, points=points, beyond=np.tile(plane.normal, (n, 1)))
