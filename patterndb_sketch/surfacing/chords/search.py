"""The exhaustive search for the chords that cut a cycle into the flattest pieces."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from patterndb._native.surfacing.chords.search import solve
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.chords.flatness import Flatness, standardise
from patterndb_sketch.surfacing.chords.subcycles import MOST_COUNTED


@dataclass(frozen=True, slots=True)
class ChordCuts:
    """The best cuts of a cycle.

    chosen:  (k,) int64, which of the chords were chosen, ascending.
    pieces:  k + 1 closed loops of positions int64, in the loop's own sense. A step between
             positions that are no neighbours in the loop is a chosen chord.
    cost:    Sub(whole cycle).
    n_subproblems: how many sub-problems were solved, each once.
    seconds: how long that took.
    """

    chosen: Int64Array = field(repr=False)
    pieces: tuple[Int64Array, ...] = field(repr=False)
    cost: float
    n_subproblems: int
    seconds: float


def search_cuts(
    points: Points, chords: Int64Array, alpha: float = 0.1, form: Flatness = "relative"
) -> ChordCuts:
    """Choose chords so that the cost of the pieces and of the cuts is least.

        Sub(K) = min(S(K), min over chords c in K: Sub(left) + Sub(right) + alpha len(c) / len(K))

    where S is :func:`.flatness.measure_flatness` and K runs over all sub-cycles that cuts by the
    chords lead to. Of equal costs (TIE) the one with fewer chords wins, then the one cut by the
    chord that comes first. A planar cycle is never cut.

    points: (n, 3) a closed loop. chords: (m, 2) positions i < j, not neighbours, no two alike.
    All sub-problems are solved, whatever alpha; each takes 16 bytes and less than 1 us.
    :func:`n_subproblems` tells how many they are.

    Raises InvalidNetworkError for an alpha below 0 or not finite, chords that are not as above,
    and sub-problems too many to number.
    Source: Abbasinejad et al. 2013, section 3.2, Equations 1 to 3 and Algorithm 1.
    Differs from the paper: sub-problems are numbered and solved from the smallest up, see
    :mod:`patterndb_sketch.surfacing.chords.subcycles`, where the paper recurses with a hash table.
    """
    points = np.ascontiguousarray(points, np.float64)
    chords = _check_chords(len(points), chords)
    if not (math.isfinite(alpha) and alpha >= 0):
        raise InvalidNetworkError(f"alpha is {alpha}; give a number >= 0")
    started = perf_counter()
    own, determinant = standardise(points)
    whole = np.arange(len(points))
    if determinant == 0.0 or not len(chords):
        # A planar cycle is a problem of its own, solved at a glance.
        scale = determinant if form == "printed" else float(determinant > 0.0)
        return ChordCuts(np.zeros(0, np.int64), (whole,), scale, 1, perf_counter() - started)
    scale = determinant if form == "printed" else 1.0
    count, cost, chosen, bounds, positions = solve(
        points, own, chords, alpha / scale, form == "printed"
    )
    if count >= MOST_COUNTED:
        raise InvalidNetworkError(
            f"{len(chords)} chords make {MOST_COUNTED} sub-problems or more; give fewer chords"
        )
    seconds = perf_counter() - started
    pieces = tuple(np.split(positions, bounds))
    return ChordCuts(np.sort(chosen), pieces, cost * scale, count, seconds)


def _check_chords(n: int, chords: Int64Array) -> Int64Array:
    pairs = np.ascontiguousarray(chords, np.int64).reshape(-1, 2)
    first, last = pairs[:, 0], pairs[:, 1]
    wrong = (first < 0) | (last >= n) | (last - first < 2) | (last - first > n - 2)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise InvalidNetworkError(
            f"chord {i} joins the positions {first[i]} and {last[i]}; give i < j in a loop of {n} "
            "vertices that are not neighbours"
        )
    if len(np.unique(first * n + last)) < len(pairs):
        raise InvalidNetworkError("two chords join the same positions; give each once")
    return pairs
