"""The point of a surface that is nearest among those that face the right way."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.tree import DEPTH, Points, in_triangle, to_box
from patterndb.system.kernels import kernel


@kernel
def faces(corners: Points, f: Index, normals: Points, i: Index) -> bool:
    """Has triangle f's normal no part against normal i?"""
    x, y, z = corners[f, 0, 0], corners[f, 0, 1], corners[f, 0, 2]
    ux, uy, uz = corners[f, 1, 0] - x, corners[f, 1, 1] - y, corners[f, 1, 2] - z
    vx, vy, vz = corners[f, 2, 0] - x, corners[f, 2, 1] - y, corners[f, 2, 2] - z
    x = (uy * vz - uz * vy) * normals[i, 0]
    y = (uz * vx - ux * vz) * normals[i, 1]
    z = (ux * vy - uy * vx) * normals[i, 2]
    return x + y + z > 0.0


@kernel
def nearest_facing(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    points: Points,
    normals: Points,
) -> tuple[Int32Array, Points]:
    """(n,) nearest triangle that faces as the point's normal does, -1 without one, and (n, 3)
    weights on it.

    corners (t, 3, 3) and boxes, nodes, order: as of patterndb.geometry.tree; points, normals (n, 3).
    """
    triangle = np.full(len(points), -1, np.int32)
    weights = np.zeros((len(points), 3))
    stack = np.empty(DEPTH, np.int32)
    for i in range(len(points)):
        best = np.inf
        stack[0] = 0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            if to_box(boxes, b, points, i) >= best:
                continue
            if nodes[b, 1] >= 0:
                for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                    f = order[k]
                    if not faces(corners, f, normals, i):
                        continue
                    d, v, w = in_triangle(corners, f, points, i)
                    if d < best:
                        best = d
                        triangle[i] = f
                        weights[i, 0] = 1.0 - v - w
                        weights[i, 1] = v
                        weights[i, 2] = w
                continue
            near = nodes[b, 0]
            far = near + 1
            if to_box(boxes, near, points, i) > to_box(boxes, far, points, i):
                near, far = far, near
            stack[top] = far
            stack[top + 1] = near
            top += 2
    return triangle, weights
