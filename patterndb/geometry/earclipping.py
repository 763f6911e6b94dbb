"""Triangulate faces of many corners in the plane: ears are clipped, a round of them at a time.

An ear is a corner whose triangle holds no other part of the face; every simple polygon has one
(Meisters 1975, "Polygons have ears"). Whether a corner is an ear is asked of a tree of the corners
that are not convex, for one of these lies within any triangle that anything enters. A corner that
another stands in the way of waits until that one is clipped, and of two neighbours only one is
clipped in a round: so the time grows little faster than the number of corners, and no corner
gathers more triangles than the shape asks for.

Corners are moved onto a grid, where every turn is exact. Two that lie at one place are fine: a face
with a hole is written as one outline that runs to the hole and back along the same edge.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int64Array
from patterndb.geometry.points import Points
from patterndb.geometry.tree import begin_walk, build, make_stack, make_walk, measure_backwards
from patterndb.system.kernels import kernel

#: Coordinates on the grid run from 0 to this. A turn is a difference of two products of two
#: differences: below 2**61, so it fits in 64 bits.
GRID = 1 << 30

#: A turn computed in floating point is wrong by no more than this on the grid: products are below
#: 2**60, and a float has 53 bits.
TURN_ERROR = 2.0**10


@kernel
def clip_ears(points: Points, triangles: NDArray[np.integer]) -> None:
    """Write the triangles (n - 2, 3) of one face, (n, 3) points, in its sense.

    What is left of an outline without ears, one that crosses itself, is halved again and again.
    """
    n = len(points)
    at = _flatten(points)
    after = np.empty(n, np.int64)
    before = np.empty(n, np.int64)
    for v in range(n):
        after[v] = (v + 1) % n
        before[v] = (v - 1) % n
    reflex = np.empty(n, np.int64)
    current = np.empty(n, np.int64)
    n_reflex = n_current = 0
    for v in range(n):
        if _may_be_clipped(at, before[v], v, after[v]):
            current[n_current] = v
            n_current += 1
        else:
            reflex[n_reflex] = v
            n_reflex += 1
    corners = np.zeros((max(n_reflex, 1), 3, 3))
    for k in range(n_reflex):
        corners[k, :, 0] = at[reflex[k], 0]
        corners[k, :, 1] = at[reflex[k], 1]
    boxes, nodes, order = build(corners)
    stack, far = make_stack()
    alive = np.ones(n, np.bool_)
    # Of each corner: the round in which its neighbours last changed, that for which it is listed
    # last, what it waits for, and its place in the list of all that wait for the same.
    touched = np.zeros(n, np.int64)
    listed = np.zeros(n, np.int64)
    obstacle = np.full(n, -1, np.int64)
    first_waiting = np.full(n, -1, np.int64)
    next_waiting = np.full(n, -1, np.int64)
    previous_waiting = np.full(n, -1, np.int64)
    coming = np.empty(n, np.int64)
    made = 0
    turn = 0
    while n_current and made < n - 3:
        turn += 1
        n_coming = 0
        for i in range(n_current):
            v = current[i]
            if not alive[v] or touched[v] == turn or made == n - 3:
                continue
            p, q = before[v], after[v]
            if not _may_be_clipped(at, p, v, q):
                continue
            found = -1
            begin_walk(stack)
            asked = (
                float(at[p, 0]),
                float(at[p, 1]),
                float(at[v, 0]),
                float(at[v, 1]),
                float(at[q, 0]),
                float(at[q, 1]),
            )
            while found < 0 and _turn(at, p, v, q) > 0:
                leaf = _walk(boxes, nodes, asked, np.inf, stack, far)
                if leaf < 0:
                    break
                for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
                    if order[k] < n_reflex:
                        r = reflex[order[k]]
                        if alive[r] and _is_in_the_way(at, p, v, q, r):
                            found = r
                            break
            if found >= 0:
                obstacle[v] = found
                previous_waiting[v] = -1
                next_waiting[v] = first_waiting[found]
                if first_waiting[found] >= 0:
                    previous_waiting[first_waiting[found]] = v
                first_waiting[found] = v
                continue
            triangles[made, 0], triangles[made, 1], triangles[made, 2] = p, v, q
            made += 1
            alive[v] = False
            after[p] = q
            before[q] = p
            for w in (p, q):
                touched[w] = turn
                if obstacle[w] >= 0:
                    one, other = previous_waiting[w], next_waiting[w]
                    if one >= 0:
                        next_waiting[one] = other
                    else:
                        first_waiting[obstacle[w]] = other
                    if other >= 0:
                        previous_waiting[other] = one
                    obstacle[w] = -1
                if listed[w] != turn:
                    listed[w] = turn
                    coming[n_coming] = w
                    n_coming += 1
            w = first_waiting[v]
            first_waiting[v] = -1
            while w >= 0:
                obstacle[w] = -1
                if listed[w] != turn:
                    listed[w] = turn
                    coming[n_coming] = w
                    n_coming += 1
                w = next_waiting[w]
        current, coming = coming, current
        n_current = n_coming
    rest = np.empty(n - made, np.int64)
    v = 0
    while not alive[v]:
        v += 1
    for k in range(len(rest)):
        rest[k] = v
        v = after[v]
    _halve(rest, triangles, made)


@kernel
def _flatten(points: Points) -> Int64Array:
    """(n, 2) the corners of a face (n, 3) in its plane, on the grid, counter-clockwise."""
    n = len(points)
    middle = np.zeros(3)
    for c in range(3):
        middle[c] = points[:, c].mean()
    normal = np.zeros(3)
    for k in range(n):
        a, b = points[k] - middle, points[(k + 1) % n] - middle
        normal[0] += a[1] * b[2] - a[2] * b[1]
        normal[1] += a[2] * b[0] - a[0] * b[2]
        normal[2] += a[0] * b[1] - a[1] * b[0]
    at = np.zeros((n, 2), np.int64)
    size = math.sqrt((normal * normal).sum())
    if not size > 0.0:
        return at
    normal /= size
    across = np.zeros(3)
    across[int(np.argmin(np.abs(normal)))] = 1.0
    u = np.cross(across, normal)
    u /= math.sqrt((u * u).sum())
    v = np.cross(normal, u)
    flat = np.empty((n, 2))
    for k in range(n):
        a = points[k] - middle
        flat[k, 0] = (a * u).sum()
        flat[k, 1] = (a * v).sum()
    low = np.array([flat[:, 0].min(), flat[:, 1].min()])
    extent = max(flat[:, 0].max() - low[0], flat[:, 1].max() - low[1])
    if not extent > 0.0:
        return at
    for k in range(n):
        for c in range(2):
            at[k, c] = round((flat[k, c] - low[c]) / extent * GRID)
    return at


@kernel(inline="always")
def _turn(at: Int64Array, a: Index, b: Index, c: Index) -> int:
    """Twice the signed area of three corners: above 0 counter-clockwise."""
    return (at[b, 0] - at[a, 0]) * (at[c, 1] - at[a, 1]) - (at[b, 1] - at[a, 1]) * (
        at[c, 0] - at[a, 0]
    )


@kernel
def _may_be_clipped(at: Int64Array, p: Index, v: Index, q: Index) -> bool:
    """Is a corner v convex, at the place of a neighbour, or the end of a spike without width?"""
    turn = _turn(at, p, v, q)
    if turn != 0:
        return turn > 0
    along = (at[v, 0] - at[p, 0]) * (at[q, 0] - at[v, 0])
    return along + (at[v, 1] - at[p, 1]) * (at[q, 1] - at[v, 1]) <= 0


@kernel
def _is_in_the_way(at: Int64Array, p: Index, v: Index, q: Index, r: Index) -> bool:
    """Does corner r lie in a triangle, its edges included, and not at one of its corners?"""
    for corner in (p, v, q):
        if at[r, 0] == at[corner, 0] and at[r, 1] == at[corner, 1]:
            return False
    return _turn(at, p, v, r) >= 0 and _turn(at, v, q, r) >= 0 and _turn(at, q, p, r) >= 0


@kernel(forceinline=True)
def _is_apart(
    boxes: Points,
    b: Index,
    far: float,
    asked: tuple[float, float, float, float, float, float],
    bound: float,
) -> bool:
    """Is a box surely outside a triangle, given by its corners counter-clockwise?"""
    x0, y0, x1, y1, x2, y2 = asked
    low_x, low_y, high_x, high_y = boxes[b, 0, 0], boxes[b, 0, 1], boxes[b, 1, 0], boxes[b, 1, 1]
    if high_x < min(x0, x1, x2) or low_x > max(x0, x1, x2):
        return True
    if high_y < min(y0, y1, y2) or low_y > max(y0, y1, y2):
        return True
    return (
        _highest(low_x, low_y, high_x, high_y, x0, y0, x1, y1) < -TURN_ERROR
        or _highest(low_x, low_y, high_x, high_y, x1, y1, x2, y2) < -TURN_ERROR
        or _highest(low_x, low_y, high_x, high_y, x2, y2, x0, y0) < -TURN_ERROR
    )


@kernel(forceinline=True)
def _highest(
    low_x: float,
    low_y: float,
    high_x: float,
    high_y: float,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
) -> float:
    """The greatest turn from an edge to a place in a box."""
    x = low_x if y1 > y0 else high_x
    y = high_y if x1 > x0 else low_y
    return (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)




@kernel
def _halve(ring: Int64Array, triangles: NDArray[np.integer], made: int) -> None:
    """Write the triangles of a ring of corners: its ends and its middle, and so on in both halves,
    from place ``made`` on."""
    stack = np.empty((64, 2), np.int64)
    stack[0, 0], stack[0, 1] = 0, len(ring) - 1
    top = 1
    while top:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if j - i < 2:
            continue
        k = (i + j) // 2
        triangles[made, 0], triangles[made, 1], triangles[made, 2] = ring[i], ring[k], ring[j]
        made += 1
        stack[top, 0], stack[top, 1] = i, k
        stack[top + 1, 0], stack[top + 1, 1] = k, j
        top += 2
