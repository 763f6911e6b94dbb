"""The chord decomposition of one cycle: ends -> candidate chords -> search -> pieces.

After Abbasinejad et al. 2013, section 3. Differs from the paper (section 3.2): its hash key of a
sub-cycle, the chords on the boundary, cannot tell the two sides of a chord apart. Here sub-cycles
are counted and numbered without a search, see rust/surfacing/src/chords/subcycles.rs; the number
replaces the hash table, and there is no limit to the number of ends.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb._native.geometry.leastarea import tabulate_areas_around
from patterndb._native.surfacing.chords.candidates import candidates, endpoints, order_canonically
from patterndb._native.surfacing.chords.decompose import flatter as _measure_flattening
from patterndb._native.surfacing.chords.flatness import standardised
from patterndb._native.surfacing.chords.search import solve
from patterndb._native.surfacing.chords.subcycles import counted
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.defaults import (
    ALPHA,
    AREA_PRICE,
    MAX_SUBPROBLEMS,
    TURNING_BOUND,
    Flatness,
)
from patterndb_sketch.surfacing.sampling import Loop

#: Two lengths, angles or coordinates count as equal below this share of their scale. A curve
#: sampled from its other end gives points that differ in the 16th digit; 1e-9 is far above
#: that, and far below what can be seen.
#: The same as in rust/surfacing/src/chords/candidates.rs.
SAME = 1e-9


#: A chord hugs the loop where the shorter way along the loop is no longer than this many times
#: the chord: it would cut off a sliver. Spec: 1.15; an arc of a circle reaches it at 104 degrees.
#: The same as in rust/surfacing/src/chords/candidates.rs.
HUGGING = 1.15

#: Points are near each other within two edges of the loop, or this share of the chord's length.
#: The same as in rust/surfacing/src/chords/candidates.rs.
NEAR_EDGES = 2.0
NEAR_SHARE = 0.25

#: Counts stop here: exact below, "this many or more" at it. Twice this is still an int64.
#: The same as in rust/surfacing/src/chords/subcycles.rs.
MOST_COUNTED = 2**61

#: The largest share of the candidates that may be dropped to keep to the budget: what is left
#: says little about a cycle after that, and another method serves it better.
MOST_DROPPED = 0.5

#: Less added area than this share of the loop's is none: the least area of a curved strip varies
#: by as much with where its vertices happen to lie.
NO_AREA = 0.005

#: Areas are measured on about so many vertices of a loop, and all ends of chords: time grows with
#: the cube of their number.
MEASURED = 64


@dataclass(frozen=True, slots=True)
class Decomposition:
    """A cycle cut by chords.

    candidates:    (c, 2) int64 positions i < j in the loop, chords worth their area.
    chords:        (m, 2) int64, those of them that cut.
    pieces:        m + 1 closed loops of positions int64, in the loop's own sense. A step between
                   positions that are no neighbours in the loop is a chord.
    cost:          what the search made least; S(loop) if it was given up.
    n_subproblems: how many sub-problems were solved.
    n_dropped:     how many candidates, the longest, were not searched, to keep to the budget.
    n_unmatched:   how many ends have no candidate, before any was dropped.
    n_costly:      how many candidates were left out because they add too much area.
    exhausted:     was the search given up, because half of the candidates already exceed the
                   budget? Then all are dropped, and the loop is in one piece, flat or not.
    """

    candidates: NDArray[np.int64] = field(repr=False)
    chords: NDArray[np.int64] = field(repr=False)
    pieces: tuple[NDArray[np.int64], ...] = field(repr=False)
    cost: float
    n_subproblems: int
    n_dropped: int
    n_unmatched: int
    n_costly: int
    exhausted: bool


def decompose(
    loop: Loop,
    alpha: float = ALPHA,
    *,
    area_price: float = AREA_PRICE,
    flatness: Flatness = "relative",
    turning_bound: float = TURNING_BOUND,
    max_subproblems: int = MAX_SUBPROBLEMS,
) -> Decomposition:
    """Cut a loop into nearly flat pieces by few, short chords.

    alpha: the larger, the fewer pieces. area_price: what chords may cost in area, see
    :func:`find_affordable`; math.inf, as in the paper: anything. flatness: see Flatness.
    turning_bound: radians, see :func:`find_endpoints`. max_subproblems: the budget; where the
    candidates make more, the longest are left out, and where that would be more than half of
    them, the search is given up and says so. The number of sub-problems does not depend on alpha.

    The cost does not depend on where the loop starts and which way it runs.
    Raises InvalidNetworkError for an alpha below 0, a bound not above 0, a budget below 1.
    Source: Abbasinejad et al. 2013, section 3. Differs from the paper: it has no budget, and
    worst cases take exponential time; and it searches chords whatever area they add.
    """
    if max_subproblems < 1:
        raise InvalidNetworkError(f"the budget is {max_subproblems} sub-problems; give at least 1")
    found = find_candidates(loop, find_endpoints(loop, turning_bound))
    worth = found.chords
    # A planar loop is never cut: nothing takes time, whatever the candidates.
    planar = is_planar(loop.points)
    if math.isfinite(area_price) and not planar:
        worth = worth[find_affordable(loop.points, worth, area_price)]
    kept = worth if planar else keep_within_budget(loop.points, worth, max_subproblems)
    exhausted = len(worth) - len(kept) > MOST_DROPPED * len(worth)
    if exhausted:
        kept = kept[:0]
    cuts = search_cuts(loop.points, kept, alpha, flatness)
    return Decomposition(
        candidates=worth,
        chords=kept[cuts.chosen],
        pieces=cuts.pieces,
        cost=cuts.cost,
        n_subproblems=cuts.n_subproblems,
        n_dropped=len(worth) - len(kept),
        n_unmatched=found.n_unmatched,
        n_costly=len(found.chords) - len(worth),
        exhausted=exhausted,
    )


def find_endpoints(loop: Loop, turning_bound: float = TURNING_BOUND) -> NDArray[np.int64]:
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
    points, corners = np.ascontiguousarray(loop.points), np.ascontiguousarray(loop.corners)
    return np.flatnonzero(endpoints(points, corners, float(turning_bound)))


@dataclass(frozen=True, slots=True)
class Candidates:
    """The chords that a search may choose from.

    chords:      (c, 2) int64 positions i < j in the loop, ascending, no two alike.
    ends:        (e,) int64 positions of the ends that were given, ascending.
    n_unmatched: how many of the given ends no chord has.
    """

    chords: NDArray[np.int64] = field(repr=False)
    ends: NDArray[np.int64] = field(repr=False)
    n_unmatched: int


def find_candidates(loop: Loop, ends: NDArray[np.int64]) -> Candidates:
    """Chords from the ends (e,), positions in the loop, nearly perpendicular to it there.

    Each end has up to two: one to the nearest corner within 40 degrees of the normal plane, one
    to the closest point within 30. The latter ends at another end near the closest point, if one
    qualifies. If the corner is near the closest point, only the chord to the corner is kept.
    At a corner, the curve's tangent is the incoming or the outgoing edge's or half between. No
    chord joins neighbours or hugs the loop (HUGGING). The answer does not depend on where the
    loop starts and which way it runs.

    Source: Abbasinejad et al. 2013, section 3.1. Differs from the paper: it asks in one sentence
    to drop the chord of an end without a corner, and promises in another at least one chord for
    every end; here the chord to the closest point stays, an end may have none, and
    ``n_unmatched`` counts those. The paper's "close together" is NEAR_EDGES and NEAR_SHARE here.
    """
    given = np.unique(np.asarray(ends, np.int64))
    points, corners = np.ascontiguousarray(loop.points), np.ascontiguousarray(loop.corners)
    pairs = np.sort(candidates(points, corners, given), axis=1)
    n = len(points)
    chords = np.stack(np.divmod(np.unique(pairs[:, 0] * n + pairs[:, 1]), n), axis=1)
    used = np.unique(chords)
    matched = int(np.isin(given, used, assume_unique=True).sum())
    return Candidates(chords, given, len(given) - matched)


def keep_within_budget(
    points: Points, chords: NDArray[np.int64], max_subproblems: int
) -> NDArray[np.int64]:
    """(k, 2) the chords (m, 2) without the longest, so that no more sub-problems arise.

    As many are kept as possible; of chords equally long, all or none.
    """
    n = len(points)
    if count_subproblems(n, chords) <= max_subproblems:
        return chords
    lengths = np.linalg.norm(points[chords[:, 0]] - points[chords[:, 1]], axis=1)
    order = np.argsort(lengths, kind="stable")
    ascending = lengths[order]
    # More chords make more sub-problems: the most that fit are found by halving.
    fits, exceeds = 0, len(chords)
    while exceeds - fits > 1:
        middle = (fits + exceeds) // 2
        if count_subproblems(n, chords[order[:middle]]) <= max_subproblems:
            fits = middle
        else:
            exceeds = middle
    while fits and ascending[fits - 1] >= ascending[fits] * (1.0 - SAME):
        fits -= 1
    return chords[np.sort(order[:fits])]


def find_affordable(
    points: Points, chords: NDArray[np.int64], price: float = AREA_PRICE
) -> NDArray[np.bool_]:
    """(m,) which chords (m, 2), positions i < j in a loop (n, 3), are worth the area they add.

    A chord must make its sides flatter by what it adds: added <= NO_AREA + price * (box(loop) -
    box(one side) - box(other side)). A box is the product of the standard deviations along the
    principal axes, in units of the loop's mean one: 0 for a planar part, 1 for a loop spread as
    far in all directions. Raises InvalidNetworkError for a price below 0.

    Differs from the paper: it counts on short chords for a small area (Abbasinejad et al. 2013,
    section 3.2). That does not keep a chord from closing a bent strip off by a flat lid: two
    flat lids and a flat bottom cost it less than the strip.
    """
    if not price >= 0.0:
        raise InvalidNetworkError(f"the price of area is {price}; give a number from 0 on")
    if len(chords) == 0:
        return np.zeros(0, np.bool_)
    measured = _measured(points, chords)
    added = measure_added_area(points[measured], np.searchsorted(measured, chords))
    own = points - points.mean(axis=0)
    spread = math.sqrt(float((own * own).sum()) / own.size)
    if spread == 0.0:
        return np.zeros(len(chords), np.bool_)
    flattening = _measure_flattening(
        np.ascontiguousarray(own / spread), np.ascontiguousarray(chords, np.int64)
    )
    return added <= NO_AREA + price * np.maximum(flattening, 0.0)


def measure_added_area(points: Points, chords: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) by how much a cut along each chord (m, 2) raises the least area of a loop (n, 3).

    As a share of the loop's own least area; 0 where a triangulation of least area has the
    chord, and for a loop without area. Source: the recurrence of Barequet and Sharir 1995,
    around the loop instead of along it.
    """
    n = len(points)
    middle = points - points.mean(axis=0)
    least = tabulate_areas_around(np.ascontiguousarray(middle.T))
    whole = least[0, n - 1]
    if whole <= 0.0:
        return np.zeros(len(chords))
    first, second = chords[:, 0], chords[:, 1]
    span = second - first
    return (least[first, span] + least[second, n - span]) / whole - 1.0


