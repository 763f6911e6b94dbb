"""Repair: segments without what hangs over where they cross others, and with small gaps bridged.

Surfaces that were drawn out to meet go on beyond the place where they cross: trim_overhangs takes
that off. Ends that face each other are joined as the surfaces on both sides go on: bridge_gaps.
mend_segments does both in turn.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.crossings import find_foot, find_nearest_segment, group_segments
from patterndb_sketch.features.ribs.slicing import chain_ends, stitch_segments

#: SHARPEST, GAP and OVERHANG in rust/features/src/ribs/repair.rs are the same as here.

#: The direction of an end is taken over this share of the gap.
SPAN = 0.25

#: Cosine of the sharpest turn at which both sides of a gap are drawn out until they meet: 120
#: degrees. So the corner is no farther than 1.16 times the gap's width from either end.
SHARPEST = -0.5

#: An end that runs at the side of another segment meets it no farther away than this many times
#: the gap: at 30 degrees or more.
STEEP = 2.0

#: Two ends face each other if all others are this many times as far from both.
LONE = 1.5

#: The other segment must not come much closer to an end than its own end does.
BESIDE = 0.7

#: How often overhangs are taken off, and ends joined: what one leaves may be for the next.
MENDS = 4

#: Ends this close to others, as a share of the radius, leave a gap that is to be closed: as much
#: as dilation may close within the picture's margin. At the usual radius 0.28 % of the diagonal,
#: or 13 mm of a car.
GAP = 0.055

#: Where two segments cross, both may hang over by this share of the radius: at the usual radius
#: 0.75 % of the diagonal, or 35 mm of a car.
OVERHANG = 0.15

#: Edges this close touch, as a share of the tolerance for stitching: points are computed to some
#: 1e-15 of the diagonal.
TOUCH = 1e-3


@kernel
def mend_segments(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    radius: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, float, bool]:
    """The segments that belong to the one nearest to the origin, without what hangs over and
    joined where that leaves no choice; the widest gap to be closed, -1 if the nearest segment is
    alone and has none; and was anything taken off or joined?"""
    gap, touch = GAP * radius, TOUCH * tolerance
    changed = False
    widest = -1.0
    for step in range(MENDS + 1):
        label, touching, gaps, free = group_segments(
            points, offsets, closed, rims, touch, gap, OVERHANG * radius
        )
        nearest = find_nearest_segment(points, offsets)[0]
        kept = np.flatnonzero(label == label[nearest])
        tangled = len(kept) > 1 or touching[nearest] or gaps[nearest] > 0.0
        widest = gaps[kept].max() if tangled else -1.0
        points, offsets, closed, rims, free = _pick_segments(
            points, offsets, closed, rims, free, kept
        )
        if not tangled or step == MENDS:
            break
        points, offsets, closed, rims, trimmed = trim_overhangs(
            points, offsets, closed, rims, free, touch, tolerance
        )
        if not trimmed:
            points, offsets, closed, rims, joins = bridge_gaps(
                points, offsets, closed, rims, free, gap, tolerance
            )
            if not joins:
                break
        changed = True
    return points, offsets, closed, rims, widest, changed


@kernel
def trim_overhangs(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    free: Points,
    reach: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, bool]:
    """The segments without what hangs over, then end to end where two ends meet; was there any?

    free: (s, 2) as of group_segments(). Segments of which all hangs over from one end go; others
    stay whole if they would lose more than they would keep.
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
        n = _append_trimmed(points, low, high, cut[0], size - cut[1], result, n)
        m += 1
        starts[m] = n
    if not any_over or m == 0:
        return points, offsets, closed, rims, False
    kept = np.flatnonzero(stay)
    here = stitch_segments(
        result[:n].copy(), starts[: m + 1].copy(), closed[kept], rims[kept], tolerance
    )
    return here[0], here[1], here[2], here[3], True


