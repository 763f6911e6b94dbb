"""Where chords may end: corners, and in smooth stretches samples that bound the turning."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.chords.order import SAME, canonical_order, compared, extent
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.sampling import Loop

#: A smooth stretch that turns by more than this gets an end inside, in radians: 45 degrees. The
#: paper bounds the turning without saying by what. The bend of an eighth of a circle rises 1/10
#: of its chord above it, little enough for one nearly flat piece.
TURNING_BOUND = math.radians(45)

#: A maximum of curvature counts where it exceeds the mean around it by this factor: a circle,
#: and the ripple of a polyline that was sampled again, has no maxima. Own choice.
PROMINENCE = 1.25


@kernel
def loop_turning(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) turning angle in radians at every vertex of a closed polyline (n, 3)."""
    n = len(points)
    turning = np.empty(n)
    for i in range(n):
        before = points[i] - points[i - 1]
        after = points[(i + 1) % n] - points[i]
        x = before[1] * after[2] - before[2] * after[1]
        y = before[2] * after[0] - before[0] * after[2]
        z = before[0] * after[1] - before[1] * after[0]
        along = before[0] * after[0] + before[1] * after[1] + before[2] * after[2]
        turning[i] = math.atan2(math.sqrt(x * x + y * y + z * z), along)
    return turning


def endpoints(loop: Loop, turning_bound: float = TURNING_BOUND) -> NDArray[np.int64]:
    """(e,) positions in the loop, ascending, from which chords start.

    All corners; then, wherever the loop turns between two ends by more than ``turning_bound``
    (radians, above 0), a local maximum of curvature if there is one, else samples that part the
    turning evenly. Strictly between neighbouring ends the loop turns by no more than the bound.
    The answer does not depend on where the loop starts and which way it runs.

    Raises InvalidNetworkError for a bound that is not above 0 and finite.
    Source: Abbasinejad et al. 2013, section 3.1. Differs from the paper: it walks along the
    cycle and places samples as it goes, which would depend on start and sense; here the
    turning between two ends is parted evenly.
    """
    if not (math.isfinite(turning_bound) and turning_bound > 0):
        raise InvalidNetworkError(
            f"the turning bound is {turning_bound}; give an angle in radians above 0"
        )
    return np.flatnonzero(_endpoints(loop.points, loop.corners, float(turning_bound)))


@kernel
def _endpoints(
    points: NDArray[np.float64], corners: NDArray[np.bool_], bound: float
) -> NDArray[np.bool_]:
    n = len(points)
    order = canonical_order(points)
    points = points[order]
    turning = loop_turning(points)
    tolerance = SAME * extent(points)
    is_end = corners[order]
    if not is_end.any():
        is_end[_first_largest(points, turning, tolerance)] = True
    stack = np.empty((n + 1, 2), np.int64)
    ends = np.flatnonzero(is_end)
    for i in range(len(ends)):
        stack[i, 0] = ends[i]
        stack[i, 1] = ends[i + 1] if i + 1 < len(ends) else ends[0] + n
    height = len(ends)
    while height:
        height -= 1
        a, b = stack[height, 0], stack[height, 1]
        total = 0.0
        for v in range(a + 1, b):
            total += turning[v % n]
        if total <= bound * (1.0 + SAME):
            continue
        top = _maximum(points, turning, a, b, bound / 2.0, tolerance)
        if top >= 0:
            is_end[top % n] = True
            stack[height, 0], stack[height, 1] = a, top
            stack[height + 1, 0], stack[height + 1, 1] = top, b
            height += 2
        else:
            parts = math.ceil(total / bound - SAME)
            _part(points, turning, a, b, total, parts, tolerance, is_end)
    ends = np.zeros(n, np.bool_)
    for i in range(n):
        ends[order[i]] = is_end[i]
    return ends


@kernel
def _first_largest(
    points: NDArray[np.float64], values: NDArray[np.float64], tolerance: float
) -> int:
    """Where the largest value is; of those equal within SAME, at the point that comes first."""
    best = 0
    for i in range(1, len(values)):
        if values[i] > values[best] + SAME or (
            values[i] >= values[best] - SAME and compared(points[i], points[best], tolerance) < 0
        ):
            best = i
    return best


@kernel
def _smoothed(turning: NDArray[np.float64], v: int, a: int, b: int) -> float:
    """The turning at v and its neighbours with weights 1, 2, 1; ends a and b are left out."""
    n = len(turning)
    total, weight = 2.0 * turning[v % n], 2.0
    if v - 1 > a:
        total += turning[(v - 1) % n]
        weight += 1.0
    if v + 1 < b:
        total += turning[(v + 1) % n]
        weight += 1.0
    return total / weight


@kernel
def _maximum(
    points: NDArray[np.float64],
    turning: NDArray[np.float64],
    a: int,
    b: int,
    reach: float,
    tolerance: float,
) -> int:
    """The vertex between a and b that is the highest maximum of curvature, or -1.

    A maximum is highest, and prominent, among the vertices from which the loop turns by no
    more than ``reach`` on the way to it. The first and last vertex of a stretch are none: there
    curvature may just be falling off from the end.
    """
    n = len(turning)
    smooth = np.empty(b - a)
    for v in range(a + 1, b):
        smooth[v - a] = _smoothed(turning, v, a, b)
    found, height = -1, 0.0
    for v in range(a + 2, b - 1):
        here = smooth[v - a]
        if found >= 0 and (
            here < height - SAME
            or (here <= height + SAME and compared(points[v % n], points[found % n], tolerance) > 0)
        ):
            continue
        total, count, highest = here, 1, True
        for sense in (-1, 1):
            u, turned = v + sense, 0.0
            while a < u < b and highest and turned <= reach:
                total += smooth[u - a]
                count += 1
                highest = smooth[u - a] <= here + SAME
                turned += turning[u % n]
                u += sense
        if highest and here > PROMINENCE * total / count:
            found, height = v, here
    return found


@kernel
def _part(
    points: NDArray[np.float64],
    turning: NDArray[np.float64],
    a: int,
    b: int,
    total: float,
    parts: int,
    tolerance: float,
    is_end: NDArray[np.bool_],
) -> None:
    """Mark the vertices between a and b where 1, 2, .. of ``parts`` of the turning are reached.

    Where one is reached just between two vertices, the one that comes first is marked: of two
    curves side by side, walked in opposite senses, those are opposite each other.
    """
    n = len(turning)
    turned, part = 0.0, 1
    for v in range(a + 1, b):
        turned += turning[v % n]
        while part < parts and turned >= part * total / parts - SAME:
            chosen = v
            between = turned <= part * total / parts + SAME and v + 1 < b
            if between and compared(points[(v + 1) % n], points[v % n], tolerance) < 0:
                chosen = v + 1
            is_end[chosen % n] = True
            part += 1
