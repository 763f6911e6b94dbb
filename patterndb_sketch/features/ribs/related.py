"""Which segments belong together: they cross, touch, or leave a small gap between them."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.crossings import edges_of, folded, foot, touch
from patterndb_sketch.features.ribs.overhangs import note_alone, note_overhang, to_ends


@kernel
def _root(label: Int32Array, i: Index) -> int:
    while label[i] != i:
        label[i] = label[label[i]]
        i = label[i]
    return int(i)


@kernel
def _unite(label: Int32Array, i: Index, j: Index) -> None:
    one = _root(label, i)
    two = _root(label, j)
    label[max(one, two)] = min(one, two)


@kernel
def related(
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
            near = common >= 0
            met = folded(points, e, f, common, reach) if near else touch(points, e, f, reach)
            if met:
                touching[s] = touching[t] = True
                if s != t:
                    one = to_ends(points, offsets, closed, rims, s, e, f, overhang)
                    two = to_ends(points, offsets, closed, rims, t, f, e, overhang)
                    note_overhang(one, two, reach, gap, s, free, alone)
                    note_overhang(two, one, reach, gap, t, free, alone)
                _unite(label, s, t)
    note_alone(points, offsets, closed, rims, gap, free, alone)
    for s in range(n):
        for side in range(2):
            if closed[s] or rims[s, side]:
                free[s, side] = 0.0
            if free[s, side] < np.inf:
                continue
            near = _neighbour(points, offsets, closed, rims, s, side, gap, label)
            gaps[s] = max(gaps[s], near)
    for s in range(n):
        label[s] = _root(label, s)
    return label, touching, gaps, free


@kernel
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
