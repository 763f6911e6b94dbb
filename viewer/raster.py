"""Which triangle is seen at every pixel: a depth buffer without OpenGL."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

Grid = NDArray[np.float32]


@kernel
def paint(corners: Points, colours: Grid, depth: Grid, image: Grid) -> None:
    """Paint triangles over what is there, in place; the nearer wins.

    corners: (t, 3, 3) float64 x to the right, y down, both in pixels, and depth, greater is
    nearer. colours: (t, 3, 3) float32 of the corners, blended between. depth: (h, w) float32,
    -inf where nothing is yet. image: (h, w, 3) float32. The pixel (i, j) is seen at its middle,
    x = j + 0.5, y = i + 0.5.
    """
    height, width = depth.shape
    for t in range(len(corners)):
        ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
        bx, by, bz = corners[t, 1, 0], corners[t, 1, 1], corners[t, 1, 2]
        cx, cy, cz = corners[t, 2, 0], corners[t, 2, 1], corners[t, 2, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        left = max(0, math.floor(min(ax, bx, cx) - 0.5))
        right = min(width - 1, math.ceil(max(ax, bx, cx) - 0.5))
        top = max(0, math.floor(min(ay, by, cy) - 0.5))
        bottom = min(height - 1, math.ceil(max(ay, by, cy) - 0.5))
        for i in range(top, bottom + 1):
            y = i + 0.5
            for j in range(left, right + 1):
                x = j + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                w = 1.0 - u - v
                # A pixel on an edge belongs to both triangles, so that no gap is left.
                if u < -1e-9 or v < -1e-9 or w < -1e-9:
                    continue
                z = u * az + v * bz + w * cz
                if z <= depth[i, j]:
                    continue
                depth[i, j] = z
                for c in range(3):
                    image[i, j, c] = (
                        u * colours[t, 0, c] + v * colours[t, 1, c] + w * colours[t, 2, c]
                    )


def farthest_nearby(depth: Grid) -> Grid:
    """(h, w) the least depth in the 3 x 3 pixels around: what a line beside a ridge is held to."""
    padded = np.pad(depth, 1, mode="edge")
    rows = np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
    return np.minimum(np.minimum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
