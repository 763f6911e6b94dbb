"""The cycles of a network: candidates, what speaks against them, and the choice among them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.curvenetwork.network import (
    CurveNetwork,
    Cycle,
    InvalidNetworkError,
)
from patterndb_sketch.surfacing.cycles.chains import ChainedNetwork, chain_curves, order_chains
from patterndb_sketch.surfacing.cycles.choosing import CycleChoice, choose_cycles
from patterndb_sketch.surfacing.cycles.closing import (
    find_candidate_cycles,
    find_dangling,
    find_lone_loops,
    group_components,
    list_half_curves,
)
from patterndb_sketch.surfacing.cycles.found import (
    FoundCycles,
    RejectedCycle,
    describe_cycles,
    find_pinches,
    find_walls,
    list_users,
    orient_cycles,
)
from patterndb_sketch.surfacing.cycles.measures import (
    REWARD,
    measure_cycles,
    price_folds,
    rate_badness,
)
from patterndb_sketch.surfacing.cycles.packing import SIDES, CycleProblem

#: Closing paths per pair of curves at a node.
CLOSINGS = 8

#: Of the candidates at a curve, this many of the least badness take part in the choice; a
#: candidate does if it is among them at one of its curves. With 10, equally good candidates of a
#: symmetric network may be left out for no reason.
RIVALS = 14

#: The worst badness of a cycle of an open surface. Higher finds more of the patches that are
#: meant, and more that are not.
WORST = 0.85

#: Where nothing so good is chosen among all the curves that hang together, cycles so many times
#: as bad are taken: each of the strips of a pipe that bend by 180 degrees has 0.9, a strip that is
#: closed but for one curve 1.4. In the sketches at hand it makes no difference.
ALONE = 2.5

#: The worst badness of a candidate at all: it may be needed to close a surface.
WORST_CLOSING = 4.0

#: A surface that has all curves in two cycles each is preferred to the best choice if its value
#: is at least this part of that one's. In most cages the best choice is closed already; in the
#: cage of spot the part is 0.998, and 0.970 in the one CASSIE sketch that comes this far.
CLOSED_SHARE = 0.98

#: It is looked for only if this part of the curves is in two cycles each already.
NEARLY_CLOSED = 0.9

#: Times that a choice that is no surface is made anew; then cycles are dropped. More find next
#: to nothing in the sketches at hand, and take as long again each.
MENDS = 2

#: A strip that turns over stays if none of its cycles is worse, or if every curve needs one as bad
#: to bound anything: it is meant, as a Moebius strip is.
TURNING_OVER = 0.6

#: The one cycle of a closed surface that is worse than those of open ones may be is their rim if it
#: bends by more than RIM_BENT, as flatness, and spans more than this part of what the others span:
#: a sheet with a wave or round a cylinder has such, a closed shape of many faces has not.
RIM_SHARE = 0.2
RIM_BENT = 0.1

#: A mend makes the choice anew for cycles up to so many cycles from what was wrong.
REACH = 1


@dataclass(slots=True)
class _NetworkPart:
    """Curves of a network that hang together, and what may be chosen there."""

    network: CurveNetwork
    curves: NDArray[np.int64]
    cycles: list[Cycle]
    bad: NDArray[np.float64]
    area: NDArray[np.float64]
    flatness: NDArray[np.float64]
    gains: NDArray[np.float64]
    costs: dict[tuple[int, int], float]
    forced: set[int]


def find_cycles(
    network: CurveNetwork,
    *,
    added: Sequence[Cycle] = (),
    banned: Sequence[Cycle] = (),
    closings: int = CLOSINGS,
    worst: float = WORST,
    effort: float = 2.0,
) -> FoundCycles:
    """The cycles of a network that bound patches of its surface, found from the curves alone.

    added, banned: cycles of the network that shall, or shall not, be among them. closings:
    closing paths per pair of curves at a node. worst: the worst badness (see cost.py) of a
    cycle of an open surface; higher finds more, and more that is not meant. effort: what the
    solver may spend on each choice, in its units of deterministic time, some seconds each.
    The cycles that the network came with are not looked at. The same curves give the same
    cycles, in whatever order and sense they come.

    A closed loop that no other curve touches is a cycle, however it bends. Each curve bounds two
    cycles at most, or more where a good one stands on them, as a wall on a sheet does
    (:mod:`.walls`). Where curves that hang together can all bound two each at little loss, they
    do: a closed surface. Elsewhere cycles worse than ``worst`` are left
    out unless they close a surface; curves of which none would bound anything then keep theirs up
    to ALONE times as bad.

    Raises InvalidNetworkError for added or banned cycles that :meth:`CurveNetwork.walk`
    refuses, for one that is both, and where a curve would bound more than two added ones.

    Abbasinejad et al. 2013 take cycles from their earlier "Surface patches from unorganized space
    curves" (2011). This is another way: candidates by closing paths, chosen by set packing.
    """
    if closings < 1:
        raise InvalidNetworkError(f"closings is {closings}; give 1 or more")
    _check(network, added, banned)
    if not network.curves:
        return FoundCycles(())
    own = order_chains(chain_curves(network, find_dangling(network)))
    gone = find_dangling(own.network)
    halves = list_half_curves(own.network, ~gone)
    found, cut_short = find_candidate_cycles(own.network, halves, closings)
    for cycle in map(own.here, added):
        found.setdefault(tuple(sorted(cycle.curves)), cycle)
    must = {tuple(sorted(own.here(cycle).curves)) for cycle in added}
    for cycle in map(own.here, banned):
        found.pop(tuple(sorted(cycle.curves)), None)
    must.update(loop for loop in find_lone_loops(own.network, ~gone) if loop in found)
    chosen: list[Cycle] = []
    walls: list[Cycle] = []
    proven = True
    parts = _parts(own.network, ~gone, found, must)
    for part in parts:
        numbers, sure = _chosen(part, worst, effort)
        chosen += _of(part, numbers)
        standing = find_walls(own.network, part.cycles, part.bad, part.costs, numbers)
        walls += _of(part, standing)
        proven &= sure
    turned = orient_cycles(_sort_there(own, chosen))
    missed = _find_nearest_miss(parts, [*chosen, *walls])
    return describe_cycles(
        network,
        FoundCycles(
            (*turned.cycles, *_sort_there(own, walls)),
            candidates=len(found),
            cut_short=cut_short,
            proven=proven,
            orientable=not turned.twisted,
            nearest_miss=(
                None if missed is None else RejectedCycle(own.there(missed[0]), missed[1], worst)
            ),
        ),
    )


def _sort_there(own: ChainedNetwork, cycles: Sequence[Cycle]) -> list[Cycle]:
    """List cycles as those of the network that came in, in its order."""
    return sorted(map(own.there, cycles), key=lambda cycle: cycle.key)


def _find_nearest_miss(
    parts: Sequence[_NetworkPart], chosen: Sequence[Cycle]
) -> tuple[Cycle, float] | None:
    """The least bad candidate all of whose curves bound no chosen cycle, with its badness."""
    used = set(list_users(chosen))
    misses = [
        (float(bad), cycle.key, cycle)
        for part in parts
        for cycle, bad in zip(part.cycles, part.bad, strict=True)
        if used.isdisjoint(cycle.curves)
    ]
    if not misses:
        return None
    bad, _, cycle = min(misses)
    return cycle, bad


def _check(network: CurveNetwork, added: Sequence[Cycle], banned: Sequence[Cycle]) -> None:
    for cycle in (*added, *banned):
        network.walk(cycle)
    refused = {cycle.key for cycle in banned}
    distinct = {cycle.key: cycle for cycle in added}
    for key, cycle in distinct.items():
        if key in refused:
            raise InvalidNetworkError(
                f"the cycle {network.names(cycle)} is both added and banned; leave one out"
            )
    for curve, walks in sorted(list_users(list(distinct.values())).items()):
        if len(walks) > SIDES:
            raise InvalidNetworkError(
                f"curve {network.curves[curve].id!r} (number {curve}) is in {len(walks)} added "
                f"cycles; at most {SIDES} can be added at a curve. Leave some out, or list all "
                "cycles of the network: those may be more"
            )


def _parts(
    network: CurveNetwork,
    alive: NDArray[np.bool_],
    found: dict[tuple[int, ...], Cycle],
    must: set[tuple[int, ...]],
) -> list[_NetworkPart]:
    """Candidates by the curves that hang together, those without prospects left out."""
    halves = list_half_curves(network, alive)
    keys = sorted(found)
    cycles = [found[key] for key in keys]
    measures = measure_cycles(network, halves, cycles)
    strokes = np.array([len({network.curves[c].stroke for c in key}) for key in keys], float)
    bad = rate_badness(measures, np.array([len(key) for key in keys], float), strokes)
    first = np.r_[0, np.cumsum([len(key) for key in keys])]
    length = np.array([curve.length for curve in network.curves])
    at: dict[int, list[int]] = {}
    for i, key in enumerate(keys):
        if bad[i] <= WORST_CLOSING:
            for curve in key:
                at.setdefault(curve, []).append(i)
    kept = {i for i, key in enumerate(keys) if key in must}
    for candidates in at.values():
        kept.update(sorted(candidates, key=lambda i: (bad[i], i))[:RIVALS])
    parts: list[_NetworkPart] = []
    for curves in group_components(network, alive):
        within = set(curves.tolist())
        numbers = sorted(i for i in kept if keys[i][0] in within)
        # Of curves so short that their squares are 0, none is longer than another.
        middle = float(np.median(length[curves]))
        relative = length / middle if middle > 0.0 else np.ones(len(length))
        limited = np.minimum(bad[numbers], WORST_CLOSING)
        size = np.array([relative[list(keys[i])].sum() for i in numbers])
        own = [cycles[i] for i in numbers]
        inward = [measures.inward[first[i] : first[i + 1]] for i in numbers]
        forced = {k for k, i in enumerate(numbers) if keys[i] in must}
        gains = size * (REWARD - limited)
        parts.append(
            _NetworkPart(
                network,
                curves,
                own,
                limited,
                measures.area[numbers],
                measures.flatness[numbers],
                gains,
                price_folds(own, inward, relative),
                forced,
            )
        )
    return parts


def _chosen(part: _NetworkPart, worst: float, effort: float) -> tuple[list[int], bool]:
    """The candidates chosen in a part of the network, and whether no better choice is left."""
    best = _surface(part, effort)
    if best is None:
        return sorted(part.forced), False
    twice = {c for c, walks in list_users(_of(part, best.chosen)).items() if len(walks) == SIDES}
    proven = best.proven
    if NEARLY_CLOSED * len(part.curves) <= len(twice) < len(part.curves):
        demand = _Demand(
            full=part.curves.tolist(),
            least=CLOSED_SHARE * best.value,
            fixed=_far_from(part, best, set(part.curves.tolist()) - twice),
        )
        whole = _surface(part, effort, demand)
        if whole is not None:
            best = whole
            proven = whole.proven
    if any(part.bad[i] > worst for i in best.chosen) and not _covers_all(part, best):
        every = _cover_all(part, worst, effort)
        if every is not None:
            best = every
            proven = False
    cycles = _of(part, best.chosen)
    turned = orient_cycles(cycles)
    at = list_users(cycles)
    is_open = {
        turned.surfaces[i]
        for i, cycle in enumerate(cycles)
        if any(len(at[curve]) < SIDES for curve in cycle.curves)
    }
    # A surface that turns over is never closed, unless it passes through itself.
    is_open |= {turned.surfaces[strip[0]] for strip in turned.twisted}
    is_open |= _find_closed_by_rims(part, best.chosen, turned.surfaces, worst)
    good = [
        number
        for surface, number in zip(turned.surfaces, best.chosen, strict=True)
        if number in part.forced or surface not in is_open or part.bad[number] <= worst
    ]
    if good:
        return good, proven
    return [number for number in best.chosen if part.bad[number] <= ALONE * worst], proven


def _covers_all(part: _NetworkPart, choice: CycleChoice) -> bool:
    """Does every curve of a part bound a cycle of the choice?"""
    return len(list_users(_of(part, choice.chosen))) == len(part.curves)


def _cover_all(part: _NetworkPart, worst: float, effort: float) -> CycleChoice | None:
    """A choice in which every curve bounds something, of cycles no worse than that needs.

    None if that takes cycles worse than those of open surfaces, or if it is not found. A Moebius
    strip is worth less than all but one of its cells and a disk or two in its rim, which leave
    the curve between two cells without any.
    """
    least = dict.fromkeys(part.curves.tolist(), np.inf)
    for cycle, bad in zip(part.cycles, part.bad.tolist(), strict=True):
        for curve in cycle.curves:
            least[curve] = min(least[curve], bad)
    needed = max(least.values())
    if needed > worst:
        return None
    barred = [i for i in np.flatnonzero(part.bad > needed).tolist() if i not in part.forced]
    choice = _surface(part, effort, _Demand(barred=barred, turning_over=needed))
    return choice if choice is not None and _covers_all(part, choice) else None


def _find_closed_by_rims(
    part: _NetworkPart, chosen: Sequence[int], surfaces: Sequence[int], worst: float
) -> set[int]:
    """The surfaces that are closed only by a cycle around all of the others, their rim."""
    area: dict[int, float] = {}
    bad: dict[int, list[int]] = {}
    for surface, number in zip(surfaces, chosen, strict=True):
        area[surface] = area.get(surface, 0.0) + float(part.area[number])
        if part.bad[number] > worst:
            bad.setdefault(surface, []).append(number)
    return {
        surface
        for surface, (one, *more) in bad.items()
        if not more
        and part.flatness[one] > RIM_BENT
        and part.area[one] > RIM_SHARE * (area[surface] - part.area[one])
    }


def _far_from(part: _NetworkPart, choice: CycleChoice, curves: set[int]) -> set[int]:
    """Chosen cycles that stay while others are looked for at some curves, in large parts only."""
    if not choice.by_windows:
        return set()
    near = {node for curve in curves for node in part.network.curves[curve].nodes}
    nodes = {i: set(part.network.walk(part.cycles[i])) for i in choice.chosen}
    for _ in range(REACH):
        near |= set[int]().union(*(at for at in nodes.values() if at & near))
    return {i for i, at in nodes.items() if not at & near}


def _of(part: _NetworkPart, numbers: Sequence[int]) -> list[Cycle]:
    return [part.cycles[i] for i in numbers]


@dataclass(frozen=True, slots=True)
class _Demand:
    """What a choice must and must not have.

    full:   curves that must be in two cycles each. least: the least value that is good enough.
    fixed, barred: candidates that are chosen, or not.
    turning_over: the worst badness of cycles of a strip that turns over.
    """

    full: Sequence[int] = ()
    least: float | None = None
    fixed: Collection[int] = ()
    barred: Sequence[int] = ()
    turning_over: float = TURNING_OVER


def _surface(
    part: _NetworkPart, effort: float, demand: _Demand | None = None
) -> CycleChoice | None:
    """Make the best choice on demand, and mend it until it is a surface without a pinch.

    Each choice that is no surface bars what is wrong with it, and the next is made with what is
    near; after MENDS of them cycles are dropped instead. What comes from added cycles alone
    stays.
    """
    demand = _Demand() if demand is None else demand
    curves = [cycle.curves for cycle in part.cycles]
    nodes = [set(part.network.walk(cycle)) for cycle in part.cycles]
    excluded: list[tuple[int, ...]] = [(i,) for i in demand.barred]
    forced = part.forced.union(demand.fixed)
    gains = part.gains.tolist()
    near: set[int] = set()
    mends = 0
    prove = False
    while True:
        problem = CycleProblem(
            curves,
            gains,
            part.costs,
            forced=forced,
            excluded=excluded,
            full=demand.full,
            least=demand.least,
        )
        choice = choose_cycles(problem, effort, prove)
        if choice is None:
            return None
        wrong = _wrong(part, choice.chosen, demand.turning_over)
        if not wrong and not (prove or mends or choice.proven or choice.by_windows):
            prove = True  # only what is a surface as it stands is called proven
            continue
        if not wrong:
            return replace(choice, proven=choice.proven and not mends)
        if mends == MENDS:
            return None if demand.full else _dropped(part, choice, demand.turning_over)
        mends += 1
        prove = False
        for group, node in wrong:
            if node is None:
                excluded.append(group)
            else:
                passing = [i for i, at in enumerate(nodes) if node in at and i not in group]
                excluded += [(*group, i) for i in passing]
            near |= set[int]().union(*(nodes[i] for i in group))
        for _ in range(REACH):
            near |= set[int]().union(*(nodes[i] for i in choice.chosen if nodes[i] & near))
        forced = part.forced | {i for i in choice.chosen if not nodes[i] & near}


def _wrong(
    part: _NetworkPart, chosen: Sequence[int], turning_over: float
) -> list[tuple[tuple[int, ...], int | None]]:
    """Sets of chosen candidates that make no surface: strips that turn over, with None, and
    rings around a node, with the node that other cycles pass too."""
    cycles = [part.cycles[i] for i in chosen]
    strips = [tuple(chosen[i] for i in strip) for strip in orient_cycles(cycles).twisted]
    found: list[tuple[tuple[int, ...], int | None]] = [
        (strip, None) for strip in strips if max(part.bad[i] for i in strip) > turning_over
    ]
    found += [
        (tuple(chosen[i] for i in ring), node) for node, ring in find_pinches(part.network, cycles)
    ]
    return [(group, node) for group, node in found if not part.forced.issuperset(group)]


def _dropped(part: _NetworkPart, choice: CycleChoice, turning_over: float) -> CycleChoice:
    """The choice without the worst cycle of everything that is wrong with it."""
    chosen = list(choice.chosen)
    while wrong := _wrong(part, chosen, turning_over):
        group, _ = wrong[0]
        worst = max(set(group) - part.forced, key=lambda i: (part.bad[i], i))
        chosen.remove(worst)
    return replace(choice, chosen=tuple(chosen), proven=False)
