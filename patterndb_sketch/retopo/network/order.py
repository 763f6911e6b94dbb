"""In which order chains leave a node, and into which wedge another one goes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

#: Curves that leave within this angle of each other, in radians, are compared further out.
TOO_CLOSE = 0.1

#: What a curve is looked at aside by, as a part of its segments, so that it lies on none that is
#: there: far above rounding, far below what one sees.
ASIDE = 1e-6

#: The direction of that: any that no axis, diagonal or regular grid has.
TOWARDS = np.array([0.5377, 0.7243, 0.4318])

#: How often, each time twice as far out.
FURTHER = 5


@kernel
def departure(points: Points, backwards: bool, reach: float) -> NDArray[np.float64]:
    """(3,) from the first (or last) point of a polyline (n, 3) to the place at this arc length
    along it, or to its other end if that is nearer."""
    n = len(points)
    at = n - 1 if backwards else 0
    step = -1 if backwards else 1
    result = np.zeros(3)
    left = reach
    for _ in range(n - 1):
        length = 0.0
        for c in range(3):
            length += (points[at + step, c] - points[at, c]) ** 2
        length = math.sqrt(length)
        share = 1.0
        if length > left:
            share = left / length
        for c in range(3):
            result[c] += share * (points[at + step, c] - points[at, c])
        if length >= left:
            break
        left -= length
        at += step
    return result


@kernel
def turn(normal: NDArray[np.float64], one: NDArray[np.float64], two: NDArray[np.float64]) -> float:
    """Angle from direction one to direction two (3,), counter-clockwise about the unit normal, in
    its tangent plane: 0 to 2 pi."""
    up_one = one[0] * normal[0] + one[1] * normal[1] + one[2] * normal[2]
    up_two = two[0] * normal[0] + two[1] * normal[1] + two[2] * normal[2]
    x = one[1] * two[2] - one[2] * two[1]
    y = one[2] * two[0] - one[0] * two[2]
    z = one[0] * two[1] - one[1] * two[0]
    sine = x * normal[0] + y * normal[1] + z * normal[2]
    cosine = one[0] * two[0] + one[1] * two[1] + one[2] * two[2] - up_one * up_two
    angle = math.atan2(sine, cosine)
    return angle if angle >= 0.0 else angle + 2.0 * math.pi


def wedge_for(
    normal: NDArray[np.float64],
    ends: Sequence[tuple[Points, bool]],
    new: tuple[Points, bool],
    reach: float,
    wedges: Sequence[int],
) -> int:
    """Which of some wedges of a node a new curve goes into.

    A curve that runs along one that is there is as far aside of it as when crossings were looked
    for.

    ends: the polylines that leave the node, in its order, and whether each leaves from its last
    point; new: the same of the new curve. Directions are taken over an arc length ``reach``, and
    further out while the nearest two are too close. wedges: numbers, wedge i is between end i
    and the next.
    """
    best = wedges[0]
    if len(wedges) == 1:
        return best
    bounds = sorted({*wedges, *((w + 1) % len(ends) for w in wedges)})
    for _ in range(FURTHER):
        ahead = departure(*new, reach)
        ahead += ASIDE * np.linalg.norm(ahead) * TOWARDS
        turns = {i: turn(normal, departure(*ends[i], reach), ahead) for i in bounds}
        # The narrowest that holds the new curve: of two ends that lie on each other the angles
        # may be in another order than the ends are, and what is between them seems to be wide.
        widths = {w: (turns[w] - turns[(w + 1) % len(ends)]) % (2.0 * math.pi) for w in wedges}
        best = min(wedges, key=lambda w: (turns[w] >= widths[w], widths[w], turns[w]))
        if min(min(t, 2.0 * math.pi - t) for t in turns.values()) >= TOO_CLOSE:
            break
        reach *= 2.0
    return best
