"""One cycle cut into nearly flat pieces by chords."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.chords.addedarea import AREA_PRICE, affordable
from patterndb_sketch.surfacing.chords.candidates import candidate_chords
from patterndb_sketch.surfacing.chords.endpoints import TURNING_BOUND, endpoints
from patterndb_sketch.surfacing.chords.flatness import Flatness, is_planar
from patterndb_sketch.surfacing.chords.order import SAME
from patterndb_sketch.surfacing.chords.search import search
from patterndb_sketch.surfacing.chords.subcycles import n_subproblems
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.sampling import Loop

#: How much a cut weighs against the flatness it gains (Abbasinejad et al. 2013, section 3.2: 0.1
#: for all models but the front of the roadster, 0.6).
ALPHA = 0.1

#: The most sub-problems solved for one cycle: some 0.1 s. The paper's largest has 12,319.
MAX_SUBPROBLEMS = 200_000

#: The largest share of the candidates that may be dropped to keep to the budget: what is left
#: says little about a cycle after that, and another method serves it better.
MOST_DROPPED = 0.5


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
    :func:`affordable`; None, as in the paper: anything. flatness: see :func:`flatness`.
    turning_bound: radians, see :func:`endpoints`. max_subproblems: the budget; where the
    candidates make more, the longest are left out, and where that would be more than half of
    them, the search is given up and says so. The number of sub-problems does not depend on alpha.

    The cost does not depend on where the loop starts and which way it runs.
    Raises InvalidNetworkError for an alpha below 0, a bound not above 0, a budget below 1.
    Source: Abbasinejad et al. 2013, section 3. Differs from the paper: it has no budget, and
    worst cases take exponential time; and it searches chords whatever area they add.
    """
    if max_subproblems < 1:
        raise InvalidNetworkError(f"the budget is {max_subproblems} sub-problems; give at least 1")
    found = candidate_chords(loop, endpoints(loop, turning_bound))
    worth = found.chords
    # A planar loop is never cut: nothing takes time, whatever the candidates.
    planar = is_planar(loop.points)
    if area_price is not None and not planar:
        worth = worth[affordable(loop.points, worth, area_price)]
    started = time.perf_counter()
    kept = worth if planar else within_budget(loop.points, worth, max_subproblems)
    exhausted = len(worth) - len(kept) > MOST_DROPPED * len(worth)
    if exhausted:
        kept = kept[:0]
    counted = time.perf_counter() - started
    cuts = search(loop.points, kept, alpha, flatness)
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


def within_budget(
    points: Points, chords: NDArray[np.int64], max_subproblems: int
) -> NDArray[np.int64]:
    """(k, 2) the chords (m, 2) without the longest, so that no more sub-problems arise.

    As many are kept as possible; of chords equally long, all or none.
    """
    n = len(points)
    if n_subproblems(n, chords) <= max_subproblems:
        return chords
    lengths = np.linalg.norm(points[chords[:, 0]] - points[chords[:, 1]], axis=1)
    order = np.argsort(lengths, kind="stable")
    ascending = lengths[order]
    # More chords make more sub-problems: the most that fit are found by halving.
    fits, exceeds = 0, len(chords)
    while exceeds - fits > 1:
        middle = (fits + exceeds) // 2
        if n_subproblems(n, chords[order[:middle]]) <= max_subproblems:
            fits = middle
        else:
            exceeds = middle
    while fits and ascending[fits - 1] >= ascending[fits] * (1.0 - SAME):
        fits -= 1
    return chords[np.sort(order[:fits])]
