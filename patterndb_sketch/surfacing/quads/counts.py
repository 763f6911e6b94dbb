"""Edge counts: how many edges every curve gets so that every cycle has a quad mesh.

A disk of quads has an even boundary, of four edges or more. A curve between two patches counts
for both, so that the curves of a network must be rounded together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from patterndb.geometry.polyline import MIN_EDGES, arc_length
from patterndb.system.extras import require_extra
from patterndb_sketch.surfacing.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.sampling import default_spacing, edges_at, stretches

#: The solver takes whole numbers: so many for a cost of 1. A curve costs less than log(5) squared,
#: so that the sum over a million curves still fits in 63 bits.
COST_UNITS = 10**12

#: Work the solver may do, in its own deterministic seconds: these count operations, so that the
#: same network always has the same counts. By the clock it is some ten seconds; 200 patches take
#: half a second where every curve is half way between two numbers, and far less elsewhere.
MOST_WORK = 2.0


@dataclass(frozen=True, slots=True)
class EvenEdges:
    """Edge counts with which every cycle is even.

    edges: edges of every stretch of every curve, as
    :func:`patterndb_sketch.surfacing.sampling.sample`
           takes them.
    cost:  the sum, over stretches, of log(edges / wanted) squared.
    least: is it proven that no other counts cost less? Not so where the solver came to the
           end of its work, as with thousands of patches.
    """

    edges: tuple[tuple[int, ...], ...]
    cost: float
    least: bool


def count_even_edges(
    network: CurveNetwork,
    cycles: Sequence[Cycle],
    spacing: float | None = None,
    most_work: float = MOST_WORK,
) -> EvenEdges:
    """Edges for every stretch of every curve such that each cycle has an even number, >= 4.

    cycles: walks along curves of the network; a curve may be in any number of them. spacing:
    about how long an edge shall be, by default :func:`default_spacing`. most_work: see MOST_WORK.

    Of all such counts those with the least sum, over stretches, of log(edges / wanted) squared:
    wanted is a stretch's length in spacings, or, if that is more, the fewest edges that keep
    its shape (:func:`edges_at`); no count is below these. There always are such counts: with
    even numbers everywhere all cycles are even.

    Raises InvalidNetworkError for a spacing that is not above 0, a network without curves, and
    cycles that :meth:`CurveNetwork.walk` refuses.
    """
    spacing = default_spacing(network) if spacing is None else spacing
    if not (math.isfinite(spacing) and spacing > 0):
        raise InvalidNetworkError(f"the spacing is {spacing}; give a length above 0")
    for cycle in cycles:
        network.walk(cycle)
    used = {curve for cycle in cycles for curve in cycle.curves}
    choices = [
        _choices(curve, spacing, number in used) for number, curve in enumerate(network.curves)
    ]
    chosen, least = _chosen(choices, cycles, most_work)
    picked = [options[at] for options, at in zip(choices, chosen, strict=True)]
    return EvenEdges(
        tuple(option.edges for option in picked), sum(option.cost for option in picked), least
    )


@dataclass(frozen=True, slots=True)
class _EdgeChoice:
    """One way to number a curve's edges: of all with the same sum, the one of least cost."""

    edges: tuple[int, ...]
    cost: float

    @property
    def total(self) -> int:
        return sum(self.edges)


def _choices(curve: Curve, spacing: float, in_cycle: bool) -> list[_EdgeChoice]:
    """What the least counts may have for a curve, the cheapest first.

    That is the nearest whole numbers, and one edge more or one fewer. Two further from the
    nearest cost more and are as even; only where a cycle would have fewer than four edges may it
    take more, and four or five on one curve always do.
    """
    fewest = edges_at(curve, math.inf)
    wanted = [
        max(float(arc_length(part)[-1]) / spacing, float(few))
        for part, few in zip(stretches(curve), fewest, strict=True)
    ]
    nearest = [_nearest(length) for length in wanted]
    total = sum(nearest)
    first = _EdgeChoice(tuple(nearest), _cost(nearest, wanted))
    if not in_cycle:
        return [first]
    found = [first]
    options = [
        [n - 1 if i == j else n for i, n in enumerate(nearest)]
        for j in range(len(nearest))
        if nearest[j] > fewest[j]
    ]
    if options:
        edges = min(options, key=lambda edges: _cost(edges, wanted))
        found.append(_EdgeChoice(tuple(edges), _cost(edges, wanted)))
    for more in range(1, max(1, MIN_EDGES + 1 - total) + 1):
        edges = _raised(nearest, wanted, more)
        found.append(_EdgeChoice(edges, _cost(edges, wanted)))
    found.sort(key=lambda choice: choice.cost)
    if total < MIN_EDGES:
        return found
    # Nothing but evenness matters here: of the odd ones, or the even ones, the cheapest will do.
    return [first, next(choice for choice in found if (choice.total - total) % 2)]


