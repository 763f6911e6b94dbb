"""The triangulation of a closed polyline in space that has the least area."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points, as_points
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.network import InvalidNetworkError

#: The most vertices of a polyline that is triangulated. The table takes 8 n**2 bytes (32 MB
#: here), and time grows with n**3: some three seconds here (benchmarks/minimal_area.py).
MAX_VERTICES = 2_000

#: Areas that differ by less than this part of the whole are equal: rounding is below it, and a
#: planar stretch, where all triangulations have one area, is not triangulated by rounding.
TIE = 1e-12

#: A triangle whose angle has a cosine this near to -1 is flat: never the better of equals.
FLAT = 1e-9


def minimal_area(
    points: ArrayLike, barred: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.int64], float]:
    """The triangulation of a closed polyline with the least summed area, and that area.

    points: (n, 3), n >= 3, the first not repeated at the end. barred: (n, n) bool, symmetric,
    the pairs of points that no triangle may join unless they are neighbours; by default none.
    Returns (n - 2, 3) int64 triangles, which name points and turn as the polyline does, and the
    area in squared units. Among the triangulations of one area (to TIE) it takes from edge to
    edge the triangle with the widest angle opposite the edge, then the lowest vertex: where the
    polyline is planar and convex, that is the Delaunay triangulation. The triangles may cross
    one another.

    Raises InvalidNetworkError for points that are none, for fewer than three, for more than
    MAX_VERTICES, and if every triangulation joins a barred pair.

    Source: Barequet and Sharir 1995, "Filling gaps in the boundary of a polyhedron", section 3:
    the best triangulation between vertices i and j is the best triangle on that edge and the
    best triangulations beyond its two other edges.
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
    least = _table(columns, barred)
    if not math.isfinite(least[0, -1]):
        raise InvalidNetworkError("every triangulation joins two points that are barred")
    triangles, area = _chosen(columns, least)
    return triangles, area * size * size


# Sums may be reordered, so that the inner loop runs in vector registers; infinities do occur.
@kernel(fastmath={"reassoc", "nnan", "nsz", "contract"})
def _table(at: Points, barred: NDArray[np.bool_]) -> Points:
    """(n, n) twice the least area between vertices i and j of a polyline (3, n), symmetric.

    Infinite for barred pairs (n, n); an array of one entry bars none. Symmetric, so that both
    entries that the inner loop reads are beside each other in memory.
    """
    n = at.shape[1]
    least = np.zeros((n, n))
    spoke = np.empty((3, n))
    for i in range(n - 3, -1, -1):
        for k in range(i + 1, n):
            for c in range(3):
                spoke[c, k] = at[c, k] - at[c, i]
        xs, ys, zs, row = spoke[0], spoke[1], spoke[2], least[i]
        for j in range(i + 2, n):
            x, y, z = xs[j], ys[j], zs[j]
            column = least[j]
            best = np.inf
            for k in range(i + 1, j):
                cx = ys[k] * z - zs[k] * y
                cy = zs[k] * x - xs[k] * z
                cz = xs[k] * y - ys[k] * x
                best = min(best, row[k] + column[k] + math.sqrt(cx * cx + cy * cy + cz * cz))
            if j < len(barred) and barred[i, j] and j - i < n - 1:
                best = np.inf
            row[j] = best
            column[i] = best
    return least


@kernel
def _chosen(at: Points, least: Points) -> tuple[NDArray[np.int64], float]:
    """The triangles (n - 2, 3) of the polyline (3, n) that the table of areas speaks of."""
    n = at.shape[1]
    triangles = np.empty((n - 2, 3), np.int64)
    slack = TIE * least[0, n - 1]
    edges = np.empty((n, 2), np.int64)
    edges[0, 0] = 0
    edges[0, 1] = n - 1
    top = 1
    count = 0
    total = 0.0
    doubled = np.empty(n)
    while top:
        top -= 1
        i, j = edges[top, 0], edges[top, 1]
        lowest = np.inf
        for k in range(i + 1, j):
            doubled[k] = _doubled_area(at, i, k, j)
            lowest = min(lowest, least[i, k] + least[k, j] + doubled[k])
        chosen = -1
        narrowest = np.inf
        for k in range(i + 1, j):
            if least[i, k] + least[k, j] + doubled[k] <= lowest + slack:
                cosine = _cosine(at, i, k, j)
                if chosen < 0 or cosine < narrowest:
                    chosen = k
                    narrowest = cosine
        triangles[count, 0] = i
        triangles[count, 1] = chosen
        triangles[count, 2] = j
        count += 1
        total += doubled[chosen] / 2.0
        for a, b in ((i, chosen), (chosen, j)):
            if b - a > 1:
                edges[top, 0] = a
                edges[top, 1] = b
                top += 1
    return triangles, total


@kernel
def _doubled_area(at: Points, i: int, k: int, j: int) -> float:
    ux, uy, uz = at[0, k] - at[0, i], at[1, k] - at[1, i], at[2, k] - at[2, i]
    vx, vy, vz = at[0, j] - at[0, i], at[1, j] - at[1, i], at[2, j] - at[2, i]
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return math.sqrt(cx * cx + cy * cy + cz * cz)


@kernel
def _cosine(at: Points, i: int, k: int, j: int) -> float:
    """Of the angle at vertex k; 2 if the triangle is flat there."""
    along = 0.0
    first = 0.0
    second = 0.0
    for c in range(3):
        u = at[c, i] - at[c, k]
        v = at[c, j] - at[c, k]
        along += u * v
        first += u * u
        second += v * v
    if first == 0.0 or second == 0.0:
        return 2.0
    cosine = along / math.sqrt(first * second)
    return 2.0 if cosine < FLAT - 1.0 else cosine
