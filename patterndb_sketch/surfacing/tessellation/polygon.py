"""Polygons on an integer grid: exact turns, whether one crosses itself, and its ears.

On integers below GRID every predicate here is exact in 64 bits, so that no polygon, however
noisy, nearly touching or full of vertices in a row on one line, leads to an inverted triangle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int64Array
from patterndb.system.kernels import kernel

#: Coordinates run from 0 to this. A turn is a difference of two products of two differences:
#: below 2**61, so it fits in 64 bits. One step is 1e-9 of the polygon's extent.
GRID = 1 << 30


@kernel(inline="always")
def turn(at: Int64Array, a: Index, b: Index, c: Index) -> int:
    """Twice the signed area of the triangle of three points: above 0 counter-clockwise."""
    return (at[b, 0] - at[a, 0]) * (at[c, 1] - at[a, 1]) - (at[b, 1] - at[a, 1]) * (
        at[c, 0] - at[a, 0]
    )


@kernel
def doubled_area(at: Int64Array) -> float:
    """Twice the signed area of a closed polygon (m, 2)."""
    total = 0.0
    for i in range(1, len(at) - 1):
        total += float(turn(at, 0, i, i + 1))
    return total


@kernel
def _between(at: Int64Array, a: Index, b: Index, c: Index) -> bool:
    """Of three points on one line: does c lie on the segment from a to b, ends included?"""
    for d in range(2):
        if at[c, d] < min(at[a, d], at[b, d]) or at[c, d] > max(at[a, d], at[b, d]):
            return False
    return True


@kernel
def _meet(at: Int64Array, a: Index, b: Index, c: Index, d: Index) -> bool:
    """Do the segments a-b and c-d have a point in common?"""
    for axis in range(2):
        if max(at[a, axis], at[b, axis]) < min(at[c, axis], at[d, axis]):
            return False
        if max(at[c, axis], at[d, axis]) < min(at[a, axis], at[b, axis]):
            return False
    to_c, to_d = turn(at, a, b, c), turn(at, a, b, d)
    to_a, to_b = turn(at, c, d, a), turn(at, c, d, b)
    # By signs: a product of two turns would not fit.
    if ((to_c > 0 and to_d < 0) or (to_c < 0 and to_d > 0)) and (
        (to_a > 0 and to_b < 0) or (to_a < 0 and to_b > 0)
    ):
        return True
    return (
        (to_c == 0 and _between(at, a, b, c))
        or (to_d == 0 and _between(at, a, b, d))
        or (to_a == 0 and _between(at, c, d, a))
        or (to_b == 0 and _between(at, c, d, b))
    )


@kernel
def is_simple(at: Int64Array) -> bool:
    """Does the closed polygon (m, 2) run counter-clockwise without touching itself?

    Vertices in a row on one line are fine; two at one place and edges that fold back are not.
    """
    m = len(at)
    if doubled_area(at) <= 0.0:
        return False
    for i in range(m):
        a, b, c = i, (i + 1) % m, (i + 2) % m
        if at[a, 0] == at[b, 0] and at[a, 1] == at[b, 1]:
            return False
        if turn(at, a, b, c) == 0:
            along = (at[b, 0] - at[a, 0]) * (at[c, 0] - at[b, 0])
            along += (at[b, 1] - at[a, 1]) * (at[c, 1] - at[b, 1])
            if along < 0:
                return False
        for j in range(i + 2, m - 1 if i == 0 else m):
            if _meet(at, a, b, j, (j + 1) % m):
                return False
    return True


@kernel
def _is_ear(at: Int64Array, after: NDArray[np.int64], p: Index, v: Index, q: Index) -> bool:
    """Is the triangle of a vertex and its neighbours inside, with no other vertex on it?"""
    if turn(at, p, v, q) <= 0:
        return False
    low_x = min(at[p, 0], at[v, 0], at[q, 0])
    high_x = max(at[p, 0], at[v, 0], at[q, 0])
    low_y = min(at[p, 1], at[v, 1], at[q, 1])
    high_y = max(at[p, 1], at[v, 1], at[q, 1])
    k = after[q]
    while k != p:
        x, y = at[k, 0], at[k, 1]
        if (
            low_x <= x <= high_x
            and low_y <= y <= high_y
            and turn(at, p, v, k) >= 0
            and turn(at, v, q, k) >= 0
            and turn(at, q, p, k) >= 0
        ):
            return False
        k = after[k]
    return True


@kernel
def clip_ears(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> None:
    """Triangulate the simple counter-clockwise polygon of the first m points, in place.

    tail, twin: (3 (m - 2),) int64 or longer, filled here. Half-edge 3 t + e leaves vertex
    tail[3 t + e] of triangle t; twin is the half-edge on its other side, -1 on the boundary.

    Every simple polygon has an ear (Meisters 1975), and so has one with vertices in a row on
    one line: a leaf of any of its triangulations. Clipping one leaves such a polygon, because
    no vertex lies on the cut.
    """
    after = np.empty(m, np.int64)
    before = np.empty(m, np.int64)
    for i in range(m):
        after[i] = (i + 1) % m
        before[i] = (i - 1) % m
    # What lies beyond the edge from a vertex to the next: a triangle's half-edge, or nothing.
    beyond = np.full(m, -1, np.int64)
    v = 0
    for t in range(m - 2):
        while not _is_ear(at, after, before[v], v, after[v]):
            v = after[v]
        p, q = before[v], after[v]
        h = 3 * t
        tail[h], tail[h + 1], tail[h + 2] = p, v, q
        twin[h], twin[h + 1], twin[h + 2] = beyond[p], beyond[v], -1
        for k in (h, h + 1):
            if twin[k] >= 0:
                twin[twin[k]] = k
        after[p] = q
        before[q] = p
        beyond[p] = 3 * t + 2
        # Not the next one: ears in a row would make a fan of thin triangles.
        v = after[q]
    last = 3 * (m - 2) - 1
    if beyond[tail[last]] >= 0:
        g = beyond[tail[last]]
        twin[last] = g
        twin[g] = last
