"""Nearest points of triangles, and the triangles near a box, down their tree."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.tree import begin_walk, make_stack, make_walk, measure_backwards
from patterndb.system.kernels import kernel

#: Squared sine of a triangle's smallest angle, about, below which its regions are not to be told
#: apart: they are differences of products that nearly cancel.
NEEDLE = 1e-4


@kernel(forceinline=True)
def to_box(boxes: Points, b: Index, points: Points, i: Index) -> float:
    """Squared distance of point i to box b."""
    total = 0.0
    for c in range(3):
        x = points[i, c]
        d = max(boxes[b, 0, c] - x, 0.0, x - boxes[b, 1, c])
        total += d * d
    return total


@kernel(forceinline=True)
def _measure_point(boxes: Points, b: Index, asked: tuple[Points, Index]) -> float:
    return to_box(boxes, b, asked[0], asked[1])


@kernel(forceinline=True)
def _is_farther(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Index], bound: float
) -> bool:
    return far >= bound




@kernel
def nearest(
    corners: Points, boxes: Points, nodes: Int32Array, order: Int32Array, points: Points
) -> tuple[Int32Array, Points]:
    """Find the triangle (n,) nearest to each point (n, 3), and the weights (n, 3) of the point
    on it."""
    triangle = np.zeros(len(points), np.int32)
    weights = np.zeros((len(points), 3))
    stack, far = make_stack()
    for i in range(len(points)):
        best = np.inf
        begin_walk(stack)
        while True:
            leaf = _walk_nearest(boxes, nodes, (points, i), best, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
                f = order[k]
                d, v, w = in_triangle(corners, f, points, i)
                if d < best:
                    best = d
                    triangle[i] = f
                    weights[i, 0] = 1.0 - v - w
                    weights[i, 1] = v
                    weights[i, 2] = w
    return triangle, weights


@kernel
def nearest_facing(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    points: Points,
    normals: Points,
) -> tuple[Int32Array, Points]:
    """Find the nearest triangle (n,) that faces as the point's normal does, -1 without one, and
    the weights (n, 3) of the point on it.

    points, normals: (n, 3). A triangle across the normal does not face as it does.
    """
    triangle = np.full(len(points), -1, np.int32)
    weights = np.zeros((len(points), 3))
    stack, far = make_stack()
    for i in range(len(points)):
        best = np.inf
        begin_walk(stack)
        while True:
            leaf = _walk_nearest(boxes, nodes, (points, i), best, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
                f = order[k]
                if not _faces(corners, f, normals, i):
                    continue
                d, v, w = in_triangle(corners, f, points, i)
                if d < best:
                    best = d
                    triangle[i] = f
                    weights[i, 0] = 1.0 - v - w
                    weights[i, 1] = v
                    weights[i, 2] = w
    return triangle, weights


@kernel
def _faces(corners: Points, f: Index, normals: Points, i: Index) -> bool:
    """Has triangle f's normal a part along normal i?"""
    x, y, z = corners[f, 0, 0], corners[f, 0, 1], corners[f, 0, 2]
    ux, uy, uz = corners[f, 1, 0] - x, corners[f, 1, 1] - y, corners[f, 1, 2] - z
    vx, vy, vz = corners[f, 2, 0] - x, corners[f, 2, 1] - y, corners[f, 2, 2] - z
    x = (uy * vz - uz * vy) * normals[i, 0]
    y = (uz * vx - ux * vz) * normals[i, 1]
    z = (ux * vy - uy * vx) * normals[i, 2]
    return x + y + z > 0.0


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


Triple = tuple[float, float, float]


@kernel(forceinline=True)
def _subtract(a: Floats, b: Floats) -> Triple:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel(forceinline=True)
def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(forceinline=True)
def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


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
    u = _subtract(corners[f, 1], corners[f, 0])
    t = _subtract(corners[f, 2], corners[f, 0])
    p = _subtract(points[i], corners[f, 0])
    n = _cross(u, t)
    size = _dot(n, n)
    if size > 0.0:
        one = _dot(_cross(p, t), n) / size
        two = _dot(_cross(u, p), n) / size
        if one > 0.0 and two > 0.0 and one + two < 1.0:
            d = 0.0
            for c in range(3):
                off = p[c] - one * u[c] - two * t[c]
                d += off * off
            if d < best:
                best, v, w = d, one, two
    return best, v, w


@kernel(forceinline=True)
def _is_outside(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Points], bound: float
) -> bool:
    low, high = asked
    apart = False
    for c in range(3):
        apart |= boxes[b, 0, c] > high[c] or boxes[b, 1, c] < low[c]
    return apart




@kernel
def within_box(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    low: Floats,
    high: Floats,
) -> Int32Array:
    """Find the triangles (k,) whose own boxes meet a box (3,) to (3,), ascending."""
    found = np.empty(len(order), np.int32)
    stack, far = make_stack()
    n = 0
    begin_walk(stack)
    while True:
        leaf = walk_box(boxes, nodes, (low, high), 0.0, stack, far)
        if leaf < 0:
            break
        for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
            f = order[k]
            apart = False
            for c in range(3):
                one, two, three = corners[f, 0, c], corners[f, 1, c], corners[f, 2, c]
                apart |= min(one, two, three) > high[c] or max(one, two, three) < low[c]
            if not apart:
                found[n] = f
                n += 1
    return np.sort(found[:n])
