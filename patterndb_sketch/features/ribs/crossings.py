"""Where edges of segments cross and touch, how far they hang over there, and which segments belong
together: they cross, touch, or leave a small gap between them."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Floats, Points
from patterndb.system.kernels import kernel

#: How many times as long the longer of two overhangs may be at a crossing. Surfaces that were
#: drawn out to meet go on beyond by much the same; one that ends against a lip does not.
ALIKE = 5.0


@kernel
def find_foot(points: Points, e: Index, x: float, y: float) -> tuple[float, float]:
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
def find_crossing(points: Points, e: Index, f: Index) -> float:
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
def is_touching(points: Points, e: Index, f: Index, reach: float) -> bool:
    """Do edges e and f cross, or come within reach of each other?"""
    if find_crossing(points, e, f) >= 0.0:
        return True
    return (
        find_foot(points, e, points[f, 0], points[f, 1])[0] <= reach
        or find_foot(points, e, points[f + 1, 0], points[f + 1, 1])[0] <= reach
        or find_foot(points, f, points[e, 0], points[e, 1])[0] <= reach
        or find_foot(points, f, points[e + 1, 0], points[e + 1, 1])[0] <= reach
    )


@kernel
def find_touch(points: Points, e: Index, f: Index) -> float:
    """The share of edge e where edge f crosses it, or else comes nearest to it."""
    share = find_crossing(points, e, f)
    if share >= 0.0:
        return share
    least = np.inf
    for k in range(2):
        away = find_foot(points, f, points[e + k, 0], points[e + k, 1])[0]
        if away < least:
            least, share = away, float(k)
    for k in range(2):
        away, at = find_foot(points, e, points[f + k, 0], points[f + k, 1])
        if away < least:
            least, share = away, at
    return share


@kernel
def is_folded(points: Points, e: Index, f: Index, common: Index, reach: float) -> bool:
    """Do edges e and f, which meet at point e or e + 1 = common, lie on each other?"""
    one = e + 1 if common == e else e
    two = f + 1
    if (points[f + 1] == points[common]).all():
        two = f
    return (
        find_foot(points, f, points[one, 0], points[one, 1])[0] <= reach
        or find_foot(points, e, points[two, 0], points[two, 1])[0] <= reach
    )


@kernel
def list_edges(offsets: Int32Array) -> tuple[Int32Array, Int32Array]:
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
def find_nearest_segment(points: Points, offsets: Int32Array) -> tuple[int, int, float, float]:
    """Of the edge nearest to the origin: segment, first point, share at the foot, distance."""
    best = np.inf
    result = (-1, -1, 0.0, np.inf)
    for s in range(len(offsets) - 1):
        for k in range(offsets[s], offsets[s + 1] - 1):
            away, share = find_foot(points, k, 0.0, 0.0)
            if away < best:
                best = away
                result = (s, k, share, away)
    return result


@kernel
def group_segments(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    reach: float,
    gap: float,
    overhang: float,
) -> tuple[Int32Array, Bools, Floats, Points]:
    """Segments that cross or touch one another, or have ends near others.

    reach: edges this close touch. gap: ends this close to another segment, or to a far part of
    their own, belong to it; not ends on the circle, nor those that only hang over from where the
    segment touches another: by no more than the gap, or by no more than ``overhang`` where the
    other one hangs over as well, by a length that is ALIKE.

    (s,) int32 groups by their first segment; (s,) bool, does the segment touch another or
    itself?; (s,) float64 the widest gap at an end of the segment, 0 without one; (s, 2) how far
    the segment hangs over at its ends, 0 where it ends on another, inf where it is free.
    """
    n = len(closed)
    label = np.arange(n).astype(np.int32)
    touching = np.zeros(n, np.bool_)
    gaps = np.zeros(n)
    # The least length of each segment from either end to where it touches another.
    free = np.full((n, 2), np.inf)
    alone = np.full((n, 2), np.inf)
    first, owner = list_edges(offsets)
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
            near = common >= 0
            met = (
                is_folded(points, e, f, common, reach) if near else is_touching(points, e, f, reach)
            )
            if met:
                touching[s] = touching[t] = True
                if s != t:
                    one = _measure_to_ends(points, offsets, closed, rims, s, e, f, overhang)
                    two = _measure_to_ends(points, offsets, closed, rims, t, f, e, overhang)
                    _note_overhang(one, two, reach, gap, s, free, alone)
                    _note_overhang(two, one, reach, gap, t, free, alone)
                _unite(label, s, t)
    _note_alone(points, offsets, closed, rims, gap, free, alone)
    for s in range(n):
        for side in range(2):
            if closed[s] or rims[s, side]:
                free[s, side] = 0.0
            if free[s, side] < np.inf:
                continue
            near = _unite_neighbours(points, offsets, closed, rims, s, side, gap, label)
            gaps[s] = max(gaps[s], near)
    for s in range(n):
        label[s] = _find_root(label, s)
    return label, touching, gaps, free


@kernel
def _measure_to_ends(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    s: Index,
    e: Index,
    f: Index,
    most: float,
) -> tuple[float, float]:
    """The lengths from both ends of segment s to where its edge e touches edge f; inf for those
    above ``most``, and from ends that are none, or on the circle."""
    if closed[s]:
        return np.inf, np.inf
    share = find_touch(points, e, f)
    size = math.hypot(points[e + 1, 0] - points[e, 0], points[e + 1, 1] - points[e, 1])
    before, after = share * size, (1.0 - share) * size
    k = e
    while before <= most and k > offsets[s]:
        before += math.hypot(points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1])
        k -= 1
    k = e + 1
    while after <= most and k + 1 < offsets[s + 1]:
        after += math.hypot(points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1])
        k += 1
    if before > most or rims[s, 0]:
        before = np.inf
    if after > most or rims[s, 1]:
        after = np.inf
    return before, after


@kernel
def _note_overhang(
    own: tuple[float, float],
    other: tuple[float, float],
    reach: float,
    gap: float,
    s: Index,
    free: Points,
    alone: Points,
) -> None:
    """Lowers free[s] to the lengths ``own`` from where segment s touches another, of which the
    lengths ``other`` are left there, as far as both hang over; else alone[s]."""
    beyond = min(other[0], other[1])
    if beyond <= reach:
        # The other one ends here, or all of it hangs over.
        beyond = max(other[0], other[1])
    for side in range(2):
        length = own[side]
        alike = length < np.inf and beyond <= ALIKE * length and length <= ALIKE * beyond
        if alike or length <= reach:
            free[s, side] = min(free[s, side], length)
        elif length <= gap:
            alone[s, side] = min(alone[s, side], length)


@kernel
def _note_alone(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    gap: float,
    free: Points,
    alone: Points,
) -> None:
    """Lowers free to alone, but not at ends that have another free end within the gap: there the
    surface goes on, and what touches it is behind it."""
    wide = free.copy()
    for s in range(len(closed)):
        for side in range(2):
            if alone[s, side] >= free[s, side]:
                continue
            end = offsets[s] if side == 0 else offsets[s + 1] - 1
            faced = False
            for t in range(len(closed)):
                for other in range(2):
                    if t == s or closed[t] or rims[t, other] or wide[t, other] < np.inf:
                        continue
                    k = offsets[t] if other == 0 else offsets[t + 1] - 1
                    dx, dy = points[k, 0] - points[end, 0], points[k, 1] - points[end, 1]
                    faced = faced or math.hypot(dx, dy) <= gap
            if not faced:
                free[s, side] = alone[s, side]


@kernel
def _unite_neighbours(
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
            away = find_foot(points, e, x, y)[0]
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


@kernel
def _unite(label: Int32Array, i: Index, j: Index) -> None:
    one = _find_root(label, i)
    two = _find_root(label, j)
    label[max(one, two)] = min(one, two)


@kernel
def _find_root(label: Int32Array, i: Index) -> int:
    while label[i] != i:
        label[i] = label[label[i]]
        i = label[i]
    return int(i)
