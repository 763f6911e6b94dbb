"""Synchronising ribs: rows are shifted so that a row runs along the surface."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from query.polyline import Points
from sketch.features.fishbone.fishbone import Fishbone

Rows = NDArray[np.int64]


def synchronised(fishbone: Fishbone, start: int | None = None) -> Fishbone:
    """The fishbone with its ribs shifted, so that all backbone samples have one row.

    From rib ``start``, the middle one by default, both ways: the sample of the next rib nearest
    to the backbone sample becomes the backbone sample there. Rows that ribs do not reach after
    the shift are not valid: there are as many rows as the shifted ribs cover.

    Source: feature curve recovery paper, section 4.3.3 and figure 6. Differs from it: rows that
    a shift leaves empty are kept, without samples, where the paper does not say.
    """
    m = len(fishbone.points)
    middle = m // 2 if start is None else start
    rows = _carried(fishbone.points, fishbone.first, fishbone.stop, fishbone.backbone, middle)
    first, stop = fishbone.first - rows, fishbone.stop - rows
    low, n_rows = int(first.min()), int(stop.max() - first.min())
    points = np.zeros((m, n_rows, 3))
    normals = np.zeros((m, n_rows, 3))
    valid = np.zeros((m, n_rows), np.bool_)
    for i in range(m):
        here = slice(int(first[i]) - low, int(stop[i]) - low)
        there = slice(int(fishbone.first[i]), int(fishbone.stop[i]))
        points[i, here] = fishbone.points[i, there]
        normals[i, here] = fishbone.normals[i, there]
        valid[i, here] = True
    return Fishbone(points, normals, valid, np.full(m, -low, np.int64), fishbone.ribs)


@njit(cache=True, nogil=True)
def _carried(points: Points, first: Rows, stop: Rows, backbone: Rows, start: int) -> Rows:
    """(m,) rows of the backbone, each the nearest sample to the one before, from ``start``."""
    m = len(points)
    rows = backbone.copy()
    for way in (1, -1):
        at = start
        while 0 <= at + way < m:
            here = points[at, rows[at]]
            at += way
            best = np.inf
            for j in range(first[at], stop[at]):
                away = 0.0
                for c in range(3):
                    away += (points[at, j, c] - here[c]) ** 2
                if away < best:
                    best = away
                    rows[at] = j
    return rows
