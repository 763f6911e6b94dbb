"""The plane that a piece's boundary is seen in: its own, or that of its principal axes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points, tangents
from patterndb_sketch.surfacing.tessellation.polygon import GRID, is_simple

#: An area vector below this part of the squared extent has no direction: rounding.
NO_AREA = 1e-12


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


def area_vector(points: Points) -> Points:
    """(3,) the area vector of a closed polyline (m, 3): its length is the area of its shadow
    along itself, the largest of any direction (Newell's method)."""
    spokes = points - points.mean(axis=0)
    x, y, z = spokes.T
    after = np.concatenate([spokes[1:], spokes[:1]])
    u, v, w = after.T
    return 0.5 * np.array([y @ w - z @ v, z @ u - x @ w, x @ v - y @ u])


def projected(points: Points) -> Projection | None:
    """The polyline (m, 3) in the first plane where it is simple; None if it is in neither.

    The planes are that of its area vector, then that of its two longest principal axes.
    """
    spokes = points - points.mean(axis=0)
    extent = float(np.abs(spokes).max())
    if extent == 0.0:
        return None
    area = area_vector(points)
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
