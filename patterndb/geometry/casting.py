"""What lines hit of triangles, down their tree.

Three ways, for what hits are wanted of. :func:`first_along` has the hits of one side of a clean
surface, both ways along a normal. :func:`first_ahead` has those of rays of sight, of both sides.
:func:`first_hits` and :func:`all_hits` lose none between two triangles, for models of any quality.
They differ in what they do at the rims of triangles, and their numbers are part of results.
"""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.proximity import to_box
from patterndb.geometry.tree import begin_walk, make_stack, make_walk, measure_backwards
from patterndb.system.kernels import kernel

#: Barycentric coordinates this far below 0 still count as a hit: a line through an edge hits
#: one of its two triangles.
SLACK = 1e-9

#: A ray whose angle with a triangle's plane has a sine below this runs along it and does not
#: hit it.
EDGE_ON = 1e-9

#: Boxes are this much wider for lines, as a share of the farthest coordinate from where the
#: line begins: a hit at the rim of a triangle is not lost to rounding.
ROUNDING = 1e-13


@kernel(forceinline=True)
def _measure_start(boxes: Points, b: Index, asked: tuple[Points, Points, Index]) -> float:
    points, _, i = asked
    return to_box(boxes, b, points, i)


@kernel(forceinline=True)
def _is_missed(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Points, Index], bound: float
) -> bool:
    points, normals, i = asked
    return far > bound * bound or not _meets_box(boxes, b, points, normals, i, bound)


@kernel(forceinline=True)
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
    """Find, of the hits of lines, the one nearest to where each begins, both ways along.

    points, normals: (n, 3); reach: (n,). Triangles that face away from the normal are not
    seen. Returns (n,) triangles, -1 without hit, and (n, 3) weights.
    """
    triangle = np.full(len(points), -1, np.int32)
    weights = np.zeros((len(points), 3))
    stack, far = make_stack()
    for i in range(len(points)):
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        best = reach[i]
        begin_walk(stack)
        while True:
            leaf = _walk_along(boxes, nodes, (points, normals, i), best, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
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


@kernel(forceinline=True)
def _measure_entry(boxes: Points, b: Index, asked: tuple[Points, Points]) -> float:
    return _entered(boxes, b, asked[0], asked[1])


@kernel(forceinline=True)
def _is_behind(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Points], bound: float
) -> bool:
    return far == np.inf or far > bound + 1e-12 * (1.0 + bound)


@kernel
def _entered(boxes: Points, b: Index, origin: Points, direction: Points) -> float:
    """How far along a ray it comes into box b, infinity if it does not."""
    low, high = 0.0, np.inf
    for c in range(3):
        d = direction[c]
        if abs(d) < 1e-300:
            if origin[c] < boxes[b, 0, c] or origin[c] > boxes[b, 1, c]:
                return np.inf
        else:
            one = (boxes[b, 0, c] - origin[c]) / d
            two = (boxes[b, 1, c] - origin[c]) / d
            low = max(low, min(one, two))
            high = min(high, max(one, two))
    # Boxes of triangles across the axes are flat: rounding must not make them empty.
    return low if low <= high + 1e-12 * (1.0 + abs(high)) else np.inf




@kernel
def _hit_ahead(corner: Points, origin: Points, direction: Points) -> tuple[float, float, float]:
    """How far along a ray it meets a triangle (3, 3), and the weights of its last two corners
    there; infinity if it does not."""
    ax, ay, az = corner[0, 0], corner[0, 1], corner[0, 2]
    ux, uy, uz = corner[1, 0] - ax, corner[1, 1] - ay, corner[1, 2] - az
    vx, vy, vz = corner[2, 0] - ax, corner[2, 1] - ay, corner[2, 2] - az
    x, y, z = ax - origin[0], ay - origin[1], az - origin[2]
    # The triangle's normal, twice its area long.
    mx, my, mz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(mx * mx + my * my + mz * mz)
    facing = mx * direction[0] + my * direction[1] + mz * direction[2]
    if abs(facing) <= EDGE_ON * size:
        return np.inf, 0.0, 0.0
    s = (x * mx + y * my + z * mz) / facing
    if s < 0.0:
        return np.inf, 0.0, 0.0
    x, y, z = s * direction[0] - x, s * direction[1] - y, s * direction[2] - z
    cx, cy, cz = uy * z - uz * y, uz * x - ux * z, ux * y - uy * x
    w = (cx * mx + cy * my + cz * mz) / (size * size)
    cx, cy, cz = y * vz - z * vy, z * vx - x * vz, x * vy - y * vx
    v = (cx * mx + cy * my + cz * mz) / (size * size)
    if v < -SLACK or w < -SLACK or v + w > 1.0 + SLACK:
        return np.inf, 0.0, 0.0
    return s, v, w


