"""Triangulate closed polylines in space with the least area: one recurrence, for all who need it.

The best triangulation between vertices i and j is the best triangle on that edge and the best
triangulations beyond its two other edges (Barequet and Sharir 1995, "Filling gaps in the boundary
of a polyhedron", section 3). Time grows with the cube of the number of vertices.

- :func:`triangulate_cheapest` is the recurrence as it stands, for faces and other short polylines.
- :func:`tabulate_areas` and :func:`choose_triangles` are for long ones: the first runs in vector
  registers and keeps areas alone; the second goes back through them and can afford to weigh
  triangulations of equal area.
- :func:`tabulate_areas_around` has the least areas of all stretches around a closed polyline: those
  on both sides of every chord.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Bools, Points
from patterndb.system.kernels import kernel

#: Areas that differ by less than this part of the whole are equal: rounding is below it, and a
#: planar stretch, where all triangulations have one area, is not triangulated by rounding.
TIE = 1e-12

#: A triangle whose angle has a cosine this near to -1 is flat: never the better of equals.
FLAT = 1e-9


@kernel
def triangulate_cheapest(
    points: Points, shorter: float, thin: float, triangles: NDArray[np.integer]
) -> float:
    """Write the cheapest triangulation of a closed polyline (n, 3) to (n - 2, 3); its cost.

    A triangle costs its area, but no less than ``thin`` times the squared lengths of its edges, and
    ``shorter`` times these. Of equals the one with the lower vertex is taken.
    """
    n = len(points)
    cost = np.zeros((n, n))
    apex = np.zeros((n, n), np.int32)
    for i in range(n - 3, -1, -1):
        for j in range(i + 2, n):
            least = np.inf
            apex[i, j] = i + 1
            for k in range(i + 1, j):
                total = cost[i, k] + cost[k, j]
                if total >= least:
                    continue
                total += _price(points, i, k, j, shorter, thin)
                if total < least:
                    least = total
                    apex[i, j] = k
            cost[i, j] = least
    stack = np.empty((n, 2), np.int32)
    stack[0, 0], stack[0, 1] = 0, n - 1
    top = 1
    made = 0
    while top:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if j - i < 2:
            continue
        k = apex[i, j]
        triangles[made, 0], triangles[made, 1], triangles[made, 2] = i, k, j
        made += 1
        stack[top, 0], stack[top, 1] = i, k
        stack[top + 1, 0], stack[top + 1, 1] = k, j
        top += 2
    return cost[0, n - 1]


@kernel
def _price(points: Points, a: int, b: int, c: int, shorter: float, thin: float) -> float:
    px, py, pz = points[a, 0], points[a, 1], points[a, 2]
    ux, uy, uz = points[b, 0] - px, points[b, 1] - py, points[b, 2] - pz
    vx, vy, vz = points[c, 0] - px, points[c, 1] - py, points[c, 2] - pz
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = 0.5 * math.sqrt(x * x + y * y + z * z)
    if shorter == 0.0 and thin == 0.0:
        return area
    edges = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz
    edges += (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
    return max(area, thin * edges) + shorter * edges


# Sums may be reordered, so that the inner loop runs in vector registers; infinities do occur.
@kernel(fastmath={"reassoc", "nnan", "nsz", "contract"})
def tabulate_areas(at: Points, barred: Bools) -> Points:
    """Tabulate (n, n) twice the least area between vertices i and j of a polyline (3, n).

    Infinite for barred pairs (n, n); an array of one entry bars none. The table is symmetric, so
    that both entries that the inner loop reads are beside each other in memory.
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
def choose_triangles(at: Points, least: Points) -> tuple[Int64Array, float]:
    """Choose the triangles (n - 2, 3) of a polyline (3, n) by the table of its least areas.

    Returns them and their area. Of equals (TIE) it takes the triangle with the widest angle
    opposite its edge, then the lowest vertex.
    """
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


# Sums may be reordered, so that the inner loop runs in vector registers; infinities do occur.
@kernel(fastmath={"reassoc", "nnan", "nsz", "contract"})
def tabulate_areas_around(at: Points) -> Points:
    """Tabulate (n, n) [i, s]: twice the least area of s + 1 vertices from i on of a loop (3, n)."""
    n = at.shape[1]
    twice = np.empty((3, 2 * n))
    twice[:, :n] = at
    twice[:, n:] = at
    least = np.zeros((n, n))
    # The same by the vertex where a stretch ends: what the inner loop reads lies in a row.
    ending = np.zeros((n, n))
    for s in range(2, n):
        for i in range(n):
            j = i + s
            x = twice[0, j] - twice[0, i]
            y = twice[1, j] - twice[1, i]
            z = twice[2, j] - twice[2, i]
            row, column = least[i], ending[j % n]
            best = np.inf
            for k in range(1, s):
                u = twice[0, i + k] - twice[0, i]
                v = twice[1, i + k] - twice[1, i]
                w = twice[2, i + k] - twice[2, i]
                a, b, c = v * z - w * y, w * x - u * z, u * y - v * x
                best = min(best, row[k] + column[s - k] + math.sqrt(a * a + b * b + c * c))
            least[i, s] = best
            ending[j % n, s] = best
    return least
