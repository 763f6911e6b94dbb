"""Which triangle of a map contains a (u, v): triangles filed by the cells of a grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.surface import Points
from patterndb.system.kernels import kernel

#: Barycentric weights this far below 0 still count: a point on an edge has one of its two
#: triangles.
SLACK = 1e-9


@kernel(inline="always")
def _cell(x: float, low: float, size: float, n: Index) -> int:
    return min(max(int((x - low) / size), 0), n - 1)


@kernel
def filed(uv: Points, corners: Int32Array) -> tuple[Points, Int32Array, Int32Array]:
    """A grid over the triangles (k, 3) of points uv (m, 2): its frame (3, 2), which is low
    corner, cell size and numbers of cells; and the triangles by cell: start, numbers."""
    k = len(corners)
    frame = np.zeros((3, 2))
    frame[1:] = 1.0
    if k:
        side = max(1, int(math.sqrt(k)))
        for c in range(2):
            low, high = np.inf, -np.inf
            for f in range(k):
                for e in range(3):
                    low = min(low, uv[corners[f, e], c])
                    high = max(high, uv[corners[f, e], c])
            frame[0, c] = low
            frame[1, c] = (high - low) / side if high > low else 1.0
            frame[2, c] = side if high > low else 1
    columns, rows = int(frame[2, 0]), int(frame[2, 1])
    box = np.empty((k, 4), np.int32)
    start = np.zeros(columns * rows + 1, np.int32)
    for f in range(k):
        for c in range(2):
            one, two, three = uv[corners[f, 0], c], uv[corners[f, 1], c], uv[corners[f, 2], c]
            n = int(frame[2, c])
            box[f, c] = _cell(min(one, two, three), frame[0, c], frame[1, c], n)
            box[f, 2 + c] = _cell(max(one, two, three), frame[0, c], frame[1, c], n)
        for i in range(box[f, 0], box[f, 2] + 1):
            for j in range(box[f, 1], box[f, 3] + 1):
                start[i * rows + j + 1] += 1
    for i in range(columns * rows):
        start[i + 1] += start[i]
    at = start[:-1].copy()
    numbers = np.empty(start[-1], np.int32)
    for f in range(k):
        for i in range(box[f, 0], box[f, 2] + 1):
            for j in range(box[f, 1], box[f, 3] + 1):
                numbers[at[i * rows + j]] = f
                at[i * rows + j] += 1
    return frame, start, numbers


@kernel
def containing(
    uv: Points,
    corners: Int32Array,
    distance: NDArray[np.float64],
    frame: Points,
    start: Int32Array,
    numbers: Int32Array,
    wanted: Points,
) -> tuple[Int32Array, Points]:
    """(n,) the triangle that contains each (u, v) wanted (n, 2), -1 without; (n, 3) weights.

    Of several the one of the least distance (m,), interpolated there.
    """
    triangle = np.full(len(wanted), -1, np.int32)
    weights = np.zeros((len(wanted), 3))
    columns, rows = int(frame[2, 0]), int(frame[2, 1])
    for i in range(len(wanted)):
        x, y = wanted[i, 0], wanted[i, 1]
        if not (math.isfinite(x) and math.isfinite(y)):
            continue
        # A little outside is looked at too, as slack takes edges in.
        reach = (x - frame[0, 0]) / frame[1, 0], (y - frame[0, 1]) / frame[1, 1]
        if not (-1.0 < reach[0] < columns + 1 and -1.0 < reach[1] < rows + 1):
            continue
        cell = _cell(x, frame[0, 0], frame[1, 0], columns) * rows
        cell += _cell(y, frame[0, 1], frame[1, 1], rows)
        best = np.inf
        for k in range(start[cell], start[cell + 1]):
            f = numbers[k]
            a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
            ux, uy = uv[b, 0] - uv[a, 0], uv[b, 1] - uv[a, 1]
            vx, vy = uv[c, 0] - uv[a, 0], uv[c, 1] - uv[a, 1]
            area = ux * vy - uy * vx
            if area == 0.0:
                continue
            px, py = x - uv[a, 0], y - uv[a, 1]
            one = (px * vy - py * vx) / area
            two = (ux * py - uy * px) / area
            if one < -SLACK or two < -SLACK or one + two > 1.0 + SLACK:
                continue
            one = min(max(one, 0.0), 1.0)
            two = min(max(two, 0.0), 1.0 - one)
            far = (1.0 - one - two) * distance[a] + one * distance[b] + two * distance[c]
            if far < best:
                best = far
                triangle[i] = f
                weights[i, 0], weights[i, 1], weights[i, 2] = 1.0 - one - two, one, two
    return triangle, weights
