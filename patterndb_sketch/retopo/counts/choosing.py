"""Choose counts for a whole network, and after one that the user changed.

Differs from the paper (Takayama et al. 2013, section 5.1): there the two sides of a chain share a
count, and it is the user who brings the patches' counts together. Here they are chosen over the
whole network, and no patch is odd but where pinned counts leave no other way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts.cycles import CycleSearch
from patterndb_sketch.retopo.counts.neighbourhoods import (
    grow_neighbourhood,
    list_neighbours,
    solve_neighbourhood,
)
from patterndb_sketch.retopo.counts.parity import (
    Stuck,
    even_along_strips,
    even_by_fewest_changes,
    even_by_least_errors,
    label_strips,
)
from patterndb_sketch.retopo.counts.problem import MOST_COUNT, CountsProblem
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: Patches of a neighbourhood, and how many of them, about its middle, need not be the middle of
#: another.
SIZE, INNER = 24, 6

#: Neighbourhoods that :func:`solve_counts` solves: about a second on 200 patches.
MOST_NEIGHBOURHOODS = 8

#: Work on one neighbourhood, in the solver's deterministic seconds; most need a tenth.
WORK = 0.1

#: Patches about a changed count in which others may change, and what every changed chain costs.
NEAR = 24
CHANGE = 2.0

#: Chains that may change with one, itself included; evenness alone may ask for more.
MOST_CHANGED = 5

#: A neighbourhood is better only by more than this: less is rounding.
GAIN = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Counts:
    """Counts of all chains.

    counts:    (c,) int32 >= 1.
    cost:      the sum of the chains' weighted errors.
    irregular: (i,) int32, the patches without a regular fill.
    total:     cost + the problem's regularity for each of these.
    bound:     no even counts have a lower total; 0 where that was not asked about.
    stuck:     patches that are odd or too small because of pinned counts: report them.
    finished:  no cycle and no neighbourhood gains anything any more.
    """

    counts: Int32Array
    cost: float
    irregular: Int32Array
    total: float
    bound: float
    stuck: tuple[Stuck, ...]
    finished: bool = False

    @classmethod
    def of(
        cls,
        problem: CountsProblem,
        counts: Int32Array,
        stuck: tuple[Stuck, ...],
        bound: float = 0.0,
    ) -> Counts:
        """Measure counts (c,) of a problem."""
        cost = float(problem.errors(counts).sum())
        irregular = np.flatnonzero(problem.find_irregular_patches(counts)).astype(np.int32)
        total = cost + problem.regularity * len(irregular)
        return cls(counts.copy(), cost, irregular, total, bound, stuck)


def solve_counts(problem: CountsProblem, searches: int = MOST_NEIGHBOURHOODS) -> Counts:
    """Solve a problem: counts near the targets, every patch even, and as many regular ones as pay.

    Two starts, the least errors of all even counts and those along strips, are each improved by
    cycles; the better is improved further in as many neighbourhoods as ``searches`` at most. The
    same problem gives the same counts, however many threads there are and however fast they are.
    """
    least = even_by_least_errors(problem)
    found: list[Counts] = []
    for start in (least, even_along_strips(problem, label_strips(problem))):
        search = CycleSearch(problem, start.counts)
        search.run()
        found.append(Counts.of(problem, search.counts, start.stuck, least.bound))
    # The first of equals.
    best = min(found, key=lambda counts: counts.total)
    return _search_neighbourhoods(problem, best, searches) if searches else best


def _search_neighbourhoods(problem: CountsProblem, best: Counts, most: int) -> Counts:
    """Improve counts in one neighbourhood after another, until none gains or so many are solved."""
    if not problem.n_patches:
        return replace(best, finished=True)
    search = CycleSearch(problem, best.counts)
    search.run()
    best = Counts.of(problem, search.counts, best.stuck, best.bound)
    near = list_neighbours(problem)
    seeds = _order_seeds(near, best.irregular)
    vain = at = 0
    while vain < len(seeds) and at < most:
        patches = grow_neighbourhood(near, seeds[at % len(seeds)], SIZE)
        at += 1
        solved = solve_neighbourhood(problem, best.counts, patches, WORK)
        search.reset(solved)
        if np.any(solved != best.counts):
            search.run()
        made = Counts.of(problem, search.counts, best.stuck, best.bound)
        if made.total < best.total - GAIN:
            best, vain = made, 0
        else:
            search.reset(best.counts)
            vain += 1
    return replace(best, finished=vain == len(seeds))


def change_count(problem: CountsProblem, counts: ArrayLike, chain: int, count: int) -> Counts:
    """Change one count as the user asks: as few others as can be with it, all patches even.

    counts: (c,) of all chains before. The chain is pinned to the new count, and remains so with
    ``problem.with_pinned(chain, count)``. Then cycles in the NEAR patches around it improve what
    they can, every changed chain costing CHANGE, where MOST_CHANGED chains or fewer will do; else
    there are as few as can be. Raises InvalidRetopoError for a chain that does not exist, a count
    below 1 and counts that are not one a chain.
    """
    former = _check_counts(problem, counts)
    if count < 1:
        raise InvalidRetopoError(f"chain {chain} cannot have {count} edges; the least is 1")
    pinned = problem.with_pinned(chain, count)
    evened = even_by_fewest_changes(pinned, former)
    patches = _find_patches_around(pinned, chain)
    search = CycleSearch(pinned, evened.counts, former, CHANGE, patches)
    search.run(_list_chains(pinned, patches))
    fewest = int((evened.counts != former).sum())
    few = int((search.counts != former).sum()) <= max(MOST_CHANGED, fewest)
    return Counts.of(pinned, search.counts if few else evened.counts, evened.stuck)


def _check_counts(problem: CountsProblem, counts: ArrayLike) -> Int32Array:
    given = np.array(counts)
    if given.shape != (problem.n_chains,) or not np.all((given >= 1) & (given <= MOST_COUNT)):
        raise InvalidRetopoError(
            f"counts must be one whole number of 1 to {MOST_COUNT} for each of the "
            f"{problem.n_chains} chains; choose them first"
        )
    return given.astype(np.int32)


def _order_seeds(near: list[Int32Array], irregular: Int32Array) -> list[int]:
    """List the middles of neighbourhoods in order: irregular patches first, with more to gain.

    None is among the INNER patches of one before, and every patch is among those of one.
    """
    seen = np.zeros(len(near), np.bool_)
    found: list[int] = []
    for patch in [*irregular.tolist(), *range(len(near))]:
        if not seen[patch]:
            found.append(patch)
            seen[grow_neighbourhood(near, patch, INNER)] = True
    return found


def _find_patches_around(problem: CountsProblem, chain: int) -> list[int]:
    """Find the NEAR patches around a chain, those beside it first."""
    beside = [int(f) for f in dict.fromkeys(problem.ends[chain].tolist()) if f < problem.n_patches]
    if not beside:
        return []
    near = list_neighbours(problem)
    found = dict.fromkeys(beside)
    halves = [grow_neighbourhood(near, f, NEAR) for f in beside]
    for patches in zip(*halves, strict=False):
        found.update(dict.fromkeys(patches))
    return list(found)[:NEAR]


def _list_chains(problem: CountsProblem, patches: list[int]) -> Int32Array:
    if not patches:
        return np.zeros(0, np.int32)
    return np.unique(np.concatenate([problem.patch_chains(f) for f in patches]))
