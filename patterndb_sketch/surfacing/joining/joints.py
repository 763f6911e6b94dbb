"""Which places a meeting of two curves joins: one for a crossing, two for a common stretch.

Kernels on pairs of places: their arc lengths on the curves A and B, and how far apart they are.
"""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel

#: A meeting longer than this many tolerances may be a common stretch: edges that cross at 30
#: degrees are within the tolerance of each other for 4 of them.
LONG = 4.0

#: A long meeting is a common stretch if the median distance within it exceeds the least by less
#: than this share of the tolerance. Crossing lines have 0.5, touching arcs 0.25.
FLAT = 0.1

#: ... or if the distance goes up and down by this share of the tolerance more than once.
WAVERING = 0.25

#: The end of a common stretch is looked for so many tolerances inwards of its last pair of places.
INWARDS = 4.0

#: A crossing within edges must be closer than their ends by this share of the tolerance:
#: otherwise the curves are cut at a point that they have.
BETTER = 1e-3

#: Most pairs of places that one meeting joins: the four pairs of ends, and both extremes.
MOST_JOINS = 6


@kernel
def chosen_places(
    a: Floats,
    b: Floats,
    gap: Floats,
    vertex: Int64Array,
    n_points: int,
    last_a: float,
    last_b: float,
    tolerance: float,
) -> Int64Array:
    """Which pairs of places of a meeting are joined."""
    # The closest pair of each two ends; the pairs of ends are 0 to 3.
    ends = np.full(4, -1)
    for place in range(len(a)):
        if (a[place] == 0 or a[place] == last_a) and (b[place] == 0 or b[place] == last_b):
            pair = 2 * int(a[place] != 0) + int(b[place] != 0)
            if ends[pair] < 0 or gap[place] < gap[ends[pair]]:
                ends[pair] = place
    ends = ends[ends >= 0]
    long = max(a.max() - a.min(), b.max() - b.min()) > LONG * tolerance
    if len(ends) < 2 and not (long and _runs_alongside(gap, vertex, n_points, tolerance)):
        if len(ends):
            return ends
        best = 0
        for place in range(len(a)):
            if (gap[place], a[place], b[place]) < (gap[best], a[best], b[best]):
                best = place
        return np.array([best])
    # A common stretch: B runs along A in the same sense, or against it.
    covariance = ((a - a.mean()) * (b - b.mean())).sum()
    run = a + b if covariance >= 0 else a - b
    first = _extreme(run, gap, a, b, last_a, last_b, tolerance)
    second = _extreme(-run, gap, a, b, last_a, last_b, tolerance)
    return np.concatenate((ends, np.array([first, second])))


@kernel
def _extreme(
    run: Floats,
    gap: Floats,
    a: Floats,
    b: Floats,
    last_a: float,
    last_b: float,
    tolerance: float,
) -> int:
    """Where a common stretch begins: at an end of A or B if one is there, else nearby."""
    least = run.min()
    best = -1
    best_key = (2, 0.0, 0.0)
    for place in range(len(run)):
        if run[place] > least + INWARDS * tolerance:
            continue
        at_end = a[place] == 0 or a[place] == last_a or b[place] == 0 or b[place] == last_b
        # Distances that differ by rounding count as one: then the outermost is taken.
        step = math.floor(gap[place] / (BETTER * tolerance)) if tolerance > 0 else 0.0
        key = (0 if at_end else 1, step, run[place])
        if best < 0 or key < best_key:
            best, best_key = place, key
    return best


@kernel
def _runs_alongside(gap: Floats, vertex: Int64Array, n_points: int, tolerance: float) -> bool:
    """Does the distance stay flat or waver, rather than fall to one place and rise again?"""
    profile = _profile(gap[vertex >= n_points], vertex[vertex >= n_points])
    on_a = (vertex >= 0) & (vertex < n_points)
    of_a = _profile(gap[on_a], vertex[on_a])
    if len(of_a) >= len(profile):
        profile = of_a
    if len(profile) == 0:
        return False
    least = gap.min()
    there_and_back = profile[0] + profile[-1] - 2 * profile.min()
    wavering = np.abs(np.diff(profile)).sum() - there_and_back
    return np.median(profile) - least < FLAT * tolerance or wavering > WAVERING * tolerance


@kernel
def _profile(gap: Floats, vertex: Int64Array) -> Floats:
    """The least distance at every vertex, in the order along the curve."""
    order = np.argsort(vertex)
    profile = np.empty(len(order), np.float64)
    n = 0
    for i in range(len(order)):
        if i > 0 and vertex[order[i]] == vertex[order[i - 1]]:
            profile[n - 1] = min(profile[n - 1], gap[order[i]])
        else:
            profile[n] = gap[order[i]]
            n += 1
    return profile[:n]
