"""Kernels for the nearest places of edges and polylines.

Points stand in one array (n, 3); edge i runs from point i to point i + 1.
"""

from __future__ import annotations

import math

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel


@kernel
def nearest_on_edge(points: Points, vertex: int, edge: int) -> tuple[float, float]:
    """The place on an edge, 0 to 1, nearest to a vertex, and the distance."""
    along = 0.0
    square = 0.0
    for d in range(3):
        step = points[edge + 1, d] - points[edge, d]
        along += step * (points[vertex, d] - points[edge, d])
        square += step * step
    share = 0.0
    if square > 0:
        share = min(1.0, max(0.0, along / square))
    gap = 0.0
    for d in range(3):
        at = points[edge, d] + share * (points[edge + 1, d] - points[edge, d])
        if share == 1.0:
            at = points[edge + 1, d]
        gap += (points[vertex, d] - at) ** 2
    return share, math.sqrt(gap)


@kernel
def nearest_of_edges(
    points: Points, first: int, second: int, margin: float
) -> tuple[float, float, float]:
    """The places on two edges, 0 to 1, nearest to each other, and the distance.

    Ends are taken unless places within both edges are closer by more than the margin.
    """
    share, best = nearest_on_edge(points, first, second)
    s, u = 0.0, share
    share, gap = nearest_on_edge(points, first + 1, second)
    if gap < best:
        s, u, best = 1.0, share, gap
    share, gap = nearest_on_edge(points, second, first)
    if gap < best:
        s, u, best = share, 0.0, gap
    share, gap = nearest_on_edge(points, second + 1, first)
    if gap < best:
        s, u, best = share, 1.0, gap
    a = b = c = d = e = 0.0
    for k in range(3):
        along_first = points[first + 1, k] - points[first, k]
        along_second = points[second + 1, k] - points[second, k]
        between = points[first, k] - points[second, k]
        a += along_first * along_first
        b += along_first * along_second
        c += along_second * along_second
        d += along_first * between
        e += along_second * between
    determinant = a * c - b * b
    # Nearly parallel lines come nearest somewhere far off, or anywhere.
    if determinant > 1e-14 * a * c:
        inner_s = (b * e - c * d) / determinant
        inner_u = (a * e - b * d) / determinant
        if 0 < inner_s < 1 and 0 < inner_u < 1:
            gap = 0.0
            for k in range(3):
                on_first = points[first, k] + inner_s * (points[first + 1, k] - points[first, k])
                on_second = points[second, k] + inner_u * (
                    points[second + 1, k] - points[second, k]
                )
                gap += (on_first - on_second) ** 2
            gap = math.sqrt(gap)
            if gap < best - margin:
                s, u, best = inner_s, inner_u, gap
    return s, u, best


@kernel
def farthest(points: Points, other: Points) -> float:
    """The greatest distance of a point of one polyline (k, 3) from another polyline (m, 3)."""
    greatest = 0.0
    both = np.concatenate((points, other))
    for i in range(len(points)):
        nearest = np.inf
        for edge in range(len(points), len(both) - 1):
            nearest = min(nearest, nearest_on_edge(both, i, edge)[1])
        greatest = max(greatest, nearest)
    return greatest
