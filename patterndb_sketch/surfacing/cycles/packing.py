"""The best set of candidate cycles, exactly: set packing with costs of pairs, by CP-SAT.

Bounds of what choices can be worth with each candidate leave most candidates out of the search.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb._native.surfacing.cycles.bounding import move_shares, spread_costs
from patterndb.system.extras import require_extra

#: Gains and costs become integers in this part of a median curve's length.
UNIT = 1e-4

#: Cycles that a curve may bound: a surface has two sides there.
SIDES = 2

#: The part of the candidates, those with which a choice can be worth most, that is solved first,
#: and the fewest for which that is worth while. Of the 26 choices in the CASSIE sketches that took
#: the solver longest, 22 were the best of all, in a tenth of the time; with half of the candidates
#: 24 were, in a third of it.
LIKELY = 0.3
LEAST_LIKELY = 60

#: If their choice is worth less than the bound by this part of it, all are solved.
SHORT = 0.01

#: What may be spent on the question whether others would be better, as a part of the effort, and of
#: how many candidates, as a part of all: with more of them it is seldom enough.
PROOF = 0.05
PROVABLE = 0.7

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
class CycleProblem:
    """Which of some candidates to choose so that their value is greatest.

    curves:   of every candidate. gains: of every candidate.
    costs:    of pairs (i, j), >= 0, that are both chosen.
    room:     of some curves in how many chosen candidates they may be; of all others SIDES.
    forced:   candidates that are chosen. excluded: sets of candidates that must not all be chosen.
    full:     curves that must be in as many candidates as they may.
    least:    the value of a choice that is good enough; None for any.
    """

    curves: Sequence[Sequence[int]]
    gains: Sequence[float]
    costs: Mapping[tuple[int, int], float] = field(default_factory=dict)
    room: Mapping[int, int] = field(default_factory=dict)
    forced: Collection[int] = frozenset()
    excluded: Sequence[Sequence[int]] = ()
    full: Collection[int] = frozenset()
    least: float | None = None

    def find_room(self, curve: int) -> int:
        """Return in how many chosen candidates a curve may be."""
        return self.room.get(curve, SIDES)

    def weigh(self, chosen: Collection[int]) -> float:
        """Return the gains of candidates less the costs of their pairs."""
        some = set(chosen)
        paid = sum(cost for (i, j), cost in self.costs.items() if i in some and j in some)
        return float(sum(self.gains[i] for i in sorted(some))) - paid


def solve_packing(
    problem: CycleProblem, effort: float = 2.0, prove: bool = True
) -> tuple[tuple[int, ...], bool] | None:
    """Find the candidates of the greatest value such that no curve is in more than fit there.

    effort: in CP-SAT's units of deterministic time, some seconds each; the result depends on no
    clock. prove: look for what is better among unlikely candidates, too.

    Returns the numbers of those chosen, ascending, and whether there is surely nothing better, to
    UNIT; None if nothing fits, or nothing was found with this effort.

    A cost as high as the gain of one of the two bars the pair: dropping that one is no worse. The
    bounds show which candidates are likely; of those alone the best are chosen, and then they show
    which of the others could still be better.
    """
    gains, must, whole = problem.gains, set(problem.forced), set(problem.full)
    usable = [
        i
        for i, gain in enumerate(gains)
        if i in must
        or ((whole or gain > 0.0) and all(problem.find_room(c) > 0 for c in problem.curves[i]))
    ]
    pairs = {
        (i, j): math.inf if not whole and not must & {i, j} and c >= min(gains[i], gains[j]) else c
        for (i, j), c in problem.costs.items()
        if _whole(c) > 0
    }
    least = problem.least
    problem = replace(problem, costs=pairs, forced=must, full=whole, least=None)
    bounds = bound_choices(problem, usable) if usable else None
    if bounds is None:
        return _solve(replace(problem, least=least), usable, effort)
    most = bounds.most
    if least is not None:
        if bounds.best < least - UNIT:
            return None
        usable = [i for i in usable if i in must or most[i] >= least - UNIT]
    size = max(LEAST_LIKELY, round(LIKELY * len(usable)))
    if whole or len(usable) <= size:
        return _solve(replace(problem, least=least), usable, effort)
    likely = set(sorted(usable, key=lambda i: (i not in must, -most[i], i))[:size]) | must
    found = _solve(problem, sorted(likely), effort)
    if found is None:
        return _solve(problem, usable, effort)
    chosen, proven = found
    value = problem.weigh(chosen)
    if value < bounds.best - SHORT * abs(bounds.best):
        # So few may not suffice: where all usable ones are meant, they are too few.
        every = _solve(problem, usable, effort)
        if every is not None and problem.weigh(every[0]) > value + UNIT:
            return every
    better = [i for i in usable if i in must or most[i] > value + UNIT]
    if likely.issuperset(better):
        return chosen, proven
    if not prove or len(better) > PROVABLE * len(usable):
        return chosen, False
    outcome = _search(replace(problem, least=value + UNIT), better, PROOF * effort)
    if outcome is None:
        return chosen, False
    return (chosen, True) if outcome[0] is None else (outcome[0], outcome[1])


def _solve(
    problem: CycleProblem, usable: Sequence[int], effort: float
) -> tuple[tuple[int, ...], bool] | None:
    """Return the best choice among some candidates, and whether it surely is; None without one."""
    outcome = _search(problem, usable, effort)
    return None if outcome is None or outcome[0] is None else (outcome[0], outcome[1])


def _search(
    problem: CycleProblem, usable: Sequence[int], effort: float
) -> tuple[tuple[int, ...], bool] | tuple[None, bool] | None:
    """Likewise, but (None, True) if nothing fits, and None if the effort did not suffice."""
    curves = problem.curves
    # A quarter of a second to import, with all that it brings; and it is an extra.
    require_extra("sketch", "choosing the cycles of a network")
    from ortools.sat.python import cp_model

    model: Any = cp_model.CpModel()
    x: list[Any] = [None] * len(curves)
    for i in usable:
        x[i] = model.new_bool_var(f"x{i}")
    at: dict[int, list[int]] = {}
    for i, of_candidate in enumerate(curves):
        if x[i] is not None:
            for curve in of_candidate:
                at.setdefault(curve, []).append(i)
    if any(len(at.get(curve, ())) < problem.find_room(curve) for curve in problem.full):
        return None, True
    for curve, candidates in at.items():
        total = sum(x[i] for i in candidates)
        if curve in problem.full:
            model.add(total == problem.find_room(curve))
        elif len(candidates) > problem.find_room(curve):
            model.add(total <= problem.find_room(curve))
    for i in sorted(problem.forced):
        model.add(x[i] == 1)
    for group in problem.excluded:
        if all(x[i] is not None for i in group):
            model.add_bool_or([~x[i] for i in group])
    terms = [_whole(gain) * x[i] for i, gain in enumerate(problem.gains) if x[i] is not None]
    for (i, j), cost in problem.costs.items():
        if x[i] is None or x[j] is None:
            continue
        if cost == math.inf:
            model.add_bool_or([~x[i], ~x[j]])
        else:
            both = model.new_bool_var("")
            model.add_bool_or([~x[i], ~x[j], both])
            terms.append(-_whole(cost) * both)
    model.maximize(sum(terms))
    if problem.least is not None:
        model.add(sum(terms) >= _whole(problem.least))
    solver: Any = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    # OR-Tools would take Ctrl-C for itself, and leave it to end the process without a word.
    solver.parameters.catch_sigint_signal = False
    solver.parameters.random_seed = 0
    # With all of the linear relaxation, choices that otherwise take seconds take 0.1 s.
    solver.parameters.linearization_level = 2
    # It takes about as long as the search, and does not shorten it.
    solver.parameters.cp_model_presolve = False
    solver.parameters.max_deterministic_time = effort
    status = solver.solve(model)
    if status == cp_model.INFEASIBLE:
        return None, True
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return None
    chosen = tuple(i for i, var in enumerate(x) if var is not None and solver.value(var))
    return chosen, status == cp_model.OPTIMAL


def _whole(value: float) -> int:
    return round(float(value) / UNIT)


@dataclass(frozen=True, slots=True)
class ChoiceBounds:
    """What choices can be worth at most.

    best: any. most: (k,) those with a candidate; -inf for one that cannot be chosen.
    """

    best: float
    most: NDArray[np.float64] = field(repr=False)


def bound_choices(problem: CycleProblem, usable: Sequence[int]) -> ChoiceBounds | None:
    """Bound the value of choices among ``usable`` candidates from above.

    Costs of pairs may be inf, where both cannot be chosen; those that share no curve do not count.
    Returns None where there would be more than MOST_PAIRS.

    The gain of a candidate is laid on its curves in shares, and so is the cost of a pair. Any
    choice is then worth no more than the sum, over all curves, of the best one or two candidates
    at each. Shares are moved from curves where a candidate could not be missed to those where it
    could not be afforded, one candidate after another, and the sum falls at every step: block
    coordinate ascent of the dual of set packing, as in MPLP (Globerson and Jaakkola 2007).
    """
    curves = problem.curves
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
    shares[start[member] + place] = np.array([problem.gains[i] for i in usable])[owners] / counts
    at = {i: k for k, i in enumerate(usable)}
    listed = [(at[i], at[j], c) for (i, j), c in problem.costs.items() if i in at and j in at]
    one = np.array([i for i, _, _ in listed], np.int64)
    other = np.array([j for _, j, _ in listed], np.int64)
    price = np.minimum(np.array([c for _, _, c in listed], np.float64), LACKING)
    cost = np.zeros(int(offset[-1]))
    spread_costs(first, member, place, start, offset, one, other, price, cost)
    spare = np.array([problem.find_room(c) for c in number], np.int64)
    whole = np.isin(np.array(list(number), np.int64), np.array(sorted(problem.full), np.int64))
    margin = np.zeros(len(member))
    best = move_shares(
        first, member, place, start, offset, cost, spare, whole, shares, margin, SWEEPS
    )
    most = np.full(len(curves), -np.inf)
    loss = np.bincount(owners, np.minimum(margin, 0.0), minlength=len(usable))
    most[np.array(usable, np.int64)] = best + loss
    return ChoiceBounds(best, most)
