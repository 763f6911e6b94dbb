"""A traversal of a loop that does not depend on where it starts or which way it runs.

Choices between equals (two vertices at the same distance, two maxima alike) fall to the vertex
that comes first. For a loop's chords to stay the same when its curves are given in another order
or reversed, "first" must not mean the order of the input.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.system.kernels import kernel

#: Two lengths, angles or coordinates count as equal below this share of their scale. A curve
#: sampled from its other end gives points that differ in the 16th digit; 1e-9 is far above
#: that, and far below what can be seen.
SAME = 1e-9


@kernel
def extent(points: NDArray[np.float64]) -> float:
    """The longest side of the box around points (n, 3)."""
    longest = 0.0
    for d in range(3):
        least, most = np.inf, -np.inf
        for i in range(len(points)):
            least = min(least, points[i, d])
            most = max(most, points[i, d])
        longest = max(longest, most - least)
    return longest


@kernel
def compared(a: NDArray[np.float64], b: NDArray[np.float64], tolerance: float) -> int:
    """-1 if point a comes before b, 1 if after, 0 if they are the same: by x, then y, then z."""
    for d in range(3):
        if abs(a[d] - b[d]) > tolerance:
            return -1 if a[d] < b[d] else 1
    return 0


@kernel
def canonical_order(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n,) positions of a loop's points (n, 3) in the canonical traversal.

    It begins at the vertex with the least x, then y, then z, and goes on to the side where, at
    the first step that differs, x, then y, then z is less. Coordinates within SAME of the
    loop's extent are equal.
    """
    n = len(points)
    tolerance = SAME * extent(points)
    among = np.ones(n, np.bool_)
    for d in range(3):
        least = np.inf
        for i in range(n):
            if among[i] and points[i, d] < least:
                least = points[i, d]
        for i in range(n):
            if among[i] and points[i, d] > least + tolerance:
                among[i] = False
    start = 0
    while not among[start]:
        start += 1
    step = 1
    decided = False
    for s in range(1, n):
        if decided:
            break
        side = compared(points[(start + s) % n], points[(start - s) % n], tolerance)
        if side != 0:
            step = -side
            decided = True
    order = np.empty(n, np.int64)
    for s in range(n):
        order[s] = (start + s * step) % n
    return order
