"""Border edges that lie on each other: seams that nobody merged, and slits without width."""

# scipy has no types: what it returns is typed by the function's own annotation.
# pyright: reportMissingTypeStubs=false

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

#: Ends of edges no further apart than this part of the edge lie at one place: a gap that can be
#: seen is wider, one that was not merged is rounding, or what a modeller mirrored a little off.
AT_ONE_PLACE = 0.05

#: How many edges nearest to one are looked at, itself among them: of a soup all that meet there.
LOOKED_AT = 6


def find_coincident_edges(
    points: Points, tail: Int32Array, head: Int32Array
) -> tuple[NDArray[np.int64], Floats]:
    """Find for every edge, from point tail (b,) to head (b,), another one that lies on it.

    Returns ((b,) the other edge or -1, (b,) how far apart their ends are at most).
    """
    n = len(tail)
    partner, apart = np.full(n, -1, np.int64), np.zeros(n)
    if n < 2:
        return partner, apart
    a, b = points[tail], points[head]
    middle, length = (a + b) / 2.0, np.linalg.norm(b - a, axis=1)
    reach = AT_ONE_PLACE * float(length.max())
    # Imported here because fills of boundaries load this module, and need no tree.
    from scipy.spatial import KDTree

    found = KDTree(middle).query(middle, min(LOOKED_AT, n), distance_upper_bound=reach + 1e-300)
    near: NDArray[np.int64] = np.asarray(found[1], np.int64)
    for column in near.T:
        there = np.flatnonzero((column < n) & (partner < 0))
        other = column[there]
        mine = other != there
        there, other = there[mine], other[mine]
        along = np.maximum(_measure(a, a, there, other), _measure(b, b, there, other))
        against = np.maximum(_measure(a, b, there, other), _measure(b, a, there, other))
        gap = np.minimum(along, against)
        close = gap <= AT_ONE_PLACE * np.minimum(length[there], length[other])
        close &= length[there] > 0.0
        partner[there[close]], apart[there[close]] = other[close], gap[close]
    return partner, apart


def _measure(one: Points, two: Points, i: NDArray[np.int64], j: NDArray[np.int64]) -> Floats:
    return np.linalg.norm(one[i] - two[j], axis=1)
