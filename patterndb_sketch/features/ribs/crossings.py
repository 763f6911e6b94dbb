"""Where edges of segments cross, touch, and how far places are from them."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel


@kernel
def foot(points: Points, e: Index, x: float, y: float) -> tuple[float, float]:
    """Distance of a place from the edge from point e to e + 1; share of the edge at its foot."""
    px, py = points[e, 0], points[e, 1]
    dx, dy = points[e + 1, 0] - px, points[e + 1, 1] - py
    size = dx * dx + dy * dy
    s = 0.0
    if size > 0.0:
        s = min(max(((x - px) * dx + (y - py) * dy) / size, 0.0), 1.0)
    return math.hypot(px + s * dx - x, py + s * dy - y), s


@kernel
def _side(points: Points, e: Index, k: Index) -> float:
    """Twice the area that edge e sees point k under; above 0 on its left."""
    px, py = points[e, 0], points[e, 1]
    dx, dy = points[e + 1, 0] - px, points[e + 1, 1] - py
    return dx * (points[k, 1] - py) - dy * (points[k, 0] - px)


@kernel
def crossed(points: Points, e: Index, f: Index) -> float:
    """The share of edge e where edge f crosses it, both from one side to the other; else -1."""
    a = _side(points, f, e)
    b = _side(points, f, e + 1)
    if (a > 0.0) == (b > 0.0) or a == 0.0 or b == 0.0:
        return -1.0
    c = _side(points, e, f)
    d = _side(points, e, f + 1)
    if (c > 0.0) == (d > 0.0) or c == 0.0 or d == 0.0:
        return -1.0
    return a / (a - b)


@kernel
def touch(points: Points, e: Index, f: Index, reach: float) -> bool:
    """Do edges e and f cross, or come within reach of each other?"""
    if crossed(points, e, f) >= 0.0:
        return True
    return (
        foot(points, e, points[f, 0], points[f, 1])[0] <= reach
        or foot(points, e, points[f + 1, 0], points[f + 1, 1])[0] <= reach
        or foot(points, f, points[e, 0], points[e, 1])[0] <= reach
        or foot(points, f, points[e + 1, 0], points[e + 1, 1])[0] <= reach
    )


@kernel
def touched(points: Points, e: Index, f: Index) -> float:
    """The share of edge e where edge f crosses it, or else comes nearest to it."""
    share = crossed(points, e, f)
    if share >= 0.0:
        return share
    least = np.inf
    for k in range(2):
        away = foot(points, f, points[e + k, 0], points[e + k, 1])[0]
        if away < least:
            least, share = away, float(k)
    for k in range(2):
        away, at = foot(points, e, points[f + k, 0], points[f + k, 1])
        if away < least:
            least, share = away, at
    return share


@kernel
def folded(points: Points, e: Index, f: Index, common: Index, reach: float) -> bool:
    """Do edges e and f, which meet at point e or e + 1 = common, lie on each other?"""
    one = e + 1 if common == e else e
    two = f + 1
    if (points[f + 1] == points[common]).all():
        two = f
    return (
        foot(points, f, points[one, 0], points[one, 1])[0] <= reach
        or foot(points, e, points[two, 0], points[two, 1])[0] <= reach
    )


@kernel
def edges_of(offsets: Int32Array) -> tuple[Int32Array, Int32Array]:
    """(e,) the first points of all edges, and (e,) the segments that they are of."""
    n = max(offsets[-1] - len(offsets) + 1, 0)
    first = np.empty(n, np.int32)
    owner = np.empty(n, np.int32)
    at = 0
    for s in range(len(offsets) - 1):
        for k in range(offsets[s], offsets[s + 1] - 1):
            first[at] = k
            owner[at] = s
            at += 1
    return first, owner


@kernel
def nearest_segment(points: Points, offsets: Int32Array) -> tuple[int, int, float, float]:
    """Of the edge nearest to the origin: segment, first point, share at the foot, distance."""
    best = np.inf
    result = (-1, -1, 0.0, np.inf)
    for s in range(len(offsets) - 1):
        for k in range(offsets[s], offsets[s + 1] - 1):
            away, share = foot(points, k, 0.0, 0.0)
            if away < best:
                best = away
                result = (s, k, share, away)
    return result
