"""From a contour's pixels back to the segments that were drawn: which of them it runs along, from
where to where."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.drawing import AHEAD, Drawn, begun, change, place_of, stays
from patterndb_sketch.features.ribs.raster import Picture, pixel

#: Pixels that the contour must go back along a segment before it counts as turned round.
BACK = 3.5

#: Pixels from the circle at which a rib ends.
AT_RIM = 1.5

#: Pixels that a change between segments may lie before or behind where both are in one pixel.
SLACK = 3.0

#: Contour pixels looked ahead for whether a walk leaves the segment that it begins on.
LEAVING = 12

#: Contour pixels looked back, and ahead, at a change between segments: half of the picture.
LOOK = 400

#: How a walk ends: where it began, at the circle, at the free end of a sheet, or where it meets
#: itself.
AROUND, RIM_MET, SHEET_END, MET_ITSELF = 0, 1, 2, 3

#: Runs along segments: (r,) segments, (r,) places where they begin, (r,) where they end.
Runs = tuple[Int32Array, Floats, Floats]


@kernel
def _end_near(known: Drawn, s: Index, t: float, reach: float) -> tuple[int, float]:
    """0 or 1 for the end of an open segment within reach of t, and its place; else (-1, t)."""
    _, along, offsets, closed, _, _, _, _, _, _, _ = known
    whole = along[offsets[s + 1] - 1]
    if not closed[s]:
        if t <= reach and t <= whole - t:
            return 0, 0.0
        if whole - t <= reach:
            return 1, float(whole)
    return -1, t


@kernel
def _covered(known: Drawn, runs: Runs, n: Index, s: Index, t: float) -> bool:
    """Is place t of segment s within one of the runs?"""
    _, along, offsets, closed, _, _, _, _, _, _, _ = known
    segment, begin, end = runs
    for k in range(n):
        if segment[k] != s:
            continue
        low, high = min(begin[k], end[k]), max(begin[k], end[k])
        place = t
        if closed[s]:
            whole = along[offsets[s + 1] - 1]
            place += whole * np.round((0.5 * (low + high) - t) / whole)
        if low + SLACK < place < high - SLACK:
            return True
    return False


@kernel
def _sense(
    known: Drawn, picture: Picture, border: Int32Array, start: Index, way: Index, s: Index, t: float
) -> float:
    """+1 or -1: the sense in which a contour that leaves segment s at pixel ``start`` came along
    it; 0 if it stays on it, or none can be told."""
    _, low, high = stays(known, picture, border, start, way, s, t, LEAVING)
    if high - low > 2.0:
        return 0.0
    _, low, high = stays(known, picture, border, start, -way, s, t, LEAVING)
    if max(high - t, t - low) <= 2.0:
        return 0.0
    return 1.0 if t - low > high - t else -1.0


@kernel
def walk(
    known: Drawn,
    picture: Picture,
    border: Int32Array,
    start: Index,
    way: Index,
    s: Index,
    t: float,
    taken: Runs,
) -> tuple[Int32Array, Floats, Floats, int]:
    """Follows a contour from pixel ``start``, at place t of segment s, with way +1 or -1, until
    it comes upon runs that are taken, its own or those given.

    The runs along segments, and how the walk ended. The contour stays on a segment as long as
    that is in its pixels, then changes to the one that it will stay on longest: where segments
    lie within one pixel it does not change to and fro. Where it comes back along a segment from a
    free end, a fin on another segment is left out; any other end of a sheet ends the rib, for
    behind it the other side begins.

    Source: feature curve recovery paper, section 4.3.2, figure 4. Differs from the paper: it
    changes at once to the first segment on a cell's border, cell by cell, and takes both sides of
    open sheets.
    """
    n = len(border)
    segment = np.empty(n + 1, np.int32)
    begin = np.empty(n + 1)
    end = np.empty(n + 1)
    sense = np.zeros(n + 1)
    # Where the contour came onto the segment, which is not where the change was put.
    entry = np.empty(n + 1)
    came = np.zeros(n + 1, np.int32)
    history = np.full(n + 1, np.nan)
    runs = (segment, begin, end)
    saved = (np.empty(0, np.int32), np.empty(0), np.empty(0))
    segment[0] = s
    begin[0] = end[0] = entry[0] = history[0] = t
    sense[0] = _sense(known, picture, border, start, way, s, t)
    r = 0
    farthest = t
    back = False
    last = 0
    rims = known[4]
    ended = AROUND
    for j in range(1, n):
        q = border[(start + way * j) % n]
        if not pixel(picture, q[0], q[1]):
            continue
        steps = j - last
        expected = t - sense[r] * steps if back else t + sense[r] * steps
        found = place_of(known, q[0], q[1], s, t, expected, 2.0 * steps + AHEAD)
        if math.isnan(found) and back:
            if abs(t - entry[r]) > 2.0 * steps + AHEAD + SLACK:
                ended = SHEET_END
                break
            if r == 0:
                # The walk began on a fin, beside its foot.
                end[0], sense[0] = begin[0], 0.0
            else:
                r -= 1
            s, t, farthest, back = segment[r], end[r], end[r], False
            found = place_of(
                known, q[0], q[1], s, t, t + sense[r], 2.0 * steps + AHEAD + SLACK
            )  # fmt: skip
        if math.isnan(found):
            following, place = begun(
                known, picture, border, (start + way * j) % n, way, min(LOOK, n), False
            )
            if following < 0:
                continue
            own = _covered(known, runs, r + 1, following, place)
            if own or _covered(known, taken, len(taken[0]), following, place):
                ended = MET_ITSELF
                break
            low = high = t
            most = min(j - came[r], LOOK) + 1
            here = (start + way * j) % n
            both, least, greatest = stays(
                known, picture, border, here, -way, following, place, most
            )  # fmt: skip
            for k in range(max(j - both, 0), j):
                if not math.isnan(history[k]):
                    low, high = min(low, history[k]), max(high, history[k])
            pad = SLACK + steps
            end[r], begin[r + 1] = change(
                known, s, low - pad, high + pad, following, least - pad, greatest + pad, t
            )
            r += 1
            segment[r], entry[r], sense[r], came[r] = following, place, 0.0, j
            end[r] = place
            s, t, farthest = following, place, place
            saved = (segment[:0], begin[:0], end[:0])
        else:
            t = found
            if _covered(known, taken, len(taken[0]), s, t):
                ended = MET_ITSELF
                break
            if sense[r] == 0.0 and abs(t - entry[r]) > 2.0:
                sense[r] = 1.0 if t > entry[r] else -1.0
                farthest = t
                end[r] = t
            if back:
                over = (t - entry[r]) * sense[r]
                if r == 0 and over <= -SLACK:
                    ended = SHEET_END
                    break
                if r > 0 and over <= SLACK:
                    r -= 1
                    s, t, farthest, back = segment[r], end[r], end[r], False
            elif (t - farthest) * sense[r] > 0.0:
                if len(saved[0]) and (t - end[r]) * sense[r] > BACK:
                    saved = (segment[:0], begin[:0], end[:0])
                farthest = t
                if not len(saved[0]):
                    end[r] = t
            elif (farthest - t) * sense[r] > BACK:
                tip = _end_near(known, s, farthest, SLACK)
                if not len(saved[0]):
                    end[r] = tip[1]
                    saved = (
                        segment[: r + 1].copy(), begin[: r + 1].copy(), end[: r + 1].copy()
                    )  # fmt: skip
                if tip[0] >= 0 and rims[s, tip[0]]:
                    ended = RIM_MET
                    break
                back = True
        history[j] = t
        last = j
        if not back:
            side, exact = _end_near(known, s, t, AT_RIM)
            # At the very beginning, at the circle, the walk may lead away from it.
            leaving = (exact - entry[r]) * sense[r] <= 0.0 and sense[r] != 0.0
            if side >= 0 and rims[s, side] and not leaving and (r > 0 or sense[r] != 0.0):
                end[r] = exact
                ended = RIM_MET
                saved = (segment[:0], begin[:0], end[:0])
                break
    if back and len(saved[0]):
        ended = SHEET_END
    if len(saved[0]) and ended != AROUND:
        return saved[0], saved[1], saved[2], ended
    return segment[: r + 1].copy(), begin[: r + 1].copy(), end[: r + 1].copy(), ended
