"""Segments drawn into a picture, and where along them a pixel is."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.crossings import crossed, edges_of, foot
from patterndb_sketch.features.ribs.raster import (
    CELL,
    HEIGHT,
    MARGIN,
    WIDTH,
    Picture,
    pixel,
    rendered,
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


@kernel
def framing(points: Points, radius: float) -> tuple[float, float, float, int, int]:
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
def drawn(
    points: Points, offsets: Int32Array, closed: Bools, rims: Bools, rows: int, columns: int
) -> tuple[Picture, Drawn]:
    """The picture of segments in pixels, and what else is known of it."""
    along = np.zeros(len(points))
    for s in range(len(closed)):
        for k in range(offsets[s] + 1, offsets[s + 1]):
            dx = points[k, 0] - points[k - 1, 0]
            dy = points[k, 1] - points[k - 1, 1]
            along[k] = along[k - 1] + math.hypot(dx, dy)
    first, owner = edges_of(offsets)
    picture, head, entry, link = rendered(points, first, rows, columns)
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
def place_of(
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
        share = foot(points, first[i], x + 0.5, y + 0.5)[1]
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
def stays(
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
        if not pixel(picture, q[0], q[1]):
            continue
        found = place_of(known, q[0], q[1], s, t, t, 2.0 * (j - last) + AHEAD)
        if math.isnan(found):
            break
        t = found
        last = j
        low = min(low, t)
        high = max(high, t)
    return last, low, high


@kernel
def begun(
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
        share = foot(points, first[e], x + 0.5, y + 0.5)[1]
        t = float(along[first[e]] + share * (along[first[e] + 1] - along[first[e]]))
        length = stays(known, picture, border, i, way, owner[e], t, most)[0]
        if both:
            length += stays(known, picture, border, i, -way, owner[e], t, most)[0]
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
def change(
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
                    share = crossed(pair, 0, 2)
                    if share >= 0.0:
                        other = crossed(pair, 2, 0)
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
                        away, share = foot(pair, over, pair[k, 0], pair[k, 1])
                        if away < nearest:
                            nearest = away
                            if k < 2:
                                result = (begin if k == 0 else end, start + share * (stop - start))
                            else:
                                result = (begin + share * (end - begin), start if k == 2 else stop)
            turn_two += span_two
        turn_one += span_one
    return result
