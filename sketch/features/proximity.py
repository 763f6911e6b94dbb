"""Kernels over a tree of triangles: nearest points, and triangles near a box.

The tree is query.placing.tree's; its own nearest points are wrong on triangles without area.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from patterndb.halfedge import Index, Int32Array
from query.placing.tree import DEPTH

Points = NDArray[np.float64]

#: Squared sine of a triangle's angle below which the foot in its plane is not to be trusted.
NEEDLE = 1e-12


@njit(cache=True, nogil=True)
def _to_box(boxes: Points, b: Index, points: Points, i: Index) -> float:
    """Squared distance of point i to box b."""
    total = 0.0
    for c in range(3):
        x = points[i, c]
        d = max(boxes[b, 0, c] - x, 0.0, x - boxes[b, 1, c])
        total += d * d
    return total


@njit(cache=True, nogil=True)
def _on_edge(corners: Points, f: Index, e: Index, points: Points, i: Index) -> tuple[float, float]:
    """Squared distance of point i to edge e of triangle f; share of the edge at its foot."""
    g = (e + 1) % 3
    along = 0.0
    size = 0.0
    for c in range(3):
        u = corners[f, g, c] - corners[f, e, c]
        along += u * (points[i, c] - corners[f, e, c])
        size += u * u
    s = min(max(along / size, 0.0), 1.0) if size > 0.0 else 0.0
    total = 0.0
    for c in range(3):
        x = (1.0 - s) * corners[f, e, c] + s * corners[f, g, c] - points[i, c]
        total += x * x
    return total, s


@njit(cache=True, nogil=True)
def _on_triangle(
    corners: Points, f: Index, points: Points, i: Index, weights: NDArray[np.float64]
) -> float:
    """Squared distance of point i to triangle f; the weights (3,) of the foot are set.

    The foot in the plane where it is inside; else, and for needles as well, the nearest foot on
    the three edges.
    """
    a0, a1, a2 = corners[f, 0, 0], corners[f, 0, 1], corners[f, 0, 2]
    u0, u1, u2 = corners[f, 1, 0] - a0, corners[f, 1, 1] - a1, corners[f, 1, 2] - a2
    v0, v1, v2 = corners[f, 2, 0] - a0, corners[f, 2, 1] - a1, corners[f, 2, 2] - a2
    p0, p1, p2 = points[i, 0] - a0, points[i, 1] - a1, points[i, 2] - a2
    n0, n1, n2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
    size = n0 * n0 + n1 * n1 + n2 * n2
    best = np.inf
    if size > 0.0:
        v = ((p1 * v2 - p2 * v1) * n0 + (p2 * v0 - p0 * v2) * n1 + (p0 * v1 - p1 * v0) * n2) / size
        w = ((u1 * p2 - u2 * p1) * n0 + (u2 * p0 - u0 * p2) * n1 + (u0 * p1 - u1 * p0) * n2) / size
        if v > 0.0 and w > 0.0 and v + w < 1.0:
            weights[0], weights[1], weights[2] = 1.0 - v - w, v, w
            x = p0 - v * u0 - w * v0
            y = p1 - v * u1 - w * v1
            z = p2 - v * u2 - w * v2
            best = x * x + y * y + z * z
            uu = u0 * u0 + u1 * u1 + u2 * u2
            if size > NEEDLE * uu * (v0 * v0 + v1 * v1 + v2 * v2):
                return best
    for e in range(3):
        d, s = _on_edge(corners, f, e, points, i)
        if d < best:
            best = d
            weights[e] = 1.0 - s
            weights[(e + 1) % 3] = s
            weights[(e + 2) % 3] = 0.0
    return best


@njit(cache=True, nogil=True)
def nearest(
    corners: Points, boxes: Points, nodes: Int32Array, order: Int32Array, points: Points
) -> tuple[Int32Array, Points]:
    """(n,) triangle nearest to each point (n, 3), and (n, 3) weights of the point on it."""
    triangle = np.zeros(len(points), np.int32)
    weights = np.zeros((len(points), 3))
    trial = np.zeros(3)
    stack = np.empty(DEPTH, np.int32)
    for i in range(len(points)):
        best = np.inf
        stack[0] = 0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            if _to_box(boxes, b, points, i) >= best:
                continue
            if nodes[b, 1] >= 0:
                for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                    d = _on_triangle(corners, order[k], points, i, trial)
                    if d < best:
                        best = d
                        triangle[i] = order[k]
                        weights[i] = trial
                continue
            # The nearer child is looked at first: it is pushed last.
            near = nodes[b, 0]
            far = near + 1
            if _to_box(boxes, near, points, i) > _to_box(boxes, far, points, i):
                near, far = far, near
            stack[top] = far
            stack[top + 1] = near
            top += 2
    return triangle, weights


@njit(cache=True, nogil=True)
def within_box(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> Int32Array:
    """(k,) the triangles whose own boxes meet a box (3,) to (3,), ascending."""
    found = np.empty(len(order), np.int32)
    stack = np.empty(DEPTH, np.int32)
    stack[0] = 0
    top = 1
    n = 0
    while top:
        top -= 1
        b = stack[top]
        apart = False
        for c in range(3):
            apart |= boxes[b, 0, c] > high[c] or boxes[b, 1, c] < low[c]
        if apart:
            continue
        if nodes[b, 1] < 0:
            stack[top] = nodes[b, 0]
            stack[top + 1] = nodes[b, 0] + 1
            top += 2
            continue
        for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
            f = order[k]
            apart = False
            for c in range(3):
                one, two, three = corners[f, 0, c], corners[f, 1, c], corners[f, 2, c]
                apart |= min(one, two, three) > high[c] or max(one, two, three) < low[c]
            if not apart:
                found[n] = f
                n += 1
    return np.sort(found[:n])
