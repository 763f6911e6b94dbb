"""One piece of a patch as a mesh: a closed polyline in space becomes a triangulated disk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points, as_points
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.tessellation.interior import filled, triangulated
from patterndb_sketch.surfacing.tessellation.minimalarea import minimal_area
from patterndb_sketch.surfacing.tessellation.projection import projected
from patterndb_sketch.surfacing.tessellation.relaxation import harmonic_heights, stretch

#: How a piece was made: relaxed over a plane, or as the triangulation of least area.
Method = Literal["laplacian", "area"]

#: What is done with a piece that is not relaxed over a plane, and why it is not.
INSTEAD = "triangulated with the least area instead, without points inside"
CROSSES = (
    "the boundary crosses or touches itself in its own plane and in that of its principal axes; "
    + INSTEAD
)
BARRED = f"too thin: its mesh in the plane joins points of one chord; {INSTEAD}"


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
    method: Method
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
    above 0 or makes more than :data:`MAX_INNER` points, and as :func:`minimal_area` does where
    that is used.

    Source: Abbasinejad et al. 2013, section 2, on their method of 2011: "projects the cycle to
    the plane, meshes the interior, and then relaxes the vertex positions".
    Differs from the paper: which plane, and what if the projection crosses itself, the paper
    leaves open; and vertices move along the plane's normal only, which for these weights is
    what relaxing in space comes to.
    """
    at = as_points(points, "the piece's points", InvalidNetworkError)
    checked_spacing(spacing)
    if len(at) < 3:
        raise InvalidNetworkError(
            f"a piece with {len(at)} points encloses nothing; give three or more"
        )
    if len(at) == 3:
        return Tessellation(np.empty((0, 3)), np.array([[0, 1, 2]]), "laplacian")
    seen = projected(at)
    if seen is None:
        return _of_least_area(at, barred, CROSSES)
    tail, twin = triangulated(seen.grid)
    # Where the piece is steep, points in the plane are further apart in space.
    apart = spacing / seen.step / stretch(seen.grid, tail, seen.heights, seen.step)
    mesh, tail, twin = filled(seen.grid, tail, twin, apart)
    heights = harmonic_heights(mesh, tail, twin, seen.heights)
    m, triangles = len(at), tail.reshape(-1, 3)
    if barred is not None and _joins(triangles, barred):
        return _of_least_area(at, barred, BARRED)
    return Tessellation(seen.lifted(mesh[m:], heights[m:]), triangles, "laplacian")


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


def checked_spacing(spacing: float) -> None:
    """Raises InvalidNetworkError for a spacing that is not above 0."""
    if not (math.isfinite(spacing) and spacing > 0):
        raise InvalidNetworkError(f"the spacing is {spacing}; give a length above 0")
