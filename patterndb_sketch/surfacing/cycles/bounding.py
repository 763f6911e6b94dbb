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

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel

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


@kernel
def spread_costs(
    first: Int64Array,
    member: Int64Array,
    place: Int64Array,
    start: Int64Array,
    offset: Int64Array,
    one: Int64Array,
    other: Int64Array,
    price: Floats,
    cost: Floats,
) -> None:
    """Write the costs of pairs to the tables of the curves that they share, in equal parts.

    The candidates at curve c are rows and columns of cost[offset[c] : offset[c + 1]]. What cannot
    be had costs all at each.
    """
    for p in range(len(one)):
        i, j = one[p], other[p]
        shared = 0
        for e in range(first[i], first[i + 1]):
            for f in range(first[j], first[j + 1]):
                shared += member[e] == member[f]
        for e in range(first[i], first[i + 1]):
            for f in range(first[j], first[j + 1]):
                if member[e] == member[f]:
                    c = member[e]
                    width = start[c + 1] - start[c]
                    part = price[p] if price[p] >= LACKING else price[p] / shared
                    cost[offset[c] + place[e] * width + place[f]] = part
                    cost[offset[c] + place[f] * width + place[e]] = part


@kernel
def find_best_without(shares: Floats, cost: Floats, room: int, whole: bool, left_out: int) -> float:
    """What a curve's candidates but one are worth at most, as many as there is room for.

    shares: (k,). cost: (k * k,) of pairs. whole: LACKING is paid for room that is left. left_out:
    -1 for none.
    """
    k = len(shares)
    lacking = LACKING if whole else 0.0
    best = -room * lacking
    if room == 0:
        return best
    top = -np.inf
    for a in range(k):
        if a != left_out:
            best = max(best, shares[a] - (room - 1) * lacking)
            top = max(top, shares[a])
    if room == 1:
        return best
    for a in range(k):
        if a == left_out or shares[a] + top <= best:
            continue
        for b in range(a):
            if b != left_out and shares[a] + shares[b] > best:
                best = max(best, shares[a] + shares[b] - cost[a * k + b])
    return best


@kernel
def find_best_with(shares: Floats, cost: Floats, room: int, whole: bool, one: int) -> float:
    """Likewise those choices that have one of the candidates; room is 1 at least."""
    k = len(shares)
    if room == 1:
        return shares[one]
    partner = -LACKING if whole else 0.0
    for b in range(k):
        if b != one:
            partner = max(partner, shares[b] - cost[one * k + b])
    return shares[one] + partner


@kernel
def move_shares(
    first: Int64Array,
    member: Int64Array,
    place: Int64Array,
    start: Int64Array,
    offset: Int64Array,
    cost: Floats,
    room: Int64Array,
    whole: NDArray[np.bool_],
    shares: Floats,
    margin: Floats,
    sweeps: int,
) -> float:
    """Move shares until what the best at all curves are worth is little; returns their sum.

    margin: written for every candidate and curve: what the best there gain by having it.
    """
    n = len(first) - 1
    for sweep in range(sweeps + 1):
        for k in range(n):
            i = k if sweep % 2 == 0 else n - 1 - k
            total = 0.0
            for e in range(first[i], first[i + 1]):
                c = member[e]
                here = shares[start[c] : start[c + 1]]
                between = cost[offset[c] : offset[c + 1]]
                spare, full = int(room[c]), bool(whole[c])
                with_it = find_best_with(here, between, spare, full, int(place[e]))
                without = find_best_without(here, between, spare, full, int(place[e]))
                margin[e] = with_it - without
                total += margin[e]
            if sweep < sweeps:
                # As much is gained at each of its curves: nowhere more than is lost elsewhere.
                mean = total / (first[i + 1] - first[i])
                for e in range(first[i], first[i + 1]):
                    shares[start[member[e]] + place[e]] += mean - margin[e]
    best = 0.0
    for c in range(len(room)):
        here = shares[start[c] : start[c + 1]]
        between = cost[offset[c] : offset[c + 1]]
        best += find_best_without(here, between, int(room[c]), bool(whole[c]), -1)
    return best
