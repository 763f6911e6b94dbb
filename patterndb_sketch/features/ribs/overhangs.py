"""Overhangs: what segments have beyond the places where they cross others, and without it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.crossings import touched
from patterndb_sketch.features.ribs.segments import stitched

#: How many times as long the longer of two overhangs may be at a crossing. Surfaces that were
#: drawn out to meet go on beyond by much the same; one that ends against a lip does not.
ALIKE = 5.0


@kernel
def to_ends(
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
    share = touched(points, e, f)
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
def note_overhang(
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
def note_alone(
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
def chosen(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    free: Points,
    kept: NDArray[np.int64],
) -> tuple[Points, Int32Array, Bools, Bools, Points]:
    """The segments of these numbers alone."""
    result = np.empty((len(points), 2))
    starts = np.zeros(len(kept) + 1, np.int32)
    n = 0
    for i in range(len(kept)):
        for k in range(offsets[kept[i]], offsets[kept[i] + 1]):
            result[n] = points[k]
            n += 1
        starts[i + 1] = n
    return result[:n].copy(), starts, closed[kept], rims[kept], free[kept]


@kernel
def _trimmed(
    points: Points, low: Index, high: Index, first: float, last: float, result: Points, n: int
) -> int:
    """Appends the points ``low:high`` of a segment from the length first to the length last along
    it. How many points the result then has."""
    along = 0.0
    for k in range(low, high - 1):
        dx, dy = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        step = math.hypot(dx, dy)
        if step > 0.0 and along + step > first and along < last:
            if along <= first:
                share = (first - along) / step
                result[n, 0], result[n, 1] = points[k, 0] + share * dx, points[k, 1] + share * dy
                n += 1
            share = min((last - along) / step, 1.0)
            result[n] = points[k + 1]
            if share < 1.0:
                result[n, 0], result[n, 1] = points[k, 0] + share * dx, points[k, 1] + share * dy
            n += 1
        along += step
    return n


@kernel
def without_overhangs(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    free: Points,
    reach: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, bool]:
    """The segments without what hangs over, then end to end where two ends meet; was there any?

    free: (s, 2) as of related(). Segments of which all hangs over from one end go; others stay
    whole if they would lose more than they would keep.
    """
    result = np.empty((len(points), 2))
    starts = np.zeros(len(closed) + 1, np.int32)
    stay = np.ones(len(closed), np.bool_)
    n = 0
    any_over = False
    m = 0
    for s in range(len(closed)):
        low, high = offsets[s], offsets[s + 1]
        size = 0.0
        for k in range(low, high - 1):
            size += math.hypot(points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1])
        cut = np.zeros(2)
        for side in range(2):
            if free[s, side] < np.inf and free[s, side] > reach:
                cut[side] = free[s, side]
        left = size - cut[0] - cut[1]
        flap = left <= reach and (free[s, 0] <= reach or free[s, 1] <= reach)
        if flap:
            any_over = True
            stay[s] = False
            continue
        if left <= cut[0] + cut[1]:
            cut[:] = 0.0
        any_over = any_over or cut.any()
        n = _trimmed(points, low, high, cut[0], size - cut[1], result, n)
        m += 1
        starts[m] = n
    if not any_over or m == 0:
        return points, offsets, closed, rims, False
    kept = np.flatnonzero(stay)
    here = stitched(result[:n].copy(), starts[: m + 1].copy(), closed[kept], rims[kept], tolerance)
    return here[0], here[1], here[2], here[3], True