@kernel
def first_ahead(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origins: Points,
    directions: Points,
) -> tuple[Int32Array, Points]:
    """Find the triangle (n,) that each ray (n, 3), (n, 3) of unit direction meets first, -1 for
    none, and the weights (n, 3) of the hit.

    Unlike :func:`first_along` only ahead, and from both sides.
    """
    triangle = np.full(len(origins), -1, np.int32)
    weights = np.zeros((len(origins), 3))
    stack, far = make_stack()
    for i in range(len(origins)):
        origin, direction = origins[i], directions[i]
        best = np.inf
        begin_walk(stack)
        while True:
            leaf = _walk_ahead(boxes, nodes, (origin, direction), best, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
                f = order[k]
                s, v, w = _hit_ahead(corners[f], origin, direction)
                if s < best or (s == best and s < np.inf and f < triangle[i]):
                    best = s
                    triangle[i] = f
                    # Onto the triangle, if the slack let in a ray beside it.
                    v = min(max(v, 0.0), 1.0)
                    w = min(max(w, 0.0), 1.0 - v)
                    weights[i, 0] = 1.0 - v - w
                    weights[i, 1] = v
                    weights[i, 2] = w
    return triangle, weights


@kernel(forceinline=True)
def _measure_ray(boxes: Points, b: Index, asked: tuple[Points, Points, Index, float]) -> float:
    """How far along the ray is box b; infinity if it misses it."""
    origins, directions, i, pad = asked
    low, high = _through_box(boxes, b, origins, directions, i, pad)
    return np.inf if low > high or high < 0.0 else low


@kernel(forceinline=True)
def _is_later(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Points, Index, float], bound: float
) -> bool:
    return far > bound or far == np.inf




@kernel(forceinline=True)
def _is_beside(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Points, Index, float], bound: float
) -> bool:
    origins, directions, i, pad = asked
    low, high = _through_box(boxes, b, origins, directions, i, pad)
    return low > high




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
    weights: Floats,
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
) -> tuple[Int32Array, Points, Floats]:
    """Find the first hit of every ray (n, 3), (n, 3): triangles (n,), -1 without one, weights
    (n, 3) and how far along (n,), inf without one."""
    triangle = np.full(len(origins), -1, np.int32)
    weights = np.zeros((len(origins), 3))
    along = np.full(len(origins), np.inf)
    trial = np.zeros(3)
    stack, far = make_stack()
    for i in range(len(origins)):
        asked = origins, directions, i, _pad(boxes, origins, i)
        best = np.inf
        begin_walk(stack)
        while True:
            leaf = _walk_ray(boxes, nodes, asked, best, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
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
) -> tuple[Int32Array, Int32Array, Points, Floats]:
    """Find all hits of lines (n, 3), (n, 3), of both sides: the line (h,) of each, in ascending
    order, its triangle (h,), weights (h, 3) and how far along (h,), in no order."""
    room = 4 * len(origins) + 16
    line = np.empty(room, np.int32)
    triangle = np.empty(room, np.int32)
    weights = np.empty((room, 3))
    along = np.empty(room)
    trial = np.zeros(3)
    stack, far = make_stack()
    n = 0
    for i in range(len(origins)):
        asked = origins, directions, i, _pad(boxes, origins, i)
        begin_walk(stack)
        while True:
            leaf = _walk_line(boxes, nodes, asked, 0.0, stack, far)
            if leaf < 0:
                break
            for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
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
