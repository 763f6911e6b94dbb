"""Constrained Delaunay triangulations of polygons on the grid: flips and insertion of points.

Half-edges as in :func:`patterndb_sketch.surfacing.tessellation.polygon.clip_ears`. The
polygon's edges have no twin, so no flip touches them. Source: Lawson 1977, "Software for C1
surface interpolation".
"""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Index, Int64Array
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.tessellation.polygon import turn

#: Relative error of the sum in :func:`is_within_circle`, beneath which its sign says nothing
#: (Shewchuk 1997, "Adaptive precision floating-point arithmetic", its first filter).
CIRCLE_ERROR = (10.0 + 96.0 * 2.0**-53) * 2.0**-53


@kernel(inline="always")
def following(h: Index) -> int:
    """The half-edge after h in its triangle, counter-clockwise."""
    return h + 1 if h % 3 < 2 else h - 2


@kernel(inline="always")
def preceding(h: Index) -> int:
    """The half-edge before h in its triangle."""
    return h - 1 if h % 3 > 0 else h + 2


@kernel
def is_within_circle(at: Int64Array, a: Index, b: Index, c: Index, d: Index) -> bool:
    """Is d surely within the circle through a, b, c (counter-clockwise)?"""
    ax, ay = float(at[a, 0] - at[d, 0]), float(at[a, 1] - at[d, 1])
    bx, by = float(at[b, 0] - at[d, 0]), float(at[b, 1] - at[d, 1])
    cx, cy = float(at[c, 0] - at[d, 0]), float(at[c, 1] - at[d, 1])
    bc, cb = bx * cy, cx * by
    ca, ac = cx * ay, ax * cy
    ab, ba = ax * by, bx * ay
    a2, b2, c2 = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    total = a2 * (bc - cb) + b2 * (ca - ac) + c2 * (ab - ba)
    size = (abs(bc) + abs(cb)) * a2 + (abs(ca) + abs(ac)) * b2 + (abs(ab) + abs(ba)) * c2
    return total > CIRCLE_ERROR * size


@kernel
def flip(tail: Int64Array, twin: Int64Array, h: Index) -> None:
    """Turn the inner edge of half-edge h within the quad of its two triangles."""
    g = twin[h]
    hp, gp = preceding(h), preceding(g)
    c, d = tail[hp], tail[gp]
    beyond_h, beyond_g = twin[gp], twin[hp]
    tail[h] = d
    tail[g] = c
    twin[h] = beyond_h
    twin[g] = beyond_g
    if beyond_h >= 0:
        twin[beyond_h] = h
    if beyond_g >= 0:
        twin[beyond_g] = g
    twin[hp] = gp
    twin[gp] = hp


@kernel
def make_delaunay(at: Int64Array, tail: Int64Array, twin: Int64Array, triangles: int) -> None:
    """Flip inner edges of the first triangles until each is locally Delaunay.

    An edge is flipped only where the test is certain. Then its quad is convex, and the flip
    lowers the surface over the paraboloid: it ends.
    """
    n = 3 * triangles
    waiting = np.ones(n, np.bool_)
    stack = np.empty(n, np.int64)
    for h in range(n):
        stack[h] = h
    top = n
    while top:
        top -= 1
        h = stack[top]
        waiting[h] = False
        g = twin[h]
        if g < 0:
            continue
        a, b, c = tail[h], tail[following(h)], tail[preceding(h)]
        if not is_within_circle(at, a, b, c, tail[preceding(g)]):
            continue
        flip(tail, twin, h)
        for k in (h, following(h), g, following(g)):
            if not waiting[k]:
                waiting[k] = True
                stack[top] = k
                top += 1


@kernel
def triangle_at(
    at: Int64Array, tail: Int64Array, twin: Int64Array, triangles: int, p: Index, first: int
) -> int:
    """The triangle that holds point p, walking there from the first; -1 if none does."""
    t = first
    for _ in range(triangles):
        beyond = -2
        for e in range(3):
            h = 3 * t + e
            if turn(at, tail[h], tail[following(h)], p) < 0:
                beyond = twin[h]
                break
        if beyond == -2:
            return t
        if beyond < 0:
            break
        t = beyond // 3
    # The straight way there leaves a concave polygon.
    for t in range(triangles):
        h = 3 * t
        if (
            turn(at, tail[h], tail[h + 1], p) >= 0
            and turn(at, tail[h + 1], tail[h + 2], p) >= 0
            and turn(at, tail[h + 2], tail[h], p) >= 0
        ):
            return t
    return -1


@kernel
def insert(
    at: Int64Array,
    tail: Int64Array,
    twin: Int64Array,
    triangles: int,
    p: Index,
    t: int,
    stack: Int64Array,
) -> None:
    """Join point p, in triangle t and on no boundary edge, to a Delaunay triangulation.

    Uses the two triangles after the first ``triangles``. stack: room for as many half-edges as
    there are vertices, and three more.
    """
    h = 3 * t
    u = 3 * triangles
    v = u + 3
    a, b, c = tail[h], tail[h + 1], tail[h + 2]
    of_u, of_v = twin[h + 1], twin[h + 2]
    tail[h + 2] = p
    tail[u], tail[u + 1], tail[u + 2] = b, c, p
    tail[v], tail[v + 1], tail[v + 2] = c, a, p
    twin[u], twin[v] = of_u, of_v
    if of_u >= 0:
        twin[of_u] = u
    if of_v >= 0:
        twin[of_v] = v
    for one, other in ((h + 1, u + 2), (u + 1, v + 2), (v + 1, h + 2)):
        twin[one] = other
        twin[other] = one
    stack[0], stack[1], stack[2] = h, u, v
    top = 3
    while top:
        top -= 1
        k = stack[top]
        g = twin[k]
        if g < 0:
            continue
        a, b = tail[k], tail[following(k)]
        # A point on an edge leaves a triangle without area there: that edge has to go.
        if turn(at, a, b, p) > 0 and not is_within_circle(at, a, b, p, tail[preceding(g)]):
            continue
        flip(tail, twin, k)
        stack[top] = k
        stack[top + 1] = following(g)
        top += 2
