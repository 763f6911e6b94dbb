"""Kernels over a tree of triangles: what lines hit, none slipping between two triangles.

The tree is patterndb.geometry.tree's; its own hits are those of one side of clean surfaces.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.tree import DEPTH
from patterndb.system.kernels import kernel

#: Boxes are this much wider for lines, as a share of the farthest coordinate from where the
#: line begins: a hit at the rim of a triangle is not lost to rounding.
ROUNDING = 1e-13


@kernel
def _through_box(
    boxes: Points, b: Index, origins: Points, directions: Points, i: Index, pad: float
) -> tuple[float, float]:
    """From where to where line i is in box b; the first is larger if it misses it."""
    low = -np.inf
    high = np.inf
    for c in range(3):
        below = boxes[b, 0, c] - origins[i, c] - pad
        above = boxes[b, 1, c] - origins[i, c] + pad
        d = directions[i, c]
        if abs(d) < 1e-300:
            if below > 0.0 or above < 0.0:
                return np.inf, -np.inf
        else:
            low = max(low, min(below / d, above / d))
            high = min(high, max(below / d, above / d))
    return low, high


@kernel
def _pad(boxes: Points, origins: Points, i: Index) -> float:
    """How much wider the boxes are for line i."""
    far = 0.0
    for c in range(3):
        far = max(far, abs(boxes[0, 0, c] - origins[i, c]), abs(boxes[0, 1, c] - origins[i, c]))
    return ROUNDING * far


@kernel
def _hit(
    corners: Points,
    f: Index,
    origins: Points,
    directions: Points,
    i: Index,
    weights: NDArray[np.float64],
) -> float:
    """Where along line i, in lengths of its direction, it hits triangle f; nan if it does not.

    The weights (3,) of the hit are set. Source: Woop, Benthin and Wald 2013, "Watertight
    ray/triangle intersection": the line is made an axis, and the triangle's edges are looked at
    from the origin of the plane across it. What one triangle sees of an edge is exactly the
    negative of what its neighbour sees: no line slips between them.
    """
    z = 0
    for c in range(1, 3):
        if abs(directions[i, c]) > abs(directions[i, z]):
            z = c
    x = (z + 1) % 3
    y = (z + 2) % 3
    sx = directions[i, x] / directions[i, z]
    sy = directions[i, y] / directions[i, z]
    az = corners[f, 0, z] - origins[i, z]
    bz = corners[f, 1, z] - origins[i, z]
    cz = corners[f, 2, z] - origins[i, z]
    ax = corners[f, 0, x] - origins[i, x] - sx * az
    ay = corners[f, 0, y] - origins[i, y] - sy * az
    bx = corners[f, 1, x] - origins[i, x] - sx * bz
    by = corners[f, 1, y] - origins[i, y] - sy * bz
    cx = corners[f, 2, x] - origins[i, x] - sx * cz
    cy = corners[f, 2, y] - origins[i, y] - sy * cz
    u = cx * by - cy * bx
    v = ax * cy - ay * cx
    w = bx * ay - by * ax
    if (u < 0.0 or v < 0.0 or w < 0.0) and (u > 0.0 or v > 0.0 or w > 0.0):
        return math.nan
    total = u + v + w
    if total == 0.0:
        return math.nan
    weights[0], weights[1], weights[2] = u / total, v / total, w / total
    return (weights[0] * az + weights[1] * bz + weights[2] * cz) / directions[i, z]


@kernel
def first_hits(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origins: Points,
    directions: Points,
) -> tuple[Int32Array, Points, NDArray[np.float64]]:
    """The first hit of every ray (n, 3), (n, 3): triangles (n,), -1 without one, weights (n, 3)
    and how far along (n,), inf without one."""
    triangle = np.full(len(origins), -1, np.int32)
    weights = np.zeros((len(origins), 3))
    along = np.full(len(origins), np.inf)
    trial = np.zeros(3)
    stack = np.empty(DEPTH, np.int32)
    for i in range(len(origins)):
        pad = _pad(boxes, origins, i)
        best = np.inf
        stack[0] = 0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            low, high = _through_box(boxes, b, origins, directions, i, pad)
            if low > high or high < 0.0 or low > best:
                continue
            if nodes[b, 1] < 0:
                near = nodes[b, 0]
                far = near + 1
                one = _through_box(boxes, near, origins, directions, i, pad)[0]
                two = _through_box(boxes, far, origins, directions, i, pad)[0]
                if one > two:
                    near, far = far, near
                stack[top] = far
                stack[top + 1] = near
                top += 2
                continue
            for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                f = order[k]
                s = _hit(corners, f, origins, directions, i, trial)
                # Of triangles hit at once, at an edge, the first by number.
                if s >= 0.0 and (s < best or (s == best and f < triangle[i])):
                    best = s
                    triangle[i] = f
                    weights[i] = trial
        along[i] = best
    return triangle, weights, along


@kernel
def all_hits(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origins: Points,
    directions: Points,
) -> tuple[Int32Array, Int32Array, Points, NDArray[np.float64]]:
    """All hits of lines (n, 3), (n, 3), to both sides: the line (h,) of each, in ascending
    order, its triangle (h,), weights (h, 3) and how far along (h,), in no order."""
    room = 4 * len(origins) + 16
    line = np.empty(room, np.int32)
    triangle = np.empty(room, np.int32)
    weights = np.empty((room, 3))
    along = np.empty(room)
    trial = np.zeros(3)
    stack = np.empty(DEPTH, np.int32)
    n = 0
    for i in range(len(origins)):
        pad = _pad(boxes, origins, i)
        stack[0] = 0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            low, high = _through_box(boxes, b, origins, directions, i, pad)
            if low > high:
                continue
            if nodes[b, 1] < 0:
                stack[top] = nodes[b, 0]
                stack[top + 1] = nodes[b, 0] + 1
                top += 2
                continue
            for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                s = _hit(corners, order[k], origins, directions, i, trial)
                if math.isnan(s):
                    continue
                if n == room:
                    line = np.concatenate((line, np.empty(room, np.int32)))
                    triangle = np.concatenate((triangle, np.empty(room, np.int32)))
                    weights = np.concatenate((weights, np.empty((room, 3))))
                    along = np.concatenate((along, np.empty(room)))
                    room *= 2
                line[n] = i
                triangle[n] = order[k]
                weights[n] = trial
                along[n] = s
                n += 1
    return line[:n].copy(), triangle[:n].copy(), weights[:n].copy(), along[:n].copy()
