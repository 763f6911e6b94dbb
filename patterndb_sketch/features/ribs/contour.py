"""Outer contours of a picture, pixel by pixel, and where one of them passes the backbone."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.raster import Picture, pixel, set_pixel

#: Steps to the eight neighbours, counter-clockwise from the right.
STEPS = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]], np.int32)

#: Pixels to either side over which a contour's direction is measured.
SPAN = 4

#: Cosine between a contour's outward direction and the wanted one from which they agree.
AGREE = 0.2


@kernel
def traced(picture: Picture, x: int, y: int, seen: Picture) -> Int32Array:
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
            if pixel(picture, at_x + STEPS[way, 0], at_y + STEPS[way, 1]):
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
def outer_contour(picture: Picture, x: float, y: float) -> Int32Array:
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
                    if not (bits >> np.uint64(b)) & np.uint64(1) or pixel(seen, at_x, at_y):
                        continue
                    if pixel(picture, at_x - 1, at_y) or pixel(picture, at_x - 1, at_y - 1):
                        continue
                    if pixel(picture, at_x, at_y - 1) or pixel(picture, at_x + 1, at_y - 1):
                        continue
                    border = traced(picture, at_x, at_y, seen)
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
def passing(
    border: Int32Array, first: Picture, x: float, y: float, out_x: float, out_y: float
) -> int:
    """The pixel of a contour nearest to a place, of those set in ``first`` where the contour's
    outside is that of the unit direction; if there is none, on either side."""
    n = len(border)
    result = -1
    least = np.inf
    for i in range(n):
        if not pixel(first, border[i, 0], border[i, 1]):
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


#: Pixels that a place on the wrong side counts as being farther off: more than any picture has.
_WRONG_SIDE = 1e4
