"""Boundaries drawn in the plane, for the tools of retopology."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from patterndb_sketch.retopo.tools.planar import PlanarBoundary

#: Distance of vertices.
STEP = 0.05

Path = list[tuple[float, float, bool]]


def path(text: str) -> Path:
    """Points "x,y", with an o behind those that are corners."""
    found = []
    for word in text.split():
        x, y = word.rstrip("o").split(",")
        found.append((float(x), float(y), word.endswith("o")))
    return found


def boundary(text: str, closed: bool = False) -> PlanarBoundary:
    """A boundary along a path, with vertices every STEP."""
    given_ = path(text)
    if closed:
        given_.append(given_[0])
    points, corner = [], []
    for (x0, y0, o), (x1, y1, _) in pairwise(given_):
        n = max(1, round(float(np.hypot(x1 - x0, y1 - y0)) / STEP))
        t = np.arange(n)[:, None] / n
        points.append([x0, y0] + t * [x1 - x0, y1 - y0])
        corner.append(np.r_[o, np.zeros(n - 1, bool)])
    if not closed:
        points.append(np.array([given_[-1][:2]]))
        corner.append(np.array([given_[-1][2]]))
    return PlanarBoundary(np.concatenate(points), np.concatenate(corner), closed)


def same_corners(found: np.ndarray, expected: list[tuple[float, float]], near: float) -> bool:
    """Are these the corners, in this order, from whichever on?"""
    wanted = np.array(expected)
    if len(found) != len(wanted):
        return False
    gaps = [np.abs(np.roll(found, k, axis=0) - wanted).max() for k in range(len(found))]
    return min(gaps) <= near
