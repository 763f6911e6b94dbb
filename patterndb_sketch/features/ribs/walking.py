"""From segments to a picture and back: drawing them, finding where along them a pixel is, and
following a contour's pixels along them, from where to where."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.crossings import find_crossing, find_foot, list_edges
from patterndb_sketch.features.ribs.raster import (
    CELL,
    HEIGHT,
    MARGIN,
    WIDTH,
    Picture,
    is_set,
    render_edges,
)

#: What the kernels here hand on: points (p, 2) in pixels, lengths along (p,), offsets (s + 1,),
#: closed (s,), rims (s, 2); the edges' first points (e,) and owners (e,); per cell the head of
#: its list, the list's edges and links, and how many cells are in a row.
Drawn = tuple[
    Points, Floats, Int32Array, Bools, Bools, Int32Array, Int32Array,
    Int32Array, Int32Array, Int32Array, int,
]  # fmt: skip

#: Pixels by which a segment may run ahead of the contour from one of its pixels to the next,
#: beside twice the contour's steps: an edge crosses a pixel in up to 1.5.
AHEAD = 4.0

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
#: itself. ``Ended`` in rust/features/src/ribs/walking.rs has the same numbers.
AROUND, RIM_MET, SHEET_END, MET_ITSELF = 0, 1, 2, 3

#: Runs along segments: (r,) segments, (r,) places where they begin, (r,) where they end.
Runs = tuple[Int32Array, Floats, Floats]


@kernel
def fit_picture(points: Points, radius: float) -> tuple[float, float, float, int, int]:
    """Pixels to a unit, the place of pixel 0, 0, and the picture's rows and columns of cells.

    The picture is the part of WIDTH x HEIGHT pixels that the points need; MARGIN stays free, and
    a pixel is never smaller than if the whole circle lay across the picture.
    """
    low_x, low_y = points[:, 0].min(), points[:, 1].min()
    wide, high = points[:, 0].max() - low_x, points[:, 1].max() - low_y
    scale = (WIDTH - 2 * MARGIN) / (2.0 * radius)
    if high * scale > HEIGHT - 2 * MARGIN:
        scale = (HEIGHT - 2 * MARGIN) / high
    rows = int(high * scale + 2 * MARGIN) // CELL + 1
    columns = int(wide * scale + 2 * MARGIN) // CELL + 1
    return scale, low_x - MARGIN / scale, low_y - MARGIN / scale, rows, columns


@kernel
def draw_segments(
    points: Points, offsets: Int32Array, closed: Bools, rims: Bools, rows: int, columns: int
) -> tuple[Picture, Drawn]:
    """The picture of segments in pixels, and what else is known of it."""
    along = np.zeros(len(points))
    for s in range(len(closed)):
        for k in range(offsets[s] + 1, offsets[s + 1]):
            dx = points[k, 0] - points[k - 1, 0]
            dy = points[k, 1] - points[k - 1, 1]
            along[k] = along[k - 1] + math.hypot(dx, dy)
    first, owner = list_edges(offsets)
    picture, head, entry, link = render_edges(points, first, rows, columns)
    return picture, (
        points, along, offsets, closed, rims, first, owner, head, entry, link, columns
    )  # fmt: skip


@kernel
def _in_pixel(points: Points, e: Index, x: Index, y: Index) -> bool:
    """Does the edge from point e pass through the pixel?"""
    low = 0.0
    high = 1.0
    for c in range(2):
        begin = float(x if c == 0 else y) - 1e-9
        p = points[e, c]
        d = points[e + 1, c] - p
        if d == 0.0:
            if p < begin or p > begin + 1.0 + 2e-9:
                return False
        else:
            one = (begin - p) / d
            two = (begin + 1.0 + 2e-9 - p) / d
            low = max(low, min(one, two))
            high = min(high, max(one, two))
    return low <= high


@kernel
def locate_pixel(
    known: Drawn, x: Index, y: Index, s: Index, t: float, expected: float, reach: float
) -> float:
    """Where along segment s, in pixels, the pixel is: within reach of t, nearest to ``expected``;
    nan if nowhere. On a closed segment the number goes on counting beyond its length."""
    points, along, offsets, closed, _, first, owner, head, entry, link, columns = known
    best = float(math.nan)
    k = head[(y >> 3) * columns + (x >> 3)]
    while k >= 0:
        i = entry[k]
        k = link[k]
        if owner[i] != s or not _in_pixel(points, first[i], x, y):
            continue
        share = find_foot(points, first[i], x + 0.5, y + 0.5)[1]
        place = float(along[first[i]] + share * (along[first[i] + 1] - along[first[i]]))
        if closed[s]:
            whole = along[offsets[s + 1] - 1]
            place += float(whole * np.round((expected - place) / whole))
        if abs(place - t) > reach:
            continue
        if math.isnan(best) or abs(place - expected) < abs(best - expected):
            best = place
    return best


@kernel
def follow_segment(
    known: Drawn,
    picture: Picture,
    border: Int32Array,
    i: Index,
    way: Index,
    s: Index,
    t: float,
    most: Index,
) -> tuple[int, float, float]:
    """How many pixels the contour runs on along segment s from pixel i, where t is, and the least
    and the greatest place on the way; pixels without any segment count if more of s follows."""
    n = len(border)
    low = high = t
    last = 0
    for j in range(1, most):
        q = border[(i + way * j) % n]
        if not is_set(picture, q[0], q[1]):
            continue
        found = locate_pixel(known, q[0], q[1], s, t, t, 2.0 * (j - last) + AHEAD)
        if math.isnan(found):
            break
        t = found
        last = j
        low = min(low, t)
        high = max(high, t)
    return last, low, high


@kernel
def choose_segment(
    known: Drawn,
    picture: Picture,
    border: Int32Array,
    i: Index,
    way: Index,
    most: Index,
    both: bool,
) -> tuple[int, float]:
    """Of the segments in pixel i the one that the contour stays on longest, and where on it.

    both: the pixels before count as well as those after. (-1, 0) if there is none.
    """
    points, along, _, _, _, first, owner, head, entry, link, columns = known
    x, y = border[i, 0], border[i, 1]
    best = -1
    segment = -1
    place = 0.0
    k = head[(y >> 3) * columns + (x >> 3)]
    while k >= 0:
        e = entry[k]
        k = link[k]
        if not _in_pixel(points, first[e], x, y):
            continue
        share = find_foot(points, first[e], x + 0.5, y + 0.5)[1]
        t = float(along[first[e]] + share * (along[first[e] + 1] - along[first[e]]))
        length = follow_segment(known, picture, border, i, way, owner[e], t, most)[0]
        if both:
            length += follow_segment(known, picture, border, i, -way, owner[e], t, most)[0]
        if length > best or (length == best and owner[e] < segment):
            best = length
            segment = int(owner[e])
            place = t
    return segment, place


@kernel
def _part(points: Points, e: Index, low: float, high: float, result: Points, at: Index) -> None:
    """Sets points at, at + 1 of the result to those at shares low and high of edge e."""
    for c in range(2):
        d = points[e + 1, c] - points[e, c]
        result[at, c] = points[e, c] + low * d
        result[at + 1, c] = points[e, c] + high * d


@kernel
def find_change(
    known: Drawn,
    one: Index,
    low: float,
    high: float,
    two: Index,
    least: float,
    most: float,
    t: float,
) -> tuple[float, float]:
    """Where to change from segment one to two: their crossing nearest to place t of the first, or
    the nearest pair of places; between low and high of the one, least and most of the other."""
    points, along, offsets, closed, _, _, _, _, _, _, _ = known
    pair = np.empty((4, 2))
    nearest = np.inf
    result = (t, 0.5 * (least + most))
    span_one = along[offsets[one + 1] - 1] if closed[one] else np.inf
    span_two = along[offsets[two + 1] - 1] if closed[two] else np.inf
    turn_one = math.floor(low / span_one) * span_one if closed[one] else 0.0
    while turn_one <= high:
        turn_two = math.floor(least / span_two) * span_two if closed[two] else 0.0
        while turn_two <= most:
            for e in range(offsets[one], offsets[one + 1] - 1):
                begin = max(low, along[e] + turn_one)
                end = min(high, along[e + 1] + turn_one)
                if begin > end or along[e + 1] == along[e]:
                    continue
                size = along[e + 1] - along[e]
                _part(
                    points, e, (begin - turn_one - along[e]) / size,
                    (end - turn_one - along[e]) / size, pair, 0,
                )  # fmt: skip
                for f in range(offsets[two], offsets[two + 1] - 1):
                    start = max(least, along[f] + turn_two)
                    stop = min(most, along[f + 1] + turn_two)
                    if start > stop or along[f + 1] == along[f]:
                        continue
                    size = along[f + 1] - along[f]
                    _part(
                        points, f, (start - turn_two - along[f]) / size,
                        (stop - turn_two - along[f]) / size, pair, 2,
                    )  # fmt: skip
                    share = find_crossing(pair, 0, 2)
                    if share >= 0.0:
                        other = find_crossing(pair, 2, 0)
                        place = begin + share * (end - begin)
                        # Crossings come before any pair that is apart.
                        rank = abs(place - t) - 1e9
                        if rank < nearest:
                            nearest = rank
                            result = (place, start + other * (stop - start))
                        continue
                    if nearest < 0.0:
                        continue
                    for k in range(4):
                        over = 2 if k < 2 else 0
                        away, share = find_foot(pair, over, pair[k, 0], pair[k, 1])
                        if away < nearest:
                            nearest = away
                            if k < 2:
                                result = (begin if k == 0 else end, start + share * (stop - start))
                            else:
                                result = (begin + share * (end - begin), start if k == 2 else stop)
            turn_two += span_two
        turn_one += span_one
    return result


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
def _is_covered(known: Drawn, runs: Runs, n: Index, s: Index, t: float) -> bool:
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
    _, low, high = follow_segment(known, picture, border, start, way, s, t, LEAVING)
    if high - low > 2.0:
        return 0.0
    _, low, high = follow_segment(known, picture, border, start, -way, s, t, LEAVING)
    if max(high - t, t - low) <= 2.0:
        return 0.0
    return 1.0 if t - low > high - t else -1.0


@kernel
def walk_contour(
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
        if not is_set(picture, q[0], q[1]):
            continue
        steps = j - last
        expected = t - sense[r] * steps if back else t + sense[r] * steps
        found = locate_pixel(known, q[0], q[1], s, t, expected, 2.0 * steps + AHEAD)
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
            found = locate_pixel(
                known, q[0], q[1], s, t, t + sense[r], 2.0 * steps + AHEAD + SLACK
            )  # fmt: skip
        if math.isnan(found):
            following, place = choose_segment(
                known, picture, border, (start + way * j) % n, way, min(LOOK, n), False
            )
            if following < 0:
                continue
            own = _is_covered(known, runs, r + 1, following, place)
            if own or _is_covered(known, taken, len(taken[0]), following, place):
                ended = MET_ITSELF
                break
            low = high = t
            most = min(j - came[r], LOOK) + 1
            here = (start + way * j) % n
            both, least, greatest = follow_segment(
                known, picture, border, here, -way, following, place, most
            )  # fmt: skip
            for k in range(max(j - both, 0), j):
                if not math.isnan(history[k]):
                    low, high = min(low, history[k]), max(high, history[k])
            pad = SLACK + steps
            end[r], begin[r + 1] = find_change(
                known, s, low - pad, high + pad, following, least - pad, greatest + pad, t
            )
            r += 1
            segment[r], entry[r], sense[r], came[r] = following, place, 0.0, j
            end[r] = place
            s, t, farthest = following, place, place
            saved = (segment[:0], begin[:0], end[:0])
        else:
            t = found
            if _is_covered(known, taken, len(taken[0]), s, t):
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
