"""Where a mesh crosses itself: pairs of triangles that go through each other."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.proximity import walk_box
from patterndb.geometry.tree import begin_walk, build, make_stack
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.tessellation.triangles import split_quads

#: Faces that reach through each other by less than this, as a part of the mesh's diagonal,
#: touch: far above rounding, far below anything drawn.
TOUCH = 1e-9

#: A triangle flatter than this part of the mesh's diagonal has no plane to speak of: rounding
#: moves its far points by TOUCH.
THIN = 1e-7


def find_self_intersections(points: ArrayLike, faces: ArrayLike) -> NDArray[np.int64]:
    """Find the (p, 2) pairs of faces that cross, each in rising order, sorted.

    points: (v, 3); faces: (f, 3) triangles or (f, 4) quads, which count as
    :func:`patterndb_sketch.surfacing.tessellation.triangles.split_quads` cuts them. Two
    triangles cross if each has corners on both sides of the other's plane and they share a
    stretch of a line, or if they lie in one plane and overlap; both by more than TOUCH of the
    mesh's diagonal. Touching with a corner or an edge is no crossing. So triangles with a
    common corner (the same point number) cross only where they meet elsewhere too, and
    triangles with a common edge only if one is folded flat onto the other. The two halves of a
    quad are not compared. Triangles flatter than THIN of the diagonal are left out.

    Raises InvalidMeshError for points and faces that are none.
    """
    at, triangles, owner = split_quads(points, faces)
    if len(triangles) < 2:
        return np.empty((0, 2), np.int64)
    corners = np.ascontiguousarray(at[triangles])
    box = np.ptp(corners.reshape(-1, 3), axis=0)
    extent = float(box.max())
    if extent == 0.0:
        return np.empty((0, 2), np.int64)
    # About the middle, and with the diagonal as the unit: nothing overflows.
    corners = (corners - corners.mean(axis=(0, 1))) / extent
    corners /= np.linalg.norm(box / extent)
    pairs = owner[_crossings(corners, triangles, owner, *build(corners))]
    return np.unique(np.sort(pairs, axis=1), axis=0)


@kernel
def _crossings(
    corners: Points,
    triangles: NDArray[np.int64],
    owner: NDArray[np.int64],
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
) -> NDArray[np.int64]:
    """(p, 2) pairs of crossing triangles (t, 3, 3), found down the tree of their boxes."""
    t = len(corners)
    normals = np.zeros((t, 3))
    sound = np.zeros(t, np.bool_)
    for i in range(t):
        sound[i] = _normal(corners[i], normals[i])
    found = np.empty((64, 2), np.int64)
    count = 0
    stack, far = make_stack()
    low, high = np.empty(3), np.empty(3)
    for i in range(t):
        if not sound[i]:
            continue
        for c in range(3):
            # Wider by what counts as touching: triangles in one plane have flat boxes.
            low[c] = min(corners[i, 0, c], corners[i, 1, c], corners[i, 2, c]) - TOUCH
            high[c] = max(corners[i, 0, c], corners[i, 1, c], corners[i, 2, c]) + TOUCH
        begin_walk(stack)
        while True:
            leaf = walk_box(boxes, nodes, (low, high), 0.0, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
                j = order[k]
                if j <= i or owner[i] == owner[j] or not sound[j]:
                    continue
                if not _cross(corners, normals, triangles, i, j):
                    continue
                if count == len(found):
                    more = np.empty((2 * count, 2), np.int64)
                    more[:count] = found
                    found = more
                found[count, 0] = i
                found[count, 1] = j
                count += 1
    return found[:count].copy()


@kernel
def _normal(corner: Points, normal: Points) -> bool:
    """Write a triangle's unit normal; False if it is too flat to have one."""
    longest = 0.0
    for e in range(3):
        length = 0.0
        for c in range(3):
            length += (corner[(e + 1) % 3, c] - corner[e, c]) ** 2
        longest = max(longest, length)
    u, v = corner[1] - corner[0], corner[2] - corner[0]
    normal[0] = u[1] * v[2] - u[2] * v[1]
    normal[1] = u[2] * v[0] - u[0] * v[2]
    normal[2] = u[0] * v[1] - u[1] * v[0]
    size = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    # The size is twice the area: base times height.
    if size <= THIN * math.sqrt(longest):
        return False
    normal /= size
    return True


