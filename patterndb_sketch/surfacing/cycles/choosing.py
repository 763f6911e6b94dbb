"""Choosing among candidate cycles: as a whole, or window by window where they are many.

Up to MOST_AT_ONCE candidates are chosen from exactly (:mod:`.packing`). Of more, what is fixed
is taken out first; the rest falls into groups that have nothing to do with each other. In each a
greedy choice is compared, curve by curve, with the best that any choice could have there. Where
it is that good it is sure, and nothing needs to be solved; elsewhere windows are, one after
another.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb_sketch.surfacing.cycles.packing import SIDES, UNIT, CycleProblem, solve_packing

#: Up to so many candidates are solved as a whole. The sketches and cages at hand have fewer (the
#: most, the penguin's cage, 1,366); the solver's time grows faster than their number.
MOST_AT_ONCE = 1_500

#: Candidates of a window, and how many of them, those nearest to where it begins, need no other
#: window: the others see only a part of what they contend with.
WINDOW = 900
CORE = 600

#: What the solver may spend on a window, as a part of the effort for a whole.
WINDOW_EFFORT = 0.1

#: Windows per CORE candidates, at most: a window that changes something makes its surroundings
#: worth another look.
MOST_LOOKS = 2


@dataclass(frozen=True, slots=True)
class CycleChoice:
    """What was chosen.

    chosen: numbers of the candidates, ascending. value: their gains less the costs of pairs.
    proven: is there surely nothing better, to UNIT? by_windows: was the whole too much at once?
    """

    chosen: tuple[int, ...]
    value: float
    proven: bool
    by_windows: bool = False


def choose_cycles(
    problem: CycleProblem, effort: float = 2.0, prove: bool = True
) -> CycleChoice | None:
    """Choose the candidates of the greatest value such that no curve is in more than fit there.

    effort: in CP-SAT's units of deterministic time, some seconds each; the result depends on no
    clock. prove: is it worth an effort to know that nothing is better?

    More than MOST_AT_ONCE candidates, and those for which the effort finds nothing, are chosen
    greedily and improved by windows. Returns None if nothing fits; where there are curves that must
    be full, or a least value, also if nothing was found.
    """
    curves, full = problem.curves, set(problem.full)
    if not full <= {c for of_one in curves for c in of_one}:
        return None
    if len(curves) <= MOST_AT_ONCE:
        solved = solve_packing(problem, effort, prove)
        if solved is not None:
            return CycleChoice(solved[0], problem.weigh(solved[0]), solved[1])
        if full or problem.least is not None:
            return None
    contest = _open_contest(problem)
    if contest is None:
        return None
    chosen = set(problem.forced)
    proven = True
    for part in _part_contest(contest):
        if full:
            found = _solve_part(contest, part, effort) if len(part) <= MOST_AT_ONCE else None
        else:
            found = _choose_by_windows(contest, part, WINDOW_EFFORT * effort)
        if found is None:
            return None
        chosen |= found[0]
        proven &= found[1]
    value = problem.weigh(chosen)
    if problem.least is not None and value < problem.least - UNIT:
        return None
    return CycleChoice(tuple(sorted(chosen)), value, proven, True)


@dataclass(frozen=True, slots=True)
class _Contest:
    """Candidates that may be chosen besides those that are, and what they mean to one another.

    usable: their numbers, ascending. curves, gains: of every candidate, gains less what it costs
    beside those that are chosen. room: in how many more a curve may be. costs: for every candidate
    those of pairs with others. groups: for every candidate the sets with it that must not all be
    chosen. at: for every curve the usable candidates there. whole: curves that must have no
    room left.
    """

    usable: Sequence[int]
    curves: Sequence[Sequence[int]] = field(repr=False)
    gains: Sequence[float] = field(repr=False)
    room: Mapping[int, int] = field(repr=False)
    costs: Sequence[Mapping[int, float]] = field(repr=False)
    groups: Mapping[int, Sequence[tuple[int, ...]]] = field(repr=False)
    at: Mapping[int, Sequence[int]] = field(repr=False)
    whole: Collection[int] = field(repr=False)


def _open_contest(problem: CycleProblem) -> _Contest | None:
    """Return the choice that remains when some candidates are chosen; None if nothing can fit."""
    curves, must, full = problem.curves, set(problem.forced), set(problem.full)
    room = {c: problem.find_room(c) for of_one in curves for c in of_one}
    for i in must:
        for curve in curves[i]:
            room[curve] -= 1
    own = list(problem.gains)
    for (i, j), cost in problem.costs.items():
        if i in must and j not in must:
            own[j] -= cost
        elif j in must and i not in must:
            own[i] -= cost
    left = [tuple(sorted(set(group) - must)) for group in problem.excluded]
    if min(room.values(), default=0) < 0 or not all(left):
        return None
    barred = must | {group[0] for group in left if len(group) == 1}
    usable = [
        i
        for i, of_one in enumerate(curves)
        if i not in barred and (full or own[i] > 0.0) and all(room[curve] > 0 for curve in of_one)
    ]
    alive = set(usable)
    between: list[dict[int, float]] = [{} for _ in curves]
    for (i, j), cost in problem.costs.items():
        if cost > 0.0 and i in alive and j in alive:
            between[i][j] = between[j][i] = cost
    groups: dict[int, list[tuple[int, ...]]] = {}
    for group in left:
        if alive.issuperset(group):
            for i in group:
                groups.setdefault(i, []).append(group)
    at: dict[int, list[int]] = {}
    for i in usable:
        for curve in curves[i]:
            at.setdefault(curve, []).append(i)
    whole = {curve for curve in full if room[curve]}
    if any(len(at.get(curve, ())) < room[curve] for curve in whole):
        return None
    return _Contest(usable, curves, own, room, between, groups, at, whole)


def _part_contest(contest: _Contest) -> list[list[int]]:
    """The usable candidates in groups that have no curves, costs or bars in common."""
    n = len(contest.curves)
    one: list[int] = []
    other: list[int] = []
    for candidates in contest.at.values():
        one += candidates[:-1]
        other += candidates[1:]
    for i in contest.usable:
        one += [i] * len(contest.costs[i])
        other += contest.costs[i]
        for group in contest.groups.get(i, ()):
            one += [i] * len(group)
            other += group
    links = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(n, n))
    _, label = connected_components(links, directed=False)
    parts: dict[int, list[int]] = {}
    for i in contest.usable:
        parts.setdefault(int(label[i]), []).append(i)
    return list(parts.values())


def _solve_part(
    contest: _Contest, part: Sequence[int], effort: float, fixed: Collection[int] = ()
) -> tuple[set[int], bool] | None:
    """Choose among some candidates exactly, while of the others those ``fixed`` are chosen."""
    place = {i: k for k, i in enumerate(part)}
    room = {curve: contest.room[curve] for i in part for curve in contest.curves[i]}
    for curve in room:
        room[curve] -= sum(j in fixed for j in contest.at[curve])
    groups = {group for i in part for group in contest.groups.get(i, ())}
    problem = CycleProblem(
        [contest.curves[i] for i in part],
        [_gain_beside(contest, i, fixed) for i in part],
        {
            (place[i], place[j]): cost
            for i in part
            for j, cost in contest.costs[i].items()
            if i < j and j in place
        },
        room,
        excluded=[
            [place[i] for i in group if i in place]
            for group in sorted(groups)
            if all(i in place or i in fixed for i in group)
        ],
        full=[curve for curve in contest.whole if curve in room],
    )
    solved = solve_packing(problem, effort, prove=False)
    return None if solved is None else ({part[k] for k in solved[0]}, solved[1])


def _gain_beside(contest: _Contest, candidate: int, chosen: Collection[int]) -> float:
    """What a candidate gains beside others that are chosen."""
    paid = sum(cost for j, cost in contest.costs[candidate].items() if j in chosen)
    return contest.gains[candidate] - paid


def _choose_greedily(contest: _Contest, part: Sequence[int]) -> set[int]:
    """Take candidates wherever they fit and gain something, first those with most per curve."""
    room = dict(contest.room)
    chosen: set[int] = set()
    for i in sorted(part, key=lambda i: (-contest.gains[i] / len(contest.curves[i]), i)):
        if _gain_beside(contest, i, chosen) <= 0.0:
            continue
        if not all(room[curve] for curve in contest.curves[i]):
            continue
        if any(chosen.issuperset(set(group) - {i}) for group in contest.groups.get(i, ())):
            continue
        chosen.add(i)
        for curve in contest.curves[i]:
            room[curve] -= 1
    return chosen


def _find_slack(contest: _Contest, part: Sequence[int], chosen: set[int]) -> set[int]:
    """The curves at which some choice of candidates may be worth more than this one is.

    The gain of a candidate is laid on its curves in shares, and the cost of a pair on the curves
    that they have in common. What any choice is worth is then a sum over curves, at each of which
    it can be no more than that of the best one or two candidates there. So a choice that is as
    good as that everywhere is the best of all. That holds for any shares: where those of a
    candidate that was not chosen are too much at one curve, the excess goes to its others as far
    as these can take it.
    """
    share = {i: dict.fromkeys(contest.curves[i], 0.0) for i in part}
    for i in part:
        for curve in share[i]:
            share[i][curve] = contest.gains[i] / len(share[i])

    def cost(i: int, j: int) -> float:
        whole = contest.costs[i].get(j, 0.0)
        return whole / max(1, len(share[i].keys() & share[j].keys())) if whole else 0.0

    def value(curve: int) -> float:
        mine = [i for i in contest.at[curve] if i in chosen]
        return sum(share[i][curve] for i in mine) - (cost(*mine) if len(mine) == SIDES else 0.0)

    have = {c: value(c) + UNIT / SIDES for c in {c for i in part for c in share[i]}}

    def margin(i: int, curve: int) -> float:
        best = share[i][curve]
        if contest.room[curve] == SIDES:
            others = (share[j][curve] - cost(i, j) for j in contest.at[curve] if j != i)
            best += max(0.0, max(others, default=0.0))
        return have[curve] - best

    slack: set[int] = set()
    for i in chosen:  # a cost that is laid on no curve
        if any(j in chosen and share[i].keys().isdisjoint(share[j]) for j in contest.costs[i]):
            slack.update(share[i])
    for curve in sorted(have):
        for i in sorted(contest.at[curve], key=lambda i: (share[i][curve], i)):
            if i in chosen:
                if share[i][curve] > have[curve]:  # better alone than with the other
                    slack.add(curve)
                continue
            if (need := -margin(i, curve)) <= 0.0:
                continue
            for other in share[i]:
                give = min(need, margin(i, other)) if other != curve else 0.0
                if give > 0.0:
                    share[i][curve] -= give
                    share[i][other] += give
                    need -= give
            if need > UNIT / SIDES:
                slack.add(curve)
    return slack


def _choose_by_windows(
    contest: _Contest, part: Sequence[int], effort: float
) -> tuple[set[int], bool]:
    """Choose greedily, then solve windows where that might not be the best, all else being fixed.

    Returns the choice, and whether it is surely the best.
    """
    chosen = _choose_greedily(contest, part)
    slack = _find_slack(contest, part, chosen)
    waiting = deque(sorted({i for curve in slack for i in contest.at[curve]}))
    done: set[int] = set()
    looks = 0
    while waiting and looks < MOST_LOOKS * (1 + len(part) // CORE):
        first = waiting.popleft()
        if first in done:
            continue
        window = _gather_window(contest, first)
        done.update(window[:CORE])
        looks += 1
        before = chosen.intersection(window)
        fixed = chosen - before
        solved = _solve_part(contest, sorted(window), effort, fixed)
        if solved is None:
            continue
        after = solved[0]
        if _weigh(contest, after, fixed) <= _weigh(contest, before, fixed) + UNIT:
            continue
        chosen = fixed | after
        # Who contends with what has changed is looked at again: it was judged beside the old.
        stale = {j for i in before ^ after for j in _list_contenders(contest, i)}
        again = sorted((stale & done).difference(window[:CORE]))
        done.difference_update(again)
        waiting.extend(again)
    return chosen, not slack


def _weigh(contest: _Contest, some: Collection[int], fixed: Collection[int]) -> float:
    """What candidates are worth together, beside others that are fixed."""
    within = sum(c for i in some for j, c in contest.costs[i].items() if j in some)
    return sum(_gain_beside(contest, i, fixed) for i in some) - 0.5 * within


def _list_contenders(contest: _Contest, candidate: int) -> Iterable[int]:
    """The candidates that a candidate has costs with, and those at its curves; some twice."""
    yield from contest.costs[candidate]
    for curve in contest.curves[candidate]:
        yield from contest.at[curve]


def _gather_window(contest: _Contest, first: int) -> list[int]:
    """Up to WINDOW candidates around one, the nearest first."""
    window = [first]
    seen = {first}
    for i in window:  # grows as it is walked through: breadth first
        for j in _list_contenders(contest, i):
            if j not in seen:
                if len(window) == WINDOW:
                    return window
                seen.add(j)
                window.append(j)
    return window
