"""What no new patch may do: cross boundaries or itself, or be inside out."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.plane.boundary import Boundary
from patterndb_sketch.retopo.tools.plane.patch import PlanarPatch
from patterndb_sketch.retopo.tools.plane.side import OldSide

#: The part of a new curve at either end that is not looked at, since it touches what it joins.
TRIM = 1e-6

#: A loop is a patch if its area is more than this part of a circle's of its length.
ROUNDNESS = 0.1

#: Corners nearer than this part of the patch's extent are one.
APART = 1e-9


def fault(patch: PlanarPatch, boundaries: Sequence[Boundary]) -> str | None:
    """Why the patch cannot be, in words that end "the patch would ...", or None if it can."""
    if not _corners_apart(patch):
        return "have two corners in one place"
    curves = [_trimmed(curve) for curve in patch.curves]
    old = [np.concatenate(ends) for ends in zip(*(b.edges for b in boundaries), strict=True)]
    for curve in curves:
        if old and crossings(curve[:-1], curve[1:], old[0], old[1]).any():
            return "cross a curve that is there"
        if _crosses_itself(curve):
            return "cross itself"
    for a, b in combinations(curves, 2):
        if crossings(a[:-1], a[1:], b[:-1], b[1:]).any():
            return "cross itself"
    if not _is_patch(patch.outline(boundaries)):
        return "be inside out, or have next to no area"
    return None


def crossings(a: Points, b: Points, c: Points, d: Points) -> NDArray[np.bool_]:
    """(m, n) does segment a b (m, 2) pass through segment c d (n, 2)?

    What lies on a line counts as left of it, so a line through a common end of two segments
    that go on across it passes through one of them, and a line along them through none.
    """
    a, b = a[:, None], b[:, None]
    c, d = c[None], d[None]
    return (_left(a, b, c) != _left(a, b, d)) & (_left(c, d, a) != _left(c, d, b))


def _left(a: Points, b: Points, c: Points) -> NDArray[np.bool_]:
    """Is c left of a b, or on it?"""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] >= 0.0


def _trimmed(points: Points) -> Points:
    points = points.copy()
    points[0] += TRIM * (points[1] - points[0])
    points[-1] += TRIM * (points[-2] - points[-1])
    return points


def _crosses_itself(curve: Points) -> bool:
    tail, head = curve[:-1], curve[1:]
    found = crossings(tail, head, tail, head)
    # Neighbours touch, and rounding may call that crossing.
    return bool(np.triu(found, 2).any())


def _corners_apart(patch: PlanarPatch) -> bool:
    points = patch.points
    extent = float(np.ptp(points, axis=0).max())
    gaps = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1)
    # A stretch of a boundary may begin and end in one place, if it goes around.
    old = [any(isinstance(part, OldSide) for part in side) for side in patch.sides]
    return bool(((gaps > APART * extent) | np.array(old)).all()) and extent > 0.0


def _is_patch(loop: Points) -> bool:
    """Eq. 1 of the paper, or most of the loop's fan the right way about.

    Differs from the paper: its test alone refuses ribbons, whose area is small for their length.
    """
    centre = loop.mean(axis=0)
    a, b = loop - centre, np.roll(loop, -1, axis=0) - centre
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area, fan = doubled.sum() / 2.0, np.abs(doubled).sum() / 2.0
    length = np.linalg.norm(b - a, axis=1).sum()
    return bool(area > ROUNDNESS * length * length / (4.0 * np.pi) or area > fan / 2.0)
