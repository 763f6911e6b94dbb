"""The picture of a slice, one bit to the pixel: dilation, and erosion that keeps its topology.

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

#: Pixels left free at every side, so that dilation never meets the border.
MARGIN = 12

_ONE = np.uint64(1)
_EIGHT = np.uint64(8)
_ROW = np.uint64(56)
_NONE = np.uint64(0)
_NOT_FIRST = np.uint64(0xFEFEFEFEFEFEFEFE)
_NOT_LAST = np.uint64(0x7F7F7F7F7F7F7F7F)
_SEVEN = np.uint64(7)


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
#: hole. Sides, not corners, join background; corners join foreground.
MAY_GO = _ring_rules()


@kernel
def pixel(picture: Picture, x: Index, y: Index) -> bool:
    """Is the pixel set? Those outside the picture are not."""
    if x < 0 or y < 0 or (x >> 3) >= picture.shape[1] or (y >> 3) >= picture.shape[0]:
        return False
    return (picture[y >> 3, x >> 3] >> np.uint64(8 * (y & 7) + (x & 7))) & _ONE != np.uint64(0)


@kernel
def set_pixel(picture: Picture, x: Index, y: Index) -> None:
    picture[y >> 3, x >> 3] |= _ONE << np.uint64(8 * (y & 7) + (x & 7))


@kernel
def ring(picture: Picture, x: Index, y: Index) -> int:
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
    if pixel(picture, x + 1, y):
        bits |= 1
    if pixel(picture, x + 1, y + 1):
        bits |= 2
    if pixel(picture, x, y + 1):
        bits |= 4
    if pixel(picture, x - 1, y + 1):
        bits |= 8
    if pixel(picture, x - 1, y):
        bits |= 16
    if pixel(picture, x - 1, y - 1):
        bits |= 32
    if pixel(picture, x, y - 1):
        bits |= 64
    if pixel(picture, x + 1, y - 1):
        bits |= 128
    return bits


@kernel
def dilated(picture: Picture) -> Picture:
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
                    if MAY_GO[ring(picture, 8 * c + (b & 7), 8 * r + (b >> 3))]:
                        picture[r, c] &= ~bit
                        layer[r, c] &= ~bit


@kernel
def rendered(
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
def closed_gaps(picture: Picture, rounds: int) -> Picture:
    """The picture after so many dilations, then as many erosions."""
    result = picture.copy()
    for _ in range(rounds):
        result = dilated(result)
    for _ in range(rounds):
        erode(result, picture)
    return result
