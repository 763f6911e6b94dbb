"""The ends of a spine's patch: orthogonal snapping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb_sketch.retopo.tools.plane import Boundary, Corner


def snapped_end(
    boundaries: Sequence[Boundary], half_width: float, snap: float
) -> tuple[Corner, Corner] | None:
    """The stretch of a boundary that is the end of a patch at the origin, or None.

    The patch goes on in v and is up to half_width wide to either side. The nearest vertex that
    is no corner counts, if it is within the snap radius. From it the end reaches to the next
    corners, or as far as the patch is wide. Returned in the boundary's direction: left, right.
    """
    best, at = snap, None
    for number, boundary in enumerate(boundaries):
        gaps = np.linalg.norm(boundary.points, axis=1)
        gaps[boundary.corner | np.isnan(gaps)] = np.inf
        k = int(np.argmin(gaps))
        if gaps[k] < best or (at is None and gaps[k] <= best):
            best, at = float(gaps[k]), (number, k)
    if at is None:
        return None
    number, start = at
    left = _walk(number, boundaries[number], start, -1, half_width)
    right = _walk(number, boundaries[number], start, 1, half_width)
    # A boundary that runs the other way has its patch where this one would be.
    return (left, right) if left.point[0] < right.point[0] else None


def _walk(number: int, boundary: Boundary, start: int, step: int, half_width: float) -> Corner:
    """Where a walk along the boundary stops: at a corner, or where the patch is no wider."""
    n, at = len(boundary.points), start
    for _ in range(n):
        following = at + step
        if not boundary.closed and not 0 <= following < n:
            break
        here, there = boundary.points[at % n], boundary.points[following % n]
        if np.isnan(there).any():
            break
        if abs(there[0]) > half_width:
            edge = np.copysign(half_width, there[0])
            place = at + step * float((edge - here[0]) / (there[0] - here[0]))
            return Corner(boundary.at(place), number, place)
        at = following
        if boundary.corner[at % n]:
            break
    return Corner(boundary.at(at), number, float(at))