@kernel
def _pick_segments(
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
def _append_trimmed(
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
def bridge_gaps(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    free: Points,
    gap: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, int]:
    """The segments joined where two free ends face each other within the gap, and drawn out where
    one runs at the side of another; how many are.

    Source: feature curve recovery paper, section 4.3.2. Differs from the paper: it bridges gaps
    by pixels and takes points of the segments alone, which cuts corners off where surfaces end
    just short of the edge at which they would meet. There both are drawn out until they do.
    """
    open_ends = np.zeros(2 * len(closed), np.bool_)
    for s in range(len(closed)):
        for side in range(2):
            lone = free[s, side] == np.inf
            open_ends[2 * s + side] = lone and not closed[s] and not rims[s, side]
    mate, corners = _facing(points, offsets, open_ends, gap)
    joins = int((mate >= 0).sum()) // 2
    points, offsets, drawn = draw_ends_out(points, offsets, open_ends, mate, gap, tolerance)
    if not joins:
        return points, offsets, closed, rims, drawn
    entered, strings, loops = chain_ends(mate)
    result = np.empty((len(points) + joins + len(loops), 2))
    starts = np.zeros(len(strings), np.int32)
    whole = np.zeros(len(loops), np.bool_)
    ends = np.zeros((len(loops), 2), np.bool_)
    n = 0
    for i in range(len(loops)):
        first = n
        last = 0
        for k in range(strings[i], strings[i + 1]):
            at = entered[k]
            last = at ^ 1
            low, high = offsets[at >> 1], offsets[(at >> 1) + 1]
            for j in range(high - low):
                result[n] = points[low + j] if at % 2 == 0 else points[high - 1 - j]
                n += 1
            if mate[last] >= 0 and not math.isnan(corners[last, 0]):
                result[n] = corners[last]
                n += 1
        if loops[i]:
            result[n] = result[first]
            n += 1
        begin = entered[strings[i]]
        whole[i] = loops[i] or closed[begin >> 1]
        if not whole[i]:
            ends[i, 0], ends[i, 1] = rims[begin >> 1, begin & 1], rims[last >> 1, last & 1]
        starts[i + 1] = n
    return result[:n].copy(), starts, whole, ends, joins + drawn


@kernel
def draw_ends_out(
    points: Points,
    offsets: Int32Array,
    open_ends: Bools,
    mate: Int32Array,
    gap: float,
    tolerance: float,
) -> tuple[Points, Int32Array, int]:
    """Points and offsets of the segments, those ends drawn out that have no mate and run at
    another segment within the gap; how many do."""
    m = len(open_ends)
    added = np.full((m, 2), np.nan)
    count = 0
    for i in range(m):
        if not open_ends[i] or mate[i] >= 0:
            continue
        s = i >> 1
        low, high = offsets[s], offsets[s + 1]
        end = low if i % 2 == 0 else high - 1
        x, y = points[end, 0], points[end, 1]
        near = min(*_to_others(points, offsets, s, -1, x, y))
        if not tolerance < near <= gap:
            continue
        ux, uy = find_heading(points, low, high, i & 1, SPAN * near)
        away = _ahead(points, offsets, s, x, y, ux, uy)
        if away <= STEEP * near:
            added[i, 0], added[i, 1] = x + away * ux, y + away * uy
            count += 1
    if not count:
        return points, offsets, 0
    result = np.empty((len(points) + count, 2))
    starts = np.zeros(len(offsets), np.int32)
    n = 0
    for s in range(len(offsets) - 1):
        if not math.isnan(added[2 * s, 0]):
            result[n] = added[2 * s]
            n += 1
        for k in range(offsets[s], offsets[s + 1]):
            result[n] = points[k]
            n += 1
        if not math.isnan(added[2 * s + 1, 0]):
            result[n] = added[2 * s + 1]
            n += 1
        starts[s + 1] = n
    return result, starts, count


@kernel
def find_heading(
    points: Points, low: Index, high: Index, side: Index, span: float
) -> tuple[float, float]:
    """The unit direction in which the segment ``low:high`` leaves its first or last point, as the
    chord over the length ``span`` before it."""
    k = low if side == 0 else high - 1
    step = 1 if side == 0 else -1
    x, y = points[k, 0], points[k, 1]
    at_x, at_y = x, y
    left = span
    while low <= k + step < high and left > 0.0:
        dx, dy = points[k + step, 0] - points[k, 0], points[k + step, 1] - points[k, 1]
        size = math.hypot(dx, dy)
        share = min(left / size, 1.0) if size > 0.0 else 1.0
        at_x, at_y = points[k, 0] + share * dx, points[k, 1] + share * dy
        left -= size
        k += step
    size = math.hypot(x - at_x, y - at_y)
    if size == 0.0:
        return 0.0, 0.0
    return (x - at_x) / size, (y - at_y) / size


@kernel
def find_corner(
    px: float, py: float, ux: float, uy: float, qx: float, qy: float, vx: float, vy: float
) -> tuple[int, float, float]:
    """Where lines from p along the unit direction u and from q along v meet, ahead of both.

    1 and the place; 0 where they do not meet so, or turn by more than SHARPEST has, but run
    towards each other: the bridge is their chord; -1 where they do not.
    """
    dx, dy = qx - px, qy - py
    size = math.hypot(dx, dy)
    turn = ux * vy - uy * vx
    if abs(turn) > 1e-3 and -(ux * vx + uy * vy) >= SHARPEST:
        a = (dx * vy - dy * vx) / turn
        b = (dx * uy - dy * ux) / turn
        # Nearer to an end than that, the chord is as good.
        if min(a, b) > 1e-3 * size:
            return 1, px + a * ux, py + a * uy
    if ux * dx + uy * dy >= 0.5 * size and -(vx * dx + vy * dy) >= 0.5 * size:
        return 0, 0.5 * (px + qx), 0.5 * (py + qy)
    return -1, 0.0, 0.0


@kernel
def _to_others(
    points: Points, offsets: Int32Array, s: Index, t: Index, x: float, y: float
) -> tuple[float, float]:
    """Distances of a place from segment t, and from all segments but s and t."""
    one = two = np.inf
    for r in range(len(offsets) - 1):
        if r == s:
            continue
        for e in range(offsets[r], offsets[r + 1] - 1):
            away = find_foot(points, e, x, y)[0]
            if r == t:
                one = min(one, away)
            else:
                two = min(two, away)
    return one, two


@kernel
def _facing(
    points: Points, offsets: Int32Array, open_ends: Bools, gap: float
) -> tuple[Int32Array, Points]:
    """(2 s,) the end that each faces, -1 for none; (2 s, 2) the corners between them, nan for a
    straight bridge."""
    m = len(open_ends)
    at = np.empty((m, 2))
    for i in range(m):
        at[i] = points[offsets[i >> 1]] if i % 2 == 0 else points[offsets[(i >> 1) + 1] - 1]
    best = np.full(m, -1, np.int32)
    least = np.full(m, np.inf)
    second = np.full(m, np.inf)
    for i in range(m):
        if not open_ends[i]:
            continue
        for j in range(m):
            if j == i or not open_ends[j]:
                continue
            away = math.hypot(at[i, 0] - at[j, 0], at[i, 1] - at[j, 1])
            if away < least[i]:
                second[i] = least[i]
                least[i], best[i] = away, j
            else:
                second[i] = min(second[i], away)
    mate = np.full(m, -1, np.int32)
    corners = np.full((m, 2), np.nan)
    for i in range(m):
        j = best[i]
        if j < i or least[i] > gap or best[j] != i or i >> 1 == j >> 1:
            continue
        if min(second[i], second[j]) < LONE * least[i]:
            continue
        s, t = i >> 1, j >> 1
        one, other = _to_others(points, offsets, s, t, at[i, 0], at[i, 1])
        two, another = _to_others(points, offsets, t, s, at[j, 0], at[j, 1])
        if min(one, two) < BESIDE * least[i] or min(other, another) < least[i]:
            continue
        u = find_heading(points, offsets[s], offsets[s + 1], i & 1, SPAN * least[i])
        v = find_heading(points, offsets[t], offsets[t + 1], j & 1, SPAN * least[i])
        kind, x, y = find_corner(at[i, 0], at[i, 1], u[0], u[1], at[j, 0], at[j, 1], v[0], v[1])
        if kind < 0:
            continue
        mate[i], mate[j] = j, i
        if kind > 0:
            corners[i, 0], corners[i, 1] = x, y
            corners[j, 0], corners[j, 1] = x, y
    return mate, corners


@kernel
def _ahead(
    points: Points, offsets: Int32Array, s: Index, x: float, y: float, ux: float, uy: float
) -> float:
    """How far along the unit direction u from a place the next segment but s is; inf if none."""
    best = np.inf
    for r in range(len(offsets) - 1):
        if r == s:
            continue
        for e in range(offsets[r], offsets[r + 1] - 1):
            px, py = points[e, 0] - x, points[e, 1] - y
            qx, qy = points[e + 1, 0] - x, points[e + 1, 1] - y
            one, two = ux * py - uy * px, ux * qy - uy * qx
            if (one > 0.0) == (two > 0.0):
                continue
            share = one / (one - two)
            away = ux * (px + share * (qx - px)) + uy * (py + share * (qy - py))
            if 0.0 < away < best:
                best = away
    return best