@kernel
def _cross(
    corners: Points, normals: Points, triangles: NDArray[np.int64], i: Index, j: Index
) -> bool:
    """Do triangles i and j go through each other, or overlap in one plane?

    Source: Moeller 1997, "A fast triangle-triangle intersection test": the stretches in which
    each meets the other's plane are on one line, and are compared there.
    """
    of_i = np.empty((2, 3))
    of_j = np.empty((2, 3))
    meets_i = _stretch(corners, normals, triangles, i, j, of_i)
    if meets_i < 0:
        return False
    meets_j = _stretch(corners, normals, triangles, j, i, of_j)
    if meets_j < 0:
        return False
    if meets_i == 0 or meets_j == 0:
        return not _apart(corners, normals, i, j) and not _apart(corners, normals, j, i)
    length = 0.0
    for c in range(3):
        length += (of_i[1, c] - of_i[0, c]) ** 2
    length = math.sqrt(length)
    if length <= TOUCH:
        return False
    first, second = 0.0, 0.0
    for c in range(3):
        way = (of_i[1, c] - of_i[0, c]) / length
        first += (of_j[0, c] - of_i[0, c]) * way
        second += (of_j[1, c] - of_i[0, c]) * way
    return min(length, max(first, second)) - max(0.0, min(first, second)) > TOUCH


@kernel
def _stretch(
    corners: Points,
    normals: Points,
    triangles: NDArray[np.int64],
    i: Index,
    j: Index,
    ends: Points,
) -> int:
    """Where triangle i meets the plane of j, between two ends, which are written: 1.

    0 if it lies in the plane, -1 if it does not reach through.
    """
    height = np.zeros(3)
    above, below = 0, 0
    for e in range(3):
        v = triangles[i, e]
        # A common corner is in the plane, whatever rounding says.
        if v != triangles[j, 0] and v != triangles[j, 1] and v != triangles[j, 2]:
            for c in range(3):
                height[e] += (corners[i, e, c] - corners[j, 0, c]) * normals[j, c]
        if height[e] > TOUCH:
            above += 1
        elif height[e] < -TOUCH:
            below += 1
        else:
            height[e] = 0.0
    if above == 0 and below == 0:
        return 0
    if above == 0 or below == 0:
        return -1
    count = 0
    for e in range(3):
        f = (e + 1) % 3
        if height[e] == 0.0:
            for c in range(3):
                ends[count, c] = corners[i, e, c]
            count += 1
        elif height[e] * height[f] < 0.0:
            share = height[e] / (height[e] - height[f])
            for c in range(3):
                ends[count, c] = corners[i, e, c] + share * (corners[i, f, c] - corners[i, e, c])
            count += 1
    return 1


@kernel
def _apart(corners: Points, normals: Points, one: Index, other: Index) -> bool:
    """Of two triangles in one plane: does an edge of the one have the other beyond it?"""
    n = normals[one]
    for e in range(3):
        p = corners[one, e]
        q = corners[one, (e + 1) % 3]
        x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        # Into the triangle, across the edge.
        ax, ay, az = n[1] * z - n[2] * y, n[2] * x - n[0] * z, n[0] * y - n[1] * x
        size = math.sqrt(ax * ax + ay * ay + az * az)
        deepest = -np.inf
        for f in range(3):
            r = corners[other, f]
            inward = (r[0] - p[0]) * ax + (r[1] - p[1]) * ay + (r[2] - p[2]) * az
            deepest = max(deepest, inward / size)
        if deepest <= TOUCH:
            return True
    return False