def _measured(points: Points, chords: NDArray[np.int64]) -> NDArray[np.int64]:
    """Ascending positions of the ends of chords and of evenly spread vertices between."""
    n = len(points)
    stride = -(-n // MEASURED)
    # In an order that does not depend on where the loop starts and which way it runs.
    return np.union1d(order_canonically(np.ascontiguousarray(points))[::stride], chords)


@dataclass(frozen=True, slots=True)
class ChordCuts:
    """The best cuts of a cycle.

    chosen:  (k,) int64, which of the chords were chosen, ascending.
    pieces:  k + 1 closed loops of positions int64, in the loop's own sense. A step between
             positions that are no neighbours in the loop is a chosen chord.
    cost:    Sub(whole cycle).
    n_subproblems: how many sub-problems were solved, each once.
    """

    chosen: Int64Array = field(repr=False)
    pieces: tuple[Int64Array, ...] = field(repr=False)
    cost: float
    n_subproblems: int


def search_cuts(
    points: Points, chords: Int64Array, alpha: float = 0.1, form: Flatness = "relative"
) -> ChordCuts:
    """Choose chords so that the cost of the pieces and of the cuts is least.

        Sub(K) = min(S(K), min over chords c in K: Sub(left) + Sub(right) + alpha len(c) / len(K))

    where S is the flatness (:data:`Flatness`) and K runs over all sub-cycles that cuts by the
    chords lead to. Of equal costs (TIE) the one with fewer chords wins, then the one cut by the
    chord that comes first. A planar cycle is never cut.

    points: (n, 3) a closed loop. chords: (m, 2) positions i < j, not neighbours, no two alike.
    All sub-problems are solved, whatever alpha; each takes 16 bytes and less than 1 us.
    :func:`count_subproblems` counts them.

    Raises InvalidNetworkError for an alpha below 0 or not finite, chords that are not as above,
    and sub-problems too many to number.
    Source: Abbasinejad et al. 2013, section 3.2, Equations 1 to 3 and Algorithm 1.
    Differs from the paper: sub-problems are numbered and solved from the smallest up, see
    rust/surfacing/src/chords/subcycles.rs, where the paper recurses with a hash table.
    """
    points = np.ascontiguousarray(points, np.float64)
    chords = _check_chords(len(points), chords)
    if not (math.isfinite(alpha) and alpha >= 0):
        raise InvalidNetworkError(f"alpha is {alpha}; give a number >= 0")
    own, determinant = standardise(points)
    whole = np.arange(len(points))
    if determinant == 0.0 or not len(chords):
        # A planar cycle is a problem of its own, solved at a glance.
        scale = determinant if form == "printed" else float(determinant > 0.0)
        return ChordCuts(np.zeros(0, np.int64), (whole,), scale, 1)
    scale = determinant if form == "printed" else 1.0
    count, cost, chosen, bounds, positions = solve(
        points, own, chords, alpha / scale, form == "printed"
    )
    if count >= MOST_COUNTED:
        raise InvalidNetworkError(
            f"{len(chords)} chords make {MOST_COUNTED} sub-problems or more; give fewer chords"
        )
    pieces = tuple(np.split(positions, bounds))
    return ChordCuts(np.sort(chosen), pieces, cost * scale, count)


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


def count_subproblems(n: int, chords: Int64Array) -> int:
    """How many sub-problems a loop of n vertices has with these chords (m, 2), at most
    MOST_COUNTED: its sub-cycles. Found in polynomial time, without a search."""
    return int(counted(n, np.ascontiguousarray(chords, np.int64)))


def standardise(points: Points) -> tuple[Points, float]:
    """The points (n, 3) in axes in which their covariance is the unit matrix.

    Returns them and the determinant of their covariance, in units of length**6. If they are
    planar (PLANAR), points and determinant are 0.

    Ratios of determinants are the same in any axes; in these, the moments of every part are of
    the order of 1 and keep their digits, however flat, small or far away the points are.
    """
    own, determinant = standardised(np.ascontiguousarray(points, np.float64))
    return own, float(determinant)


def is_planar(points: Points) -> bool:
    """Are the points (n, 3) planar, as far as PLANAR tells? Then no piece of them is less so."""
    return standardise(points)[1] == 0.0
