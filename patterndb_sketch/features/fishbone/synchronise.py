"""Synchronising ribs: rows are shifted so that a row runs along the surface."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone.fishbone import Fishbone

#: A rib is of another sheet if its nearest sample is so many times as far from the backbone
#: sample before it as its origin is from the origin there.
STRAYED = 4.0


def synchronised(fishbone: Fishbone, start: int | None = None) -> Fishbone:
    """The fishbone with its ribs shifted, so that all backbone samples have one row.

    From rib ``start`` both ways: the sample of the next rib nearest to the backbone sample
    becomes the backbone sample there. Rows that ribs do not reach after the shift are not valid:
    there are as many rows as the shifted ribs cover. By default the start is the rib closest to
    the middle from which the fewest ribs stray.

    Ribs that stray are left out: beyond the end of a surface, planes meet other sheets alone.

    Source: feature curve recovery paper, section 4.3.3 and figure 6. Differs from the paper:
    it does not say what becomes of rows that a shift leaves empty, and of ribs on other sheets.
    """
    m = len(fishbone.points)
    if start is not None and not 0 <= start < m:
        raise InvalidFeatureError(f"the start of ribs is {start}; there are ribs 0..{m - 1}")
    starts = (start,) if start is not None else tuple(m * k // 8 for k in (4, 3, 5, 2, 6, 1, 7))
    rows, kept = fishbone.backbone, np.zeros(m, np.bool_)
    for begin in starts:
        trial = _carried(
            fishbone.points, fishbone.first, fishbone.stop, fishbone.backbone,
            fishbone.origins, begin, STRAYED,
        )  # fmt: skip
        if (trial >= 0).sum() > kept.sum():
            rows, kept = trial, trial >= 0
        if kept.sum() > m // 2:
            break
    first, stop = (fishbone.first - rows)[kept], (fishbone.stop - rows)[kept]
    low, n_rows = int(first.min()), int(stop.max() - first.min())
    m = len(first)
    points = np.zeros((m, n_rows, 3))
    normals = np.zeros((m, n_rows, 3))
    valid = np.zeros((m, n_rows), np.bool_)
    for i, old in enumerate(np.flatnonzero(kept)):
        here = slice(int(first[i]) - low, int(stop[i]) - low)
        there = slice(int(fishbone.first[old]), int(fishbone.stop[old]))
        points[i, here] = fishbone.points[old, there]
        normals[i, here] = fishbone.normals[old, there]
        valid[i, here] = True
    backbone = np.full(m, -low, np.int64)
    return Fishbone(
        points, normals, valid, backbone, fishbone.ribs[kept], fishbone.origins[kept]
    )  # fmt: skip


@kernel
def _carried(
    points: Points,
    first: Int64Array,
    stop: Int64Array,
    backbone: Int64Array,
    origins: Points,
    start: int,
    strayed: float,
) -> Int64Array:
    """(m,) rows of the backbone, each the nearest sample to the one before; -1 if it strays."""
    m = len(points)
    rows = np.full(m, -1)
    rows[start] = backbone[start]
    mean = 0.0
    for i in range(1, m):
        mean += _apart(origins[i], origins[i - 1]) / (m - 1)
    for way in (1, -1):
        last = start
        at = start + way
        while 0 <= at < m:
            here = points[last, rows[last]]
            best = np.inf
            row = -1
            for j in range(first[at], stop[at]):
                away = _apart(points[at, j], here)
                if away < best:
                    best = away
                    row = j
            if best <= strayed * max(_apart(origins[at], origins[last]), mean):
                rows[at] = row
                last = at
            at += way
    return rows


@kernel
def _apart(a: Points, b: Points) -> float:
    return np.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)
