"""The best set of candidate cycles, exactly: set packing with costs of pairs, by CP-SAT."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from patterndb.system.extras import require_extra

#: Gains and costs become integers in this part of a median curve's length.
UNIT = 1e-4

#: Cycles that a curve may bound: a surface has two sides there.
SIDES = 2


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
) -> tuple[tuple[int, ...], bool] | None:
    """Find the candidates of the greatest value such that no curve is in more than fit there.

    curves: the curves of every candidate. gains: of each. costs: of pairs (i, j), >= 0, that are
    both chosen. room: for every curve in how many it may be, SIDES or less. forced: candidates
    that are chosen. excluded: sets of
    candidates that must not all be chosen. full: curves that must be in as many as they may.
    least: a value that is not worth less. effort: in CP-SAT's units of deterministic time, about a
    second each; the result depends on no clock.

    Returns the numbers of those chosen, ascending, and whether there is surely nothing better, to
    UNIT; None if nothing fits, or nothing was found with this effort.

    A cost as high as the gain of one of the two bars the pair: dropping that one is no worse.
    """
    # A quarter of a second to import, with all that it brings; and it is an extra.
    require_extra("sketch", "choosing the cycles of a network")
    from ortools.sat.python import cp_model

    model: Any = cp_model.CpModel()
    must = set(forced)
    free = bool(full)
    x: list[Any] = [
        model.new_bool_var(f"x{i}") if free or gain > 0.0 or i in must else None
        for i, gain in enumerate(gains)
    ]
    at: dict[int, list[int]] = {}
    for i, of_candidate in enumerate(curves):
        if x[i] is not None:
            for curve in of_candidate:
                at.setdefault(curve, []).append(i)
    whole = set(full)
    if any(len(at.get(curve, ())) < room[curve] for curve in whole):
        return None
    for curve, candidates in at.items():
        total = sum(x[i] for i in candidates)
        if curve in whole:
            model.add(total == room[curve])
        elif len(candidates) > room[curve]:
            model.add(total <= room[curve])
    for i in sorted(must):
        model.add(x[i] == 1)
    for group in excluded:
        if all(x[i] is not None for i in group):
            model.add_bool_or([~x[i] for i in group])
    terms = [_whole(gain) * x[i] for i, gain in enumerate(gains) if x[i] is not None]
    for (i, j), cost in costs.items():
        if x[i] is None or x[j] is None or _whole(cost) <= 0:
            continue
        if not free and not must & {i, j} and cost >= min(gains[i], gains[j]):
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
    solver.parameters.random_seed = 0
    # With all of the linear relaxation, choices that otherwise take seconds take 0.1 s.
    solver.parameters.linearization_level = 2
    # It takes about as long as the search, and does not shorten it.
    solver.parameters.cp_model_presolve = False
    solver.parameters.max_deterministic_time = effort
    status = solver.solve(model)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return None
    chosen = tuple(i for i, var in enumerate(x) if var is not None and solver.value(var))
    return chosen, status == cp_model.OPTIMAL


def _whole(value: float) -> int:
    return round(float(value) / UNIT)
