"""The best set of candidate cycles, exactly: set packing with costs of pairs, by CP-SAT."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from patterndb.system.extras import require_extra
from patterndb_sketch.surfacing.cycles.bounding import bound_choices

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


def solve_packing(
    curves: Sequence[Sequence[int]],
    gains: Sequence[float],
    costs: Mapping[tuple[int, int], float],
    room: Mapping[int, int],
    *,
    forced: Collection[int] = (),
    excluded: Iterable[Sequence[int]] = (),
    full: Collection[int] = (),
    least: float | None = None,
    effort: float = 2.0,
    prove: bool = True,
) -> tuple[tuple[int, ...], bool] | None:
    """Find the candidates of the greatest value such that no curve is in more than fit there.

    curves: the curves of every candidate. gains: of each. costs: of pairs (i, j), >= 0, that are
    both chosen. room: for every curve in how many it may be, SIDES or less. forced: candidates
    that are chosen. excluded: sets of
    candidates that must not all be chosen. full: curves that must be in as many as they may.
    least: a value that is not worth less. effort: in CP-SAT's units of deterministic time, some
    seconds each; the result depends on no clock. prove: look for what is better among unlikely
    candidates, too.

    Returns the numbers of those chosen, ascending, and whether there is surely nothing better, to
    UNIT; None if nothing fits, or nothing was found with this effort.

    A cost as high as the gain of one of the two bars the pair: dropping that one is no worse. What
    choices can be worth at most says which candidates are likely; of those alone the best are
    chosen, and then it says which of the others could still be better.
    """
    must = set(forced)
    whole = set(full)
    usable = [
        i
        for i, gain in enumerate(gains)
        if i in must or ((whole or gain > 0.0) and all(room[c] > 0 for c in curves[i]))
    ]
    pairs = {
        (i, j): math.inf if not whole and not must & {i, j} and c >= min(gains[i], gains[j]) else c
        for (i, j), c in costs.items()
        if _whole(c) > 0
    }
    packing = _Packing(curves, gains, pairs, room, must, list(excluded), whole)
    bounds = bound_choices(curves, gains, pairs, room, usable, whole) if usable else None
    if bounds is None:
        return _solve(packing, usable, least, effort)
    most = bounds.most
    if least is not None:
        if bounds.best < least - UNIT:
            return None
        usable = [i for i in usable if i in must or most[i] >= least - UNIT]
    size = max(LEAST_LIKELY, round(LIKELY * len(usable)))
    if whole or len(usable) <= size:
        return _solve(packing, usable, least, effort)
    likely = set(sorted(usable, key=lambda i: (i not in must, -most[i], i))[:size]) | must
    found = _solve(packing, sorted(likely), None, effort)
    if found is None:
        return _solve(packing, usable, None, effort)
    chosen, proven = found
    value = packing.weigh(chosen)
    if value < bounds.best - SHORT * abs(bounds.best):
        # So few may not suffice: where all usable ones are meant, they are too few.
        every = _solve(packing, usable, None, effort)
        if every is not None and packing.weigh(every[0]) > value + UNIT:
            return every
    better = [i for i in usable if i in must or most[i] > value + UNIT]
    if likely.issuperset(better):
        return chosen, proven
    if not prove or len(better) > PROVABLE * len(usable):
        return chosen, False
    outcome = _search(packing, better, value + UNIT, PROOF * effort)
    if outcome is None:
        return chosen, False
    return (chosen, True) if outcome[0] is None else (outcome[0], outcome[1])


@dataclass(frozen=True, slots=True)
class _Packing:
    """What :func:`solve_packing` is asked; the cost of pairs that are barred is inf."""

    curves: Sequence[Sequence[int]]
    gains: Sequence[float]
    pairs: Mapping[tuple[int, int], float]
    room: Mapping[int, int]
    forced: set[int]
    excluded: Sequence[Sequence[int]]
    full: set[int]

    def weigh(self, chosen: Collection[int]) -> float:
        """The gains of candidates less the costs of their pairs."""
        some = set(chosen)
        paid = sum(cost for (i, j), cost in self.pairs.items() if i in some and j in some)
        return sum(self.gains[i] for i in chosen) - paid


def _solve(
    packing: _Packing, usable: Sequence[int], least: float | None, effort: float
) -> tuple[tuple[int, ...], bool] | None:
    """The best choice among some candidates, and whether it surely is; None if none was found."""
    outcome = _search(packing, usable, least, effort)
    return None if outcome is None or outcome[0] is None else (outcome[0], outcome[1])


def _search(
    packing: _Packing, usable: Sequence[int], least: float | None, effort: float
) -> tuple[tuple[int, ...], bool] | tuple[None, bool] | None:
    """Likewise, but (None, True) if nothing fits, and None if the effort did not tell."""
    curves, gains, room = packing.curves, packing.gains, packing.room
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
    if any(len(at.get(curve, ())) < room[curve] for curve in packing.full):
        return None, True
    for curve, candidates in at.items():
        total = sum(x[i] for i in candidates)
        if curve in packing.full:
            model.add(total == room[curve])
        elif len(candidates) > room[curve]:
            model.add(total <= room[curve])
    for i in sorted(packing.forced):
        model.add(x[i] == 1)
    for group in packing.excluded:
        if all(x[i] is not None for i in group):
            model.add_bool_or([~x[i] for i in group])
    terms = [_whole(gain) * x[i] for i, gain in enumerate(gains) if x[i] is not None]
    for (i, j), cost in packing.pairs.items():
        if x[i] is None or x[j] is None:
            continue
        if cost == math.inf:
            model.add_bool_or([~x[i], ~x[j]])
        else:
            both = model.new_bool_var("")
            model.add_bool_or([~x[i], ~x[j], both])
            terms.append(-_whole(cost) * both)
    model.maximize(sum(terms))
    if least is not None:
        model.add(sum(terms) >= _whole(least))
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
