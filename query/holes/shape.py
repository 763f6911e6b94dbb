"""Place a fill across its loop, and measure how it lies there.

Inner vertices minimise the umbrella Laplacian over inner vertices and those of the loop, the mesh
around being held: bending energy, so that a fill goes on as the surroundings arrive. (Harmonic
placing, which minimises stretch alone, lets rings of regular quads sag. It is taken where fewer
quads are flipped by it.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.shape import laplacian_rows, measure_fill
from patterndb._native.query.holes.shape import neighbours as _neighbours
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, units
from query.holes.neighbourhood import Neighbourhood
from query.placing.laplace import HeldQuads
from query.placing.leastsquares import LeastSquares, join_entries, solve_square
from query.placing.untangle import untangle

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
            *entries, right = laplacian_rows(points, start, beside, n_outer, n_loop)
            rows = join_entries(*entries, (len(right), inner))
            if harmonic:
                solved = solve_square(rows[:inner], right[:inner])
            else:
                solved = LeastSquares(rows, RIDGE).solve(right)
            rest = rows @ solved - right
            bending = float(np.cumsum(rest * rest)[-1])
            points[n_outer:] = solved
        measures, flipped = _measure_there(around, points, shifted)
        n_rows = max(inner + n_loop, 1)
        measures[BENDING] = np.log(bending / (around.scale**2) / n_rows + 1e-6)
        if placed is None or flipped < placed.flipped:
            placed = PlacedFill(points[n_outer:].copy(), measures, flipped)
        if not flipped or not inner:
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
    flipped = count_flipped(around, quads, points)
    return PlacedFill(points, placed.measures, flipped) if flipped < placed.flipped else placed


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
