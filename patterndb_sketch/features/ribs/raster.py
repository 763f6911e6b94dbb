"""The picture of a slice, one bit to the pixel: dilation, erosion that keeps its topology, and the
outer contours, of which one passes the backbone.

A picture is (rows, columns) uint64, a number to every cell of 8 x 8 pixels: bit 8 y + x of it is
the pixel at x, y in the cell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

Picture = NDArray[np.uint64]

#: Pixels of the whole picture, and of a cell's side; from the paper, section 4.3.2.
WIDTH, HEIGHT, CELL = 800, 600, 8

#: Pixels left free at every side, so that dilation never meets the border. ``MARGIN`` in
#: rust/features/src/ribs/walking.rs is the same.
MARGIN = 12

_ONE = np.uint64(1)
_EIGHT = np.uint64(8)
_ROW = np.uint64(56)
_NONE = np.uint64(0)
_NOT_FIRST = np.uint64(0xFEFEFEFEFEFEFEFE)
_NOT_LAST = np.uint64(0x7F7F7F7F7F7F7F7F)
_SEVEN = np.uint64(7)

#: Steps to the eight neighbours, counter-clockwise from the right.
STEPS = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]], np.int32)

#: Pixels to either side over which a contour's direction is measured.
SPAN = 4

#: Cosine between a contour's outward direction and the wanted one from which they agree.
AGREE = 0.2

#: Pixels that a place on the wrong side counts as being farther off: more than any picture has.
_WRONG_SIDE = 1e4


def _ring_rules() -> NDArray[np.bool_]:
    """(256,) may a pixel go whose neighbours, counter-clockwise from the right, are these bits?

    Yes if the ring switches once each way, and one of the four that share a side is background.
    """
    rules = np.zeros(256, np.bool_)
    for ring in range(256):
        bits = [(ring >> k) & 1 for k in range(8)]
        switches = sum(bits[k] != bits[(k + 1) % 8] for k in range(8))
        rules[ring] = switches == 2 and not all(bits[::2])
    return rules


#: Differs from the paper: it has "at most one switch" alone, which lets interior pixels go (no
#: switch at all); and a pixel whose one background neighbour is across a corner would become a
#: hole. Sides, not corners, join background; corners join foreground. ``MAY_GO`` in
#: rust/features/src/ribs/raster.rs is the same table.
MAY_GO = _ring_rules()


@kernel
def is_set(picture: Picture, x: Index, y: Index) -> bool:
    """Is the pixel set? Those outside the picture are not."""
    if x < 0 or y < 0 or (x >> 3) >= picture.shape[1] or (y >> 3) >= picture.shape[0]:
        return False
    return (picture[y >> 3, x >> 3] >> np.uint64(8 * (y & 7) + (x & 7))) & _ONE != np.uint64(0)


@kernel
def set_pixel(picture: Picture, x: Index, y: Index) -> None:
    picture[y >> 3, x >> 3] |= _ONE << np.uint64(8 * (y & 7) + (x & 7))


@kernel
def read_ring(picture: Picture, x: Index, y: Index) -> int:
    """The eight neighbours as bits, counter-clockwise from the right (y up)."""
    bits = 0
    if 0 < (x & 7) < 7 and 0 < (y & 7) < 7:
        # All within one cell: the rows below, of the pixel, and above.
        word = picture[y >> 3, x >> 3]
        at = 8 * (y & 7) + (x & 7)
        low = np.int64((word >> np.uint64(at - 9)) & _SEVEN)
        middle = np.int64((word >> np.uint64(at - 1)) & _SEVEN)
        high = np.int64((word >> np.uint64(at + 7)) & _SEVEN)
        bits = (middle >> 2) | (high & 4) >> 1 | (high & 2) << 1 | (high & 1) << 3
        return int(bits | (middle & 1) << 4 | (low & 1) << 5 | (low & 2) << 5 | (low & 4) << 5)
    if is_set(picture, x + 1, y):
        bits |= 1
    if is_set(picture, x + 1, y + 1):
        bits |= 2
    if is_set(picture, x, y + 1):
        bits |= 4
    if is_set(picture, x - 1, y + 1):
        bits |= 8
    if is_set(picture, x - 1, y):
        bits |= 16
    if is_set(picture, x - 1, y - 1):
        bits |= 32
    if is_set(picture, x, y - 1):
        bits |= 64
    if is_set(picture, x + 1, y - 1):
        bits |= 128
    return bits


@kernel
def dilate(picture: Picture) -> Picture:
    """Every pixel that is set, or touches one that is, by a side or a corner."""
    rows, columns = picture.shape
    wide = np.empty_like(picture)
    for r in range(rows):
        for c in range(columns):
            word = picture[r, c]
            wide[r, c] = word | ((word << _ONE) & _NOT_FIRST) | ((word >> _ONE) & _NOT_LAST)
            if c > 0:
                wide[r, c] |= (picture[r, c - 1] >> _SEVEN) & ~_NOT_FIRST
            if c + 1 < columns:
                wide[r, c] |= (picture[r, c + 1] << _SEVEN) & ~_NOT_LAST
    result = np.empty_like(picture)
    for r in range(rows):
        for c in range(columns):
            word = wide[r, c]
            result[r, c] = word | (word << _EIGHT) | (word >> _EIGHT)
            if r > 0:
                result[r, c] |= wide[r - 1, c] >> _ROW
            if r + 1 < rows:
                result[r, c] |= wide[r + 1, c] << _ROW
    return result


@kernel
def _inner(picture: Picture) -> Picture:
    """Every pixel that is set as are all its neighbours, by sides and corners."""
    rows, columns = picture.shape
    wide = np.empty_like(picture)
    for r in range(rows):
        for c in range(columns):
            word = picture[r, c]
            left = (word << _ONE) & _NOT_FIRST
            right = (word >> _ONE) & _NOT_LAST
            if c > 0:
                left |= (picture[r, c - 1] >> _SEVEN) & ~_NOT_FIRST
            if c + 1 < columns:
                right |= (picture[r, c + 1] << _SEVEN) & ~_NOT_LAST
            wide[r, c] = word & left & right
    result = np.empty_like(picture)
    for r in range(rows):
        for c in range(columns):
            word = wide[r, c]
            below = word << _EIGHT
            above = word >> _EIGHT
            if r > 0:
                below |= wide[r - 1, c] >> _ROW
            if r + 1 < rows:
                above |= wide[r + 1, c] << _ROW
            result[r, c] = word & below & above
    return result


@kernel
def erode(picture: Picture, first: Picture) -> None:
    """Takes one layer off a picture, in place, but no pixel of ``first``, and no part or hole
    comes, goes or changes.

    The layer is what touches background at the beginning, by a side or a corner, just as
    dilation adds it. Pixels are looked at one by one, since two of a bridge may not go at once,
    and twice, since those at corners can go only after those at sides.
    """
    layer = _inner(picture)
    rows, columns = picture.shape
    for r in range(rows):
        for c in range(columns):
            layer[r, c] = picture[r, c] & ~first[r, c] & ~layer[r, c]
    for _ in range(2):
        for r in range(rows):
            for c in range(columns):
                rest = layer[r, c]
                if rest == _NONE:
                    continue
                for b in range(64):
                    if rest >> np.uint64(b) == _NONE:
                        break
                    bit = _ONE << np.uint64(b)
                    if rest & bit == _NONE:
                        continue
                    if MAY_GO[read_ring(picture, 8 * c + (b & 7), 8 * r + (b >> 3))]:
                        picture[r, c] &= ~bit
                        layer[r, c] &= ~bit


@kernel
def render_edges(
    points: Points, first: Int32Array, rows: int, columns: int
) -> tuple[Picture, Int32Array, Int32Array, Int32Array]:
    """The picture (rows, columns) of the edges from points first[i] to first[i] + 1, in pixels.

    All pixels that an edge passes through are set. For each cell the edges in it, in a list:
    head (rows * columns,) its first entry or -1; edge (n,) by number; link (n,) the next entry.
    """
    picture = np.zeros((rows, columns), np.uint64)
    head = np.full(rows * columns, -1, np.int32)
    room = 4 * len(first) + 64
    edge = np.empty(room, np.int32)
    link = np.empty(room, np.int32)
    n = 0
    for i in range(len(first)):
        px, py = points[first[i], 0], points[first[i], 1]
        qx, qy = points[first[i] + 1, 0], points[first[i] + 1, 1]
        x, y = math.floor(px), math.floor(py)
        last_x, last_y = math.floor(qx), math.floor(qy)
        dx, dy = qx - px, qy - py
        step_x = 1 if dx > 0.0 else -1
        step_y = 1 if dy > 0.0 else -1
        steps = abs(last_x - x) + abs(last_y - y)
        # Where along the edge the next column and the next row begin.
        next_x = (x + (1 if dx > 0.0 else 0) - px) / dx if last_x != x else np.inf
        next_y = (y + (1 if dy > 0.0 else 0) - py) / dy if last_y != y else np.inf
        cell = -1
        for step in range(steps + 1):
            set_pixel(picture, x, y)
            here = (y >> 3) * columns + (x >> 3)
            if here != cell:
                cell = here
                if n == room:
                    edge = np.concatenate((edge, np.empty(room, np.int32)))
                    link = np.concatenate((link, np.empty(room, np.int32)))
                    room *= 2
                edge[n] = i
                link[n] = head[cell]
                head[cell] = n
                n += 1
            if step == steps:
                break
            if y == last_y or (x != last_x and next_x < next_y):
                x += step_x
                next_x += 1.0 / abs(dx)
            else:
                y += step_y
                next_y += 1.0 / abs(dy)
    return picture, head, edge[:n], link[:n]


@kernel
def close_gaps(picture: Picture, rounds: int) -> Picture:
    """The picture after so many dilations, then as many erosions."""
    result = picture.copy()
    for _ in range(rounds):
        result = dilate(result)
    for _ in range(rounds):
        erode(result, picture)
    return result


@kernel
def trace_border(picture: Picture, x: int, y: int, seen: Picture) -> Int32Array:
    """(n, 2) the pixels of the border that begins at x, y, whose left neighbour and lower three
    are background; each step to a neighbour, background on the right. They are set in ``seen``.

    Ends where the first step would be made again; a pixel may come more than once.
    """
    room = 256
    result = np.empty((room, 2), np.int32)
    result[0, 0], result[0, 1] = x, y
    set_pixel(seen, x, y)
    n = 1
    way = 7
    while True:
        # The first neighbour counter-clockwise from the background on the right.
        way = (way + 7) % 8 if way % 2 == 0 else (way + 6) % 8
        at_x, at_y = result[n - 1, 0], result[n - 1, 1]
        found = False
        for _ in range(8):
            if is_set(picture, at_x + STEPS[way, 0], at_y + STEPS[way, 1]):
                found = True
                break
            way = (way + 1) % 8
        if not found:
            return result[:1].copy()
        at_x += STEPS[way, 0]
        at_y += STEPS[way, 1]
        again = n > 1 and at_x == result[1, 0] and at_y == result[1, 1]
        if again and result[n - 1, 0] == x and result[n - 1, 1] == y:
            return result[: n - 1].copy()
        if n == room:
            result = np.concatenate((result, np.empty((room, 2), np.int32)))
            room *= 2
        result[n, 0], result[n, 1] = at_x, at_y
        set_pixel(seen, at_x, at_y)
        n += 1


@kernel
def _area(border: Int32Array) -> int:
    """Twice the area that a border runs around, negative for those of holes."""
    total = 0
    for i in range(len(border)):
        j = i + 1 if i + 1 < len(border) else 0
        total += border[i, 0] * border[j, 1] - border[i, 1] * border[j, 0]
    return total


@kernel
def find_outer_contour(picture: Picture, x: float, y: float) -> Int32Array:
    """(n, 2) the pixels of the outer contour nearest to a place, counter-clockwise.

    Source: feature curve recovery paper, section 4.3.2. Differs from the paper: it steps from
    cell to cell, to the next pixel that is set on the cell's border. That takes two parts in one
    cell for one, so the contour is followed through the cells, and cells only speed it up.
    """
    seen = np.zeros_like(picture)
    best = np.empty((0, 2), np.int32)
    least = np.inf
    for row in range(picture.shape[0]):
        for low in range(8):
            at_y = 8 * row + low
            for c in range(picture.shape[1]):
                bits = (picture[row, c] >> np.uint64(8 * low)) & np.uint64(255)
                if bits == np.uint64(0):
                    continue
                for b in range(8):
                    at_x = 8 * c + b
                    if not (bits >> np.uint64(b)) & np.uint64(1) or is_set(seen, at_x, at_y):
                        continue
                    if is_set(picture, at_x - 1, at_y) or is_set(picture, at_x - 1, at_y - 1):
                        continue
                    if is_set(picture, at_x, at_y - 1) or is_set(picture, at_x + 1, at_y - 1):
                        continue
                    border = trace_border(picture, at_x, at_y, seen)
                    if _area(border) < 0:
                        continue
                    away = np.inf
                    for i in range(len(border)):
                        dx = border[i, 0] + 0.5 - x
                        dy = border[i, 1] + 0.5 - y
                        away = min(away, dx * dx + dy * dy)
                    if away < least:
                        least = away
                        best = border
    return best


@kernel
def find_passing_pixel(
    border: Int32Array, first: Picture, x: float, y: float, out_x: float, out_y: float
) -> int:
    """The pixel of a contour nearest to a place, of those set in ``first`` where the contour's
    outside is that of the unit direction; if there is none, on either side."""
    n = len(border)
    result = -1
    least = np.inf
    for i in range(n):
        if not is_set(first, border[i, 0], border[i, 1]):
            continue
        dx = border[i, 0] + 0.5 - x
        dy = border[i, 1] + 0.5 - y
        away = math.hypot(dx, dy)
        if away >= least:
            continue
        j = (i + SPAN) % n
        k = (i - SPAN) % n
        # Background is on the right.
        right_x = float(border[j, 1] - border[k, 1])
        right_y = float(border[k, 0] - border[j, 0])
        size = math.hypot(right_x, right_y)
        if right_x * out_x + right_y * out_y < AGREE * size or size == 0.0:
            away += _WRONG_SIDE
            if away >= least:
                continue
        least = away
        result = i
    return result
