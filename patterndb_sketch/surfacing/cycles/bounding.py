"""What a choice of cycles can be worth at most with each candidate: what need not be looked at.

The gain of a candidate is laid on its curves in shares, and so is the cost of a pair. Whatever is
chosen is then worth no more than the sum, over all curves, of the best one or two candidates at
each. Shares are moved from curves where a candidate could not be missed to those where it could not
be afforded, one candidate after another, and the sum falls at every step: block coordinate ascent
of the dual of set packing, as in MPLP (Globerson and Jaakkola 2007).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb._native.surfacing.cycles.bounding import move_shares, spread_costs

#: Times that all candidates' shares are moved. In most CASSIE sketches four times as many lower the
#: bound by less than a hundredth.
SWEEPS = 16

#: What lacks at a curve that must be bounded twice: more than any gain, and a number that can be
#: shared out.
#: The same as in rust/surfacing/src/cycles/bounding.rs.
LACKING = 1e5

#: Pairs at curves, counted at each, that are weighed at most; 8 bytes each.
MOST_PAIRS = 10_000_000


@dataclass(frozen=True, slots=True)
class ChoiceBounds:
    """What choices can be worth at most.

    best: any. most: (k,) those with a candidate; -inf for one that cannot be chosen.
    """

    best: float
    most: NDArray[np.float64] = field(repr=False)


def bound_choices(
    curves: Sequence[Sequence[int]],
    gains: Sequence[float],
    pairs: Mapping[tuple[int, int], float],
    room: Mapping[int, int],
    usable: Sequence[int],
    full: Collection[int] = (),
) -> ChoiceBounds | None:
    """Bound what choices among ``usable`` candidates are worth, from above.

    curves, gains, room, full: as :func:`patterndb_sketch.surfacing.cycles.packing.solve_packing`
    has them. pairs: the costs of pairs, inf where both cannot be chosen; those that share no curve
    do not count. Returns None where there would be more than MOST_PAIRS.
    """
    number = {curve: k for k, curve in enumerate(sorted({c for i in usable for c in curves[i]}))}
    first = np.zeros(len(usable) + 1, np.int64)
    first[1:] = np.cumsum([len(curves[i]) for i in usable])
    member = np.array([number[c] for i in usable for c in curves[i]], np.int64)
    size = np.bincount(member, minlength=len(number))
    start = np.r_[0, np.cumsum(size)]
    offset = np.r_[0, np.cumsum(size**2)]
    if offset[-1] > MOST_PAIRS:
        return None
    # Of every candidate and curve its place among the curve's candidates.
    place = np.empty(len(member), np.int64)
    order = np.argsort(member, kind="stable")
    place[order] = np.arange(len(member)) - start[member[order]]
    owners = np.repeat(np.arange(len(usable)), np.diff(first))
    shares = np.empty(len(member))
    counts = np.diff(first)[owners]
    shares[start[member] + place] = np.array([gains[i] for i in usable])[owners] / counts
    at = {i: k for k, i in enumerate(usable)}
    listed = [(at[i], at[j], c) for (i, j), c in pairs.items() if i in at and j in at]
    one = np.array([i for i, _, _ in listed], np.int64)
    other = np.array([j for _, j, _ in listed], np.int64)
    price = np.minimum(np.array([c for _, _, c in listed], np.float64), LACKING)
    cost = np.zeros(int(offset[-1]))
    spread_costs(first, member, place, start, offset, one, other, price, cost)
    spare = np.array([room[c] for c in number], np.int64)
    whole = np.isin(np.array(list(number), np.int64), np.array(sorted(full), np.int64))
    margin = np.zeros(len(member))
    best = move_shares(
        first, member, place, start, offset, cost, spare, whole, shares, margin, SWEEPS
    )
    most = np.full(len(curves), -np.inf)
    loss = np.bincount(owners, np.minimum(margin, 0.0), minlength=len(usable))
    most[np.array(usable, np.int64)] = best + loss
    return ChoiceBounds(best, most)
