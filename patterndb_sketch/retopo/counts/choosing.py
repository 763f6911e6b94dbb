"""Choose counts for a whole network, better ones as long as one likes, and after a changed one.

Differs from the paper (Takayama et al. 2013, section 5.1): there the two sides of a chain share a
count, and it is the user who brings the patches' counts together. Here they are chosen over the
whole network, and no patch is odd but where pinned counts leave no other way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts.balls import grow_ball, list_neighbours, solve_ball
from patterndb_sketch.retopo.counts.evening import (
    Stuck,
    even_along_strips,
    even_by_fewest_changes,
    even_by_least_errors,
    label_strips,
)
from patterndb_sketch.retopo.counts.problem import MOST_COUNT, CountsProblem
from patterndb_sketch.retopo.counts.rules import find_irregular_patches, find_misjudged_patches
from patterndb_sketch.retopo.counts.walks import Descent
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: Patches of a ball, and how many of them, about its middle, need not be the middle of another.
BALL = 24
INNER = 6

#: Balls that :func:`solve_counts` solves: about a second on 200 patches.
MOST_BALLS = 8

#: Work on one ball, in the solver's deterministic seconds; most need a tenth.
BALL_WORK = 0.1

#: Patches about a changed count in which others may change, and what every changed chain costs.
NEAR = 24
CHANGE = 2.0

#: Chains that may change with one, itself included; evenness alone may ask for more.
MOST_CHANGED = 5


@dataclass(frozen=True, slots=True, eq=False)
class Counts:
    """Counts of all chains.

    counts:    (c,) int32 >= 1.
    cost:      the sum of the chains' weighted errors.
    irregular: (i,) int32, the patches without a regular fill.
    total:     cost + the problem's regularity for each of these.
    bound:     no even counts have a lower total; 0 where that was not asked about.
    stuck:     patches that are odd or too small because of pinned counts: tell the user.
    n_balls:   balls solved, of which n_proven to the proven optimum.
    finished:  no walk and no ball gains anything any more.
    unasked:   patches with too many side lengths for the caller's rule to be asked in a ball.
    narrowly:  of the irregular ones those with 7 or 8 sides that have a regular fill after all, of
               a kind that the search does not look for; see
              :func:`~.rules.find_misjudged_patches`.
    """

    counts: Int32Array
    cost: float
    irregular: Int32Array
    total: float
    bound: float
    stuck: tuple[Stuck, ...]
    n_balls: int = 0
    n_proven: int = 0
    finished: bool = False
    unasked: tuple[int, ...] = ()
    narrowly: tuple[int, ...] = ()


def solve_counts(problem: CountsProblem, n_balls: int = MOST_BALLS) -> Counts:
    """Solve a problem: counts near the targets, every patch even, and as many regular ones as pay.

    Two starts, the least errors of all even counts and those along strips, are each improved by
    walks; the better is improved further in n_balls balls. The same problem gives the same counts,
    however many threads there are and however fast they are.
    """
    least = even_by_least_errors(problem)
    found: list[Counts] = []
    for start in (least, even_along_strips(problem, label_strips(problem))):
        descent = Descent(problem, start.counts)
        descent.run()
        found.append(replace(_summarise(problem, descent.counts, start.stuck), bound=least.bound))
    # The first of equals.
    best = min(found, key=lambda counts: counts.total)
    for better in islice(improve_counts(problem, best), n_balls):
        best = better
    return _note_misjudged(problem, best)


def improve_counts(problem: CountsProblem, counts: Counts) -> Iterator[Counts]:
    """Improve counts step by step, at least as good as given ones, until nothing more is found.

    After every ball what there is; stop when you like. The last is ``finished``.
    """
    if not problem.n_patches:
        yield replace(counts, finished=True)
        return
    descent = Descent(problem, counts.counts)
    descent.run()
    best = _carry_over(counts, problem, descent.counts)
    near = list_neighbours(problem)
    seeds = _order_seeds(near, best.irregular)
    vain = at = 0
    while vain < len(seeds):
        patches = grow_ball(near, seeds[at % len(seeds)], BALL)
        at += 1
        solved = solve_ball(problem, best.counts, patches, BALL_WORK)
        descent.reset(solved.counts)
        if np.any(solved.counts != best.counts):
            descent.run()
        made = _carry_over(best, problem, descent.counts)
        better = made.total < best.total - 1e-6
        vain = 0 if better else vain + 1
        best = replace(
            made if better else best,
            n_balls=best.n_balls + 1,
            n_proven=best.n_proven + (solved.gap == 0),
            finished=vain == len(seeds),
            unasked=tuple(sorted({*best.unasked, *solved.unasked})),
        )
        if not better:
            descent.reset(best.counts)
        yield best


def change_count(problem: CountsProblem, counts: ArrayLike, chain: int, count: int) -> Counts:
    """Change one count as the user asks: as few others as can be with it, all patches even.

    counts: (c,) of all chains before. The chain is pinned to the new count, and remains so with
    ``problem.with_pinned(chain, count)``. Then walks in the NEAR patches around it improve what
    they can, every changed chain costing CHANGE, where MOST_CHANGED chains or fewer will do; else
    there are as few as can be. :func:`improve_change` may find better counts, in more time.
    Raises InvalidRetopoError for a chain that does not exist, a count below 1 and counts that are
    not one a chain.
    """
    former = _check_counts(problem, counts)
    if count < 1:
        raise InvalidRetopoError(f"chain {chain} cannot have {count} edges; the least is 1")
    pinned = problem.with_pinned(chain, count)
    evened = even_by_fewest_changes(pinned, former)
    patches = _find_patches_around(pinned, chain)
    descent = Descent(pinned, evened.counts, former, CHANGE, patches)
    descent.run(_list_chains(pinned, patches))
    fewest = int((evened.counts != former).sum())
    few = int((descent.counts != former).sum()) <= max(MOST_CHANGED, fewest)
    made = _summarise(pinned, descent.counts if few else evened.counts, evened.stuck)
    return _note_misjudged(pinned, made)


def improve_change(problem: CountsProblem, former: ArrayLike, counts: Counts, chain: int) -> Counts:
    """Improve what :func:`change_count` came to by one ball around the chain.

    problem: with the chain pinned. former: the counts before the change, to which others cost
    CHANGE. Takes up to half a second: made for the background. Never worse.
    """
    before = _check_counts(problem, former)
    patches = _find_patches_around(problem, chain)
    if not patches:
        return counts
    solved = solve_ball(problem, counts.counts, patches, BALL_WORK, before, CHANGE)
    made = replace(
        _summarise(problem, solved.counts, counts.stuck),
        n_balls=1,
        n_proven=int(solved.gap == 0),
        unasked=solved.unasked,
    )

    def price(one: Counts) -> float:
        return one.total + CHANGE * int((one.counts != before).sum())

    few = max(MOST_CHANGED, int((counts.counts != before).sum()))
    if int((made.counts != before).sum()) > few or price(made) >= price(counts):
        return counts
    return _note_misjudged(problem, made)


def _check_counts(problem: CountsProblem, counts: ArrayLike) -> Int32Array:
    given = np.array(counts)
    if given.shape != (problem.n_chains,) or not np.all((given >= 1) & (given <= MOST_COUNT)):
        raise InvalidRetopoError(
            f"counts must be one whole number of 1 to {MOST_COUNT} for each of the "
            f"{problem.n_chains} chains; choose them first"
        )
    return given.astype(np.int32)


def _summarise(problem: CountsProblem, counts: Int32Array, stuck: tuple[Stuck, ...]) -> Counts:
    cost = float(problem.errors(counts).sum())
    irregular = np.flatnonzero(find_irregular_patches(problem, counts)).astype(np.int32)
    total = cost + problem.regularity * len(irregular)
    return Counts(counts.copy(), cost, irregular, total, 0.0, stuck)


def _note_misjudged(problem: CountsProblem, counts: Counts) -> Counts:
    return replace(counts, narrowly=find_misjudged_patches(problem, counts.counts))


def _carry_over(former: Counts, problem: CountsProblem, counts: Int32Array) -> Counts:
    """Carry all else that is known of former counts over to others."""
    made = _summarise(problem, counts, former.stuck)
    return replace(
        made,
        bound=former.bound,
        n_balls=former.n_balls,
        n_proven=former.n_proven,
        unasked=former.unasked,
    )


def _order_seeds(near: list[Int32Array], irregular: Int32Array) -> list[int]:
    """List the middles of balls in order: irregular patches first, as there is more to gain.

    None is among the INNER patches of a ball before, and every patch is among those of one.
    """
    seen = np.zeros(len(near), np.bool_)
    found: list[int] = []
    for patch in [*irregular.tolist(), *range(len(near))]:
        if not seen[patch]:
            found.append(patch)
            seen[grow_ball(near, patch, INNER)] = True
    return found


def _find_patches_around(problem: CountsProblem, chain: int) -> list[int]:
    """Find the NEAR patches around a chain, those beside it first."""
    beside = [int(f) for f in dict.fromkeys(problem.ends[chain].tolist()) if f < problem.n_patches]
    if not beside:
        return []
    near = list_neighbours(problem)
    found = dict.fromkeys(beside)
    halves = [grow_ball(near, f, NEAR) for f in beside]
    for patches in zip(*halves, strict=False):
        found.update(dict.fromkeys(patches))
    return list(found)[:NEAR]


def _list_chains(problem: CountsProblem, patches: list[int]) -> Int32Array:
    if not patches:
        return np.zeros(0, np.int32)
    return np.unique(np.concatenate([problem.patch_chains(f) for f in patches]))
