"""A tree of boxes over triangles: nearest points and hits of lines.

An own kernel because of its speed: placing asks some ten times, and trimesh takes some twenty
times as long (benchmarks/triangle_tree.py).
"""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

#: Triangles in a leaf, at most.
LEAF = 4

#: Depth that the stack of a query has room for: boxes are halved by number.
DEPTH = 64

#: Squared sine of a triangle's smallest angle, about, below which its regions are not to be told
#: apart: they are differences of products that nearly cancel.
NEEDLE = 1e-4

#: Barycentric coordinates this far below 0 still count as a hit: a line through an edge hits
#: one of its two triangles.
SLACK = 1e-9


@kernel
def build(corners: Points) -> tuple[Points, Int32Array, Int32Array]:
    """Boxes (b, 2, 3), their nodes (b, 2) and the order (t,) of triangles (t, 3, 3).

    A node is (first child, -1), its other child being the next, or (first place in order,
    how many).
    """
    t = len(corners)
    order = np.arange(t).astype(np.int32)
    boxes = np.empty((2 * t + 1, 2, 3))
    nodes = np.empty((2 * t + 1, 2), np.int32)
    nodes[0, 0] = 0
    nodes[0, 1] = t
    count = 1
    at = 0
    while at < count:
        first = nodes[at, 0]
        n = nodes[at, 1]
        middle_low = np.full(3, np.inf)
        middle_high = np.full(3, -np.inf)
        boxes[at, 0] = np.inf
        boxes[at, 1] = -np.inf
        for k in range(first, first + n):
            for c in range(3):
                middle = 0.0
                for e in range(3):
                    x = corners[order[k], e, c]
                    middle += x / 3.0
                    boxes[at, 0, c] = min(boxes[at, 0, c], x)
                    boxes[at, 1, c] = max(boxes[at, 1, c], x)
                middle_low[c] = min(middle_low[c], middle)
                middle_high[c] = max(middle_high[c], middle)
        if n > LEAF:
            axis = int(np.argmax(middle_high - middle_low))
            middles = np.empty(n)
            for k in range(n):
                f = order[first + k]
                middles[k] = corners[f, 0, axis] + corners[f, 1, axis] + corners[f, 2, axis]
            order[first : first + n] = order[first : first + n][np.argsort(middles)]
            nodes[at, 0] = count
            nodes[at, 1] = -1
            for half in range(2):
                nodes[count + half, 0] = first + half * (n // 2)
                nodes[count + half, 1] = n // 2 + half * (n % 2)
            count += 2
        at += 1
    return boxes[:count].copy(), nodes[:count].copy(), order


@kernel
def to_box(boxes: Points, b: Index, points: Points, i: Index) -> float:
    """Squared distance of point i to box b."""
    total = 0.0
    for c in range(3):
        x = points[i, c]
        d = max(boxes[b, 0, c] - x, 0.0, x - boxes[b, 1, c])
        total += d * d
    return total


@kernel
def in_triangle(corners: Points, f: Index, points: Points, i: Index) -> tuple[float, float, float]:
    """Squared distance of point i to triangle f; weights of its last two corners where it is
    nearest.

    Source: Ericson 2005, "Real-Time Collision Detection", section 5.1.5, by the regions of
    the triangle's plane. Differs from the book: in needles, and triangles without area, all
    edges are looked at.
    """
    a0, a1, a2 = corners[f, 0, 0], corners[f, 0, 1], corners[f, 0, 2]
    ab0, ab1, ab2 = corners[f, 1, 0] - a0, corners[f, 1, 1] - a1, corners[f, 1, 2] - a2
    ac0, ac1, ac2 = corners[f, 2, 0] - a0, corners[f, 2, 1] - a1, corners[f, 2, 2] - a2
    ap0, ap1, ap2 = points[i, 0] - a0, points[i, 1] - a1, points[i, 2] - a2
    bp0, bp1, bp2 = ap0 - ab0, ap1 - ab1, ap2 - ab2
    cp0, cp1, cp2 = ap0 - ac0, ap1 - ac1, ap2 - ac2
    d1 = ab0 * ap0 + ab1 * ap1 + ab2 * ap2
    d2 = ac0 * ap0 + ac1 * ap1 + ac2 * ap2
    d3 = ab0 * bp0 + ab1 * bp1 + ab2 * bp2
    d4 = ac0 * bp0 + ac1 * bp1 + ac2 * bp2
    d5 = ab0 * cp0 + ab1 * cp1 + ab2 * cp2
    d6 = ac0 * cp0 + ac1 * cp1 + ac2 * cp2
    v = 0.0
    w = 0.0
    if d1 <= 0.0 and d2 <= 0.0:
        pass
    elif d3 >= 0.0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0.0 and d5 <= d6:
        w = 1.0
    else:
        vc = d1 * d4 - d3 * d2
        vb = d5 * d2 - d1 * d6
        va = d3 * d6 - d5 * d4
        uu = ab0 * ab0 + ab1 * ab1 + ab2 * ab2
        vv = ac0 * ac0 + ac1 * ac1 + ac2 * ac2
        uv = ab0 * ac0 + ab1 * ac1 + ab2 * ac2
        if uu * vv - uv * uv <= NEEDLE * (uu + vv) * (uu + vv):
            return _in_needle(corners, f, points, i)
        if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
            v = d1 / (d1 - d3)
        elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
            w = d2 / (d2 - d6)
        elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            v = 1.0 - w
        else:
            scale = va + vb + vc
            if scale > 0.0:
                v = vb / scale
                w = vc / scale
    x = ap0 - v * ab0 - w * ac0
    y = ap1 - v * ab1 - w * ac1
    z = ap2 - v * ab2 - w * ac2
    return x * x + y * y + z * z, v, w


@kernel
def _in_needle(corners: Points, f: Index, points: Points, i: Index) -> tuple[float, float, float]:
    """As :func:`in_triangle`: the nearest of the feet on the edges and the one in the plane."""
    best = np.inf
    v = 0.0
    w = 0.0
    for e in range(3):
        g = (e + 1) % 3
        along = 0.0
        size = 0.0
        for c in range(3):
            u = corners[f, g, c] - corners[f, e, c]
            along += u * (points[i, c] - corners[f, e, c])
            size += u * u
        s = min(max(along / size, 0.0), 1.0) if size > 0.0 else 0.0
        d = 0.0
        for c in range(3):
            x = (1.0 - s) * corners[f, e, c] + s * corners[f, g, c] - points[i, c]
            d += x * x
        if d < best:
            best = d
            v = s if e == 0 else (1.0 - s if e == 1 else 0.0)
            w = s if e == 1 else (1.0 - s if e == 2 else 0.0)
    u = corners[f, 1] - corners[f, 0]
    t = corners[f, 2] - corners[f, 0]
    p = points[i] - corners[f, 0]
    n = np.cross(u, t)
    size = (n * n).sum()
    if size > 0.0:
        one = (np.cross(p, t) * n).sum() / size
        two = (np.cross(u, p) * n).sum() / size
        if one > 0.0 and two > 0.0 and one + two < 1.0:
            off = p - one * u - two * t
            d = (off * off).sum()
            if d < best:
                best, v, w = d, one, two
    return best, v, w


@kernel
def nearest(
    corners: Points, boxes: Points, nodes: Int32Array, order: Int32Array, points: Points
) -> tuple[Int32Array, Points]:
    """(n,) triangle nearest to each point (n, 3), and (n, 3) weights of the point on it."""
    triangle = np.zeros(len(points), np.int32)
    weights = np.zeros((len(points), 3))
    stack = np.empty(DEPTH, np.int32)
    off = np.empty(DEPTH)
    for i in range(len(points)):
        best = np.inf
        stack[0] = 0
        off[0] = 0.0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            if off[top] >= best:
                continue
            if nodes[b, 1] >= 0:
                for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                    f = order[k]
                    d, v, w = in_triangle(corners, f, points, i)
                    if d < best:
                        best = d
                        triangle[i] = f
                        weights[i, 0] = 1.0 - v - w
                        weights[i, 1] = v
                        weights[i, 2] = w
                continue
            # The nearer child is looked at first: it is pushed last.
            near = nodes[b, 0]
            far = near + 1
            to_near, to_far = to_box(boxes, near, points, i), to_box(boxes, far, points, i)
            if to_near > to_far:
                near, far = far, near
                to_near, to_far = to_far, to_near
            if to_far < best:
                stack[top], off[top] = far, to_far
                top += 1
            if to_near < best:
                stack[top], off[top] = near, to_near
                top += 1
    return triangle, weights


@kernel
def _meets_box(
    boxes: Points, b: Index, points: Points, normals: Points, i: Index, reach: float
) -> bool:
    """Does line i, to both sides as far as the reach, meet box b?"""
    low = -reach
    high = reach
    for c in range(3):
        x = points[i, c]
        n = normals[i, c]
        if abs(n) < 1e-300:
            if x < boxes[b, 0, c] or x > boxes[b, 1, c]:
                return False
        else:
            one = (boxes[b, 0, c] - x) / n
            two = (boxes[b, 1, c] - x) / n
            low = max(low, min(one, two))
            high = min(high, max(one, two))
    # Boxes of triangles across the axes are flat.
    return low <= high + 1e-12 * (1.0 + abs(high))


@kernel
def first_along(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    points: Points,
    normals: Points,
    reach: Points,
) -> tuple[Int32Array, Points]:
    """Of the hits of lines the one nearest to where each begins, both ways along.

    points, normals: (n, 3); reach: (n,). Triangles that face away from the normal are not
    seen. Returns (n,) triangles, -1 without hit, and (n, 3) weights.
    """
    triangle = np.full(len(points), -1, np.int32)
    weights = np.zeros((len(points), 3))
    stack = np.empty(DEPTH, np.int32)
    for i in range(len(points)):
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        best = reach[i]
        stack[0] = 0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            if to_box(boxes, b, points, i) > best * best:
                continue
            if not _meets_box(boxes, b, points, normals, i, best):
                continue
            if nodes[b, 1] < 0:
                near = nodes[b, 0]
                far = near + 1
                if to_box(boxes, near, points, i) > to_box(boxes, far, points, i):
                    near, far = far, near
                stack[top] = far
                stack[top + 1] = near
                top += 2
                continue
            for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                f = order[k]
                x, y, z = corners[f, 0, 0], corners[f, 0, 1], corners[f, 0, 2]
                ux, uy, uz = corners[f, 1, 0] - x, corners[f, 1, 1] - y, corners[f, 1, 2] - z
                vx, vy, vz = corners[f, 2, 0] - x, corners[f, 2, 1] - y, corners[f, 2, 2] - z
                # The triangle's normal, twice its area long.
                mx, my, mz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
                facing = mx * nx + my * ny + mz * nz
                size = math.sqrt(mx * mx + my * my + mz * mz)
                if facing <= 1e-6 * size:
                    continue
                x, y, z = x - points[i, 0], y - points[i, 1], z - points[i, 2]
                # Cramer's rule for corner + v u + w v = p + s n.
                s = (x * mx + y * my + z * mz) / facing
                if abs(s) >= best:
                    continue
                x, y, z = s * nx - x, s * ny - y, s * nz - z
                cx, cy, cz = uy * z - uz * y, uz * x - ux * z, ux * y - uy * x
                w = (cx * mx + cy * my + cz * mz) / (size * size)
                cx, cy, cz = y * vz - z * vy, z * vx - x * vz, x * vy - y * vx
                v = (cx * mx + cy * my + cz * mz) / (size * size)
                if v < -SLACK or w < -SLACK or v + w > 1.0 + SLACK:
                    continue
                best = abs(s)
                triangle[i] = f
                v = min(max(v, 0.0), 1.0)
                w = min(max(w, 0.0), 1.0 - v)
                weights[i, 0] = 1.0 - v - w
                weights[i, 1] = v
                weights[i, 2] = w
    return triangle, weights
