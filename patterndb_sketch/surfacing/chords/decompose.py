"""One cycle cut into nearly flat pieces by chords."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from patterndb._native.geometry.leastarea import tabulate_areas_around
from patterndb._native.surfacing.chords.candidates import order_canonically
from patterndb._native.surfacing.chords.decompose import flatter as _flatter
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.chords.candidates import (
    SAME,
    TURNING_BOUND,
    find_candidates,
    find_endpoints,
)
from patterndb_sketch.surfacing.chords.flatness import Flatness, is_planar
from patterndb_sketch.surfacing.chords.search import search_cuts
from patterndb_sketch.surfacing.chords.subcycles import count_subproblems
from patterndb_sketch.surfacing.sampling import Loop

#: How much a cut weighs against the flatness it gains (Abbasinejad et al. 2013, section 3.2: 0.1
#: for all models but the front of the roadster, 0.6).
ALPHA = 0.1

#: The most sub-problems solved for one cycle: some 0.1 s. The paper's largest has 12,319.
MAX_SUBPROBLEMS = 200_000

#: The largest share of the candidates that may be dropped to keep to the budget: what is left
#: says little about a cycle after that, and another method serves it better.
MOST_DROPPED = 0.5

#: A chord may add this much area, as a share of the loop's least, for each unit of box that it
#: takes away. Chosen with the shapes of benchmarks/surfacing in view: 0.3 to 0.4 serve them alike,
#: below 0.294 their gable roof loses its ridge.
AREA_PRICE = 1.0 / 3.0

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
    seconds:       how long the search for the chords took, without that for candidates.
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
    seconds: float
    n_dropped: int
    n_unmatched: int
    n_costly: int
    exhausted: bool


def decompose(
    loop: Loop,
    alpha: float = ALPHA,
    *,
    area_price: float | None = AREA_PRICE,
    flatness: Flatness = "relative",
    turning_bound: float = TURNING_BOUND,
    max_subproblems: int = MAX_SUBPROBLEMS,
) -> Decomposition:
    """Cut a loop into nearly flat pieces by few, short chords.

    alpha: the larger, the fewer pieces. area_price: what chords may cost in area, see
    :func:`find_affordable`; None, as in the paper: anything. flatness: see
    :func:`measure_flatness`.
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
    if area_price is not None and not planar:
        worth = worth[find_affordable(loop.points, worth, area_price)]
    started = perf_counter()
    kept = worth if planar else keep_within_budget(loop.points, worth, max_subproblems)
    exhausted = len(worth) - len(kept) > MOST_DROPPED * len(worth)
    if exhausted:
        kept = kept[:0]
    counted = perf_counter() - started
    cuts = search_cuts(loop.points, kept, alpha, flatness)
    return Decomposition(
        candidates=worth,
        chords=kept[cuts.chosen],
        pieces=cuts.pieces,
        cost=cuts.cost,
        n_subproblems=cuts.n_subproblems,
        seconds=counted + cuts.seconds,
        n_dropped=len(worth) - len(kept),
        n_unmatched=found.n_unmatched,
        n_costly=len(found.chords) - len(worth),
        exhausted=exhausted,
    )


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
    flatter = _flatter(np.ascontiguousarray(own / spread), np.ascontiguousarray(chords, np.int64))
    return added <= NO_AREA + price * np.maximum(flatter, 0.0)


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