def _nearest(wanted: float) -> int:
    """The whole number >= 1 nearest to a number >= 1 in proportion."""
    below = int(wanted)
    return below if wanted * wanted <= below * (below + 1) else below + 1


def _cost(edges: Sequence[int], wanted: Sequence[float]) -> float:
    return sum(math.log(n / w) ** 2 for n, w in zip(edges, wanted, strict=True))


def _raised(nearest: Sequence[int], wanted: Sequence[float], more: int) -> tuple[int, ...]:
    """The counts with ``more`` edges added at the least cost.

    Tried in full, stretch after stretch: costs are not convex far from what is wanted.
    """
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (0.0, ())}
    for n, w in zip(nearest, wanted, strict=True):
        further: dict[int, tuple[float, tuple[int, ...]]] = {}
        for added, (cost, edges) in best.items():
            for extra in range(more - added + 1):
                tried = cost + _cost([n + extra], [w]), (*edges, n + extra)
                at = added + extra
                if at not in further or tried < further[at]:
                    further[at] = tried
        best = further
    return best[more][1]


def _chosen(
    choices: Sequence[Sequence[_EdgeChoice]], cycles: Sequence[Cycle], most_work: float
) -> tuple[list[int], bool]:
    """The place of every curve's choice, and whether it is proven that these cost least."""
    if all(_sound(choices, cycle, [0] * len(choices)) for cycle in cycles):
        return [0] * len(choices), True
    require_extra("sketch", "choosing the edge counts of curves")
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    taken: list[list[Any]] = []
    totals: list[Any] = []
    costs: list[Any] = []
    even = [_even(options) for options in choices]
    for number, options in enumerate(choices):
        flags = [model.new_bool_var("") for _ in options]
        model.add_exactly_one(flags)
        taken.append(flags)
        totals.append(sum(c.total * flag for c, flag in zip(options, flags, strict=True)))
        # Whole numbers above the first: what cannot be helped need not be told apart.
        costs += [
            round((c.cost - options[0].cost) * COST_UNITS) * flag
            for c, flag in zip(options, flags, strict=True)
        ]
        for at, flag in enumerate(flags):
            model.add_hint(flag, at == even[number])
    for cycle in cycles:
        most = sum(max(c.total for c in choices[curve]) for curve in cycle.curves)
        half = model.new_int_var(MIN_EDGES // 2, max(most // 2, MIN_EDGES // 2), "")
        model.add(sum(totals[curve] for curve in cycle.curves) == 2 * half)
    model.minimize(sum(costs))
    solver = cp_model.CpSolver()
    # One worker and a limit in operations: the same network always has the same counts.
    solver.parameters.num_workers = 1
    # OR-Tools would take Ctrl-C for itself, and leave it to end the process without a word.
    solver.parameters.catch_sigint_signal = False
    solver.parameters.random_seed = 0
    solver.parameters.max_deterministic_time = most_work
    status = solver.solve(model)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return even, False
    chosen = [
        next(at for at, flag in enumerate(flags) if solver.boolean_value(flag)) for flags in taken
    ]
    return chosen, status == cp_model.OPTIMAL


def _even(options: Sequence[_EdgeChoice]) -> int:
    """The cheapest choice that serves any cycle: an even one, of four edges or more."""
    wanted = [at for at, c in enumerate(options) if c.total % 2 == 0 and c.total >= MIN_EDGES]
    return wanted[0] if wanted else 0


def _sound(choices: Sequence[Sequence[_EdgeChoice]], cycle: Cycle, chosen: Sequence[int]) -> bool:
    total = sum(choices[curve][chosen[curve]].total for curve in cycle.curves)
    return total % 2 == 0 and total >= MIN_EDGES
