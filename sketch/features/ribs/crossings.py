"""Which segments belong together: they cross, touch, or leave a small gap between them."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from patterndb.halfedge import Index, Int32Array

Points = NDArray[np.float64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@njit(cache=True, nogil=True)
def foot(points: Points, e: Index, x: float, y: float) -> tuple[float, float]:
    """Distance of a place from the edge from point e to e + 1; share of the edge at its foot."""
    px, py = points[e, 0], points[e, 1]
    dx, dy = points[e + 1, 0] - px, points[e + 1, 1] - py
    size = dx * dx + dy * dy
    s = 0.0
    if size > 0.0:
        s = min(max(((x - px) * dx + (y - py) * dy) / size, 0.0), 1.0)
    return math.hypot(px + s * dx - x, py + s * dy - y), s


@njit(cache=True, nogil=True)
def _side(points: Points, e: Index, k: Index) -> float:
    """Twice the area that edge e sees point k under; above 0 on its left."""
    px, py = points[e, 0], points[e, 1]
    dx, dy = points[e + 1, 0] - px, points[e + 1, 1] - py
    return dx * (points[k, 1] - py) - dy * (points[k, 0] - px)


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _touch(points: Points, e: Index, f: Index, reach: float) -> bool:
    """Do edges e and f cross, or come within reach of each other?"""
    if crossed(points, e, f) >= 0.0:
        return True
    return (
        foot(points, e, points[f, 0], points[f, 1])[0] <= reach
        or foot(points, e, points[f + 1, 0], points[f + 1, 1])[0] <= reach
        or foot(points, f, points[e, 0], points[e, 1])[0] <= reach
        or foot(points, f, points[e + 1, 0], points[e + 1, 1])[0] <= reach
    )


@njit(cache=True, nogil=True)
def _folded(points: Points, e: Index, f: Index, common: Index, reach: float) -> bool:
    """Do edges e and f, which meet at point e or e + 1 = common, lie on each other?"""
    one = e + 1 if common == e else e
    two = f + 1
    if (points[f + 1] == points[common]).all():
        two = f
    return (
        foot(points, f, points[one, 0], points[one, 1])[0] <= reach
        or foot(points, e, points[two, 0], points[two, 1])[0] <= reach
    )


@njit(cache=True, nogil=True)
def _root(label: Int32Array, i: Index) -> int:
    while label[i] != i:
        label[i] = label[label[i]]
        i = label[i]
    return int(i)


@njit(cache=True, nogil=True)
def _unite(label: Int32Array, i: Index, j: Index) -> None:
    one = _root(label, i)
    two = _root(label, j)
    label[max(one, two)] = min(one, two)


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _note_touch(
    points: Points, offsets: Int32Array, s: Index, e: Index, f: Index, most: float, free: Points
) -> None:
    """Lowers free[s] to the lengths from the ends of segment s to where its edge e touches edge
    f, as far as they are below ``most``."""
    share = crossed(points, e, f)
    if share < 0.0:
        one, two = (
            foot(points, e, points[f, 0], points[f, 1]),
            foot(points, e, points[f + 1, 0], points[f + 1, 1]),
        )
        share = one[1] if one[0] < two[0] else two[1]
    size = math.hypot(points[e + 1, 0] - points[e, 0], points[e + 1, 1] - points[e, 1])
    for side in range(2):
        length = share * size if side == 0 else (1.0 - share) * size
        k = e if side == 0 else e + 1
        step = -1 if side == 0 else 1
        while length <= most and offsets[s] <= k + step < offsets[s + 1]:
            length += math.hypot(
                points[k + step, 0] - points[k, 0], points[k + step, 1] - points[k, 1]
            )
            k += step
        free[s, side] = min(free[s, side], length)


@njit(cache=True, nogil=True)
def related(
    points: Points, offsets: Int32Array, closed: Bools, rims: Bools, reach: float, gap: float
) -> tuple[Int32Array, Bools, Floats, Points]:
    """Segments that cross or touch one another, or have ends near others.

    reach: edges this close touch. gap: ends this close to another segment, or to a far part of
    their own, belong to it; not ends on the circle, nor those that only hang over from where the
    segment touches another, by no more than this.

    (s,) int32 groups by their first segment; (s,) bool, does the segment touch another or
    itself?; (s,) float64 the widest gap at an end of the segment, 0 without one; (s, 2) how far
    the segment hangs over at its ends, 0 where it does not.
    """
    n = len(closed)
    label = np.arange(n).astype(np.int32)
    touching = np.zeros(n, np.bool_)
    gaps = np.zeros(n)
    # The least length of each segment from either end to where it touches another.
    free = np.full((n, 2), np.inf)
    first, owner = edges_of(offsets)
    low = np.empty(len(first))
    for i in range(len(first)):
        low[i] = min(points[first[i], 0], points[first[i] + 1, 0])
    order = np.argsort(low, kind="mergesort")
    for a in range(len(order)):
        e = first[order[a]]
        s = owner[order[a]]
        high = max(points[e, 0], points[e + 1, 0]) + reach
        bottom = min(points[e, 1], points[e + 1, 1]) - reach
        top = max(points[e, 1], points[e + 1, 1]) + reach
        for b in range(a + 1, len(order)):
            if low[order[b]] > high:
                break
            f = first[order[b]]
            t = owner[order[b]]
            if min(points[f, 1], points[f + 1, 1]) > top:
                continue
            if max(points[f, 1], points[f + 1, 1]) < bottom:
                continue
            common = -1
            if s == t:
                last = offsets[s + 1] - 1
                if f == e + 1 or (closed[s] and f == offsets[s] and e + 1 == last):
                    common = e + 1
                elif e == f + 1 or (closed[s] and e == offsets[s] and f + 1 == last):
                    common = e
            if common >= 0:
                met = _folded(points, e, f, common, reach)
            else:
                met = _touch(points, e, f, reach)
            if met:
                touching[s] = touching[t] = True
                if s != t:
                    _note_touch(points, offsets, s, e, f, gap, free)
                    _note_touch(points, offsets, t, f, e, gap, free)
                _unite(label, s, t)
    for s in range(n):
        for side in range(2):
            if closed[s] or rims[s, side] or free[s, side] <= gap:
                continue
            near = _neighbour(points, offsets, closed, rims, s, side, gap, label)
            gaps[s] = max(gaps[s], near)
    for s in range(n):
        label[s] = _root(label, s)
        for side in range(2):
            if closed[s] or rims[s, side] or free[s, side] > gap:
                free[s, side] = 0.0
    return label, touching, gaps, free


@njit(cache=True, nogil=True)
def _neighbour(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    s: Index,
    side: Index,
    gap: float,
    label: Int32Array,
) -> float:
    """Unites segment s with the segment and with the end nearest to one of its ends, where they
    are within the gap; the greater of the two distances, 0 if neither is."""
    last = offsets[s + 1] - 1
    end = offsets[s] if side == 0 else last
    x, y = points[end, 0], points[end, 1]
    # The part of its own that the end hangs on is no neighbour.
    own_low = offsets[s]
    own_high = last
    along = 0.0
    k = end
    step = 1 if side == 0 else -1
    while offsets[s] <= k + step <= last and along < 3.0 * gap:
        along += math.hypot(points[k + step, 0] - points[k, 0], points[k + step, 1] - points[k, 1])
        k += step
    if side == 0:
        own_low = k
    else:
        own_high = k
    to_edge = np.inf
    to_end = np.inf
    edge_of = -1
    end_of = -1
    for t in range(len(closed)):
        begin = own_low if t == s else offsets[t]
        stop = own_high if t == s else offsets[t + 1] - 1
        for e in range(begin, stop):
            away = foot(points, e, x, y)[0]
            if away < to_edge:
                to_edge, edge_of = away, t
        for other in range(2):
            place = offsets[t] if other == 0 else offsets[t + 1] - 1
            if closed[t] or rims[t, other] or place == end or not begin <= place <= stop:
                continue
            away = math.hypot(points[place, 0] - x, points[place, 1] - y)
            if away < to_end:
                to_end, end_of = away, t
    widest = 0.0
    if to_edge <= gap:
        widest = to_edge
        _unite(label, s, edge_of)
    if to_end <= gap:
        widest = to_end
        _unite(label, s, end_of)
    return widest
