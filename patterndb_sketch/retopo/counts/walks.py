"""Walks: closed ways across chains, each of them one edge more or fewer, that make counts better.

Whoever goes through a patch changes two of its chains by 1, so that it stays even. A walk is
closed, or comes from outside and goes back there. It visits no patch twice, so that what it gains
is the sum over its steps, and it is found as a shortest path of negative length. Of a cyclic
sequence with a negative sum some rotation has negative sums from its beginning to every place (Lin
and Kernighan 1973, the gain criterion): ways that have cost something are given up at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.counts.walks import find_walk, judge_patches
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb_sketch.retopo.counts.problem import MIN_PERIMETER, CountsProblem

Int8Array = NDArray[np.int8]

#: What a patch is after a change.
CHEAP, IRREGULAR, FORBIDDEN = 0, 1, 2

#: Patches that a walk may visit: half the gain of longer ones is had by shorter ones in a tenth
#: of the time (200 to 1000 patches), and beyond the last hardly any is left.
MOST_STEPS = (6, 12, 24)


class WalkGraph(NamedTuple):
    """What walks are searched in: *halves* are occurrences of chains in patches, two of a chain
    between patches and one of a chain at the rim.

    chain, patch, side: (k,) int32 of every half; place: (k,) its number within the patch.
    twin: (k,) the half on the other side of the chain, -1 where that is outside.
    first_half: (p + 1,) int32; first_side: (p + 1,) int32 as in the problem.
    first_after: (p + 1,) int64; after: int8, for every patch of d halves a (2 d, 2 d) table of what
        it is if a half gets one edge more (2 place + 1) or fewer (2 place) and another too; one
        half twice is a change by 2.
    state: (p,) int8 what every patch is now.
    step:  (c, 4) float64: what a chain's change by -2, -1, 1, 2 costs, inf where it may not.
    """

    chain: Int32Array
    patch: Int32Array
    side: Int32Array
    place: Int32Array
    twin: Int32Array
    first_half: Int32Array
    first_side: Int32Array
    first_after: NDArray[np.int64]
    after: Int8Array
    state: Int8Array
    step: Floats


def make_walk_graph(problem: CountsProblem) -> WalkGraph:
    """Name the halves of a problem; tables and costs are still to be filled in."""
    n_halves = len(problem.chains)
    side = np.repeat(np.arange(len(problem.first_chain) - 1), np.diff(problem.first_chain))
    patch_of_side = np.repeat(np.arange(problem.n_patches), np.diff(problem.first_side))
    patch = patch_of_side[side] if n_halves else np.zeros(0, np.int64)
    first_half = problem.first_chain[problem.first_side].astype(np.int32)
    twin = np.full(n_halves, -1, np.int32)
    order = np.argsort(problem.chains, kind="stable")
    same = np.flatnonzero(problem.chains[order][1:] == problem.chains[order][:-1])
    twin[order[same]] = order[same + 1]
    twin[order[same + 1]] = order[same]
    size = (2 * np.diff(first_half).astype(np.int64)) ** 2
    first_after = np.concatenate([[0], np.cumsum(size)]).astype(np.int64)
    return WalkGraph(
        problem.chains,
        patch.astype(np.int32),
        side.astype(np.int32),
        (np.arange(n_halves) - first_half[patch]).astype(np.int32),
        twin,
        first_half,
        problem.first_side,
        first_after,
        np.zeros(first_after[-1], np.int8),
        np.zeros(problem.n_patches, np.int8),
        np.zeros((problem.n_chains, 4)),
    )


class Descent:
    """Counts that walks improve; what they are searched in is kept from one to the next.

    former, change: chains with other counts than these cost ``change`` each beside their error.
    within: walks go through these patches only, by default through any.
    """

    def __init__(
        self,
        problem: CountsProblem,
        counts: Int32Array,
        former: Int32Array | None = None,
        change: float = 0.0,
        within: Sequence[int] | None = None,
    ) -> None:
        self._problem = problem
        self._former = former
        self._change = change
        self._graph = make_walk_graph(problem)
        self._graph.after[:] = FORBIDDEN
        self._within = np.zeros(problem.n_patches, np.bool_)
        self._within[slice(None) if within is None else list(within)] = True
        self._answers: dict[tuple[int, ...], bool] = {}
        self.counts = counts.astype(np.int32)
        self._update(
            np.arange(problem.n_chains, dtype=np.int32),
            np.arange(problem.n_patches, dtype=np.int32),
        )

    def reset(self, counts: Int32Array) -> None:
        """Take other counts to go on from."""
        changed = np.flatnonzero(counts != self.counts).astype(np.int32)
        self.counts = counts.astype(np.int32)
        self._update(changed, self._patches(changed))

    def run(self, starts: Int32Array | None = None) -> float:
        """Walk, from chains ``starts``, until nothing gains, short walks first; the gain."""
        halves = np.arange(len(self._graph.chain), dtype=np.int32)
        if starts is not None:
            halves = np.flatnonzero(np.isin(self._graph.chain, starts)).astype(np.int32)
        return sum(self._run(halves, steps) for steps in MOST_STEPS)

    def _run(self, halves: Int32Array, most_steps: int) -> float:
        walk = np.empty((most_steps + 2, 2), np.int32)
        gained = 0.0
        begin, changed = 0, False
        while True:
            n, begin, gain = find_walk(
                self._graph, halves, begin, most_steps, self._problem.regularity, walk
            )
            if n:
                gained += gain
                changed = True
                self.counts[walk[:n, 0]] += walk[:n, 1]
                self._update(walk[:n, 0], self._patches(walk[:n, 0]))
            elif changed:
                # Once more through all of them: what was changed may have opened other ways.
                begin, changed = 0, False
            else:
                return gained

    def _patches(self, chains: Int32Array) -> Int32Array:
        around = np.unique(self._problem.ends[chains])
        return around[around < self._problem.n_patches].astype(np.int32)

    def _update(self, chains: Int32Array, patches: Int32Array) -> None:
        """Set costs of the chains' changes, and tables of the patches, from the counts."""
        p = self._problem
        n = self.counts[chains]
        now = p.weights[chains] * np.abs(n - p.targets[chains])
        if self._former is not None:
            now = now + self._change * (n != self._former[chains])
        for column, by in enumerate((-2, -1, 1, 2)):
            cost = p.weights[chains] * np.abs(n + by - p.targets[chains]) - now
            if self._former is not None:
                cost += self._change * (n + by != self._former[chains])
            free = (p.pinned[chains] == 0) & (n + by >= p.least[chains])
            self._graph.step[chains, column] = np.where(free, cost, np.inf)
        lengths = p.side_lengths(self.counts)
        patches = patches[self._within[patches]]
        if p.cheap is None:
            judge_patches(self._graph, lengths, patches.astype(np.int32))
        else:
            for patch in patches:
                self._ask(int(patch), lengths)

    def _ask(self, patch: int, lengths: Int32Array) -> None:
        """Ask the caller's rule what a patch is, and would be."""
        graph = self._graph
        low, high = graph.first_side[patch : patch + 2]
        first, end = graph.first_half[patch : patch + 2]
        here = lengths[low:high]
        graph.state[patch] = self._irregular(tuple(here.tolist()))
        changes = [(graph.side[half] - low, by) for half in range(first, end) for by in (-1, 1)]
        at = graph.first_after[patch]
        for (one, by), (other, too) in product(changes, repeat=2):
            after = here.copy()
            after[one] += by
            after[other] += too
            small = after.sum() < MIN_PERIMETER or after.min() < 1
            graph.after[at] = FORBIDDEN if small else self._irregular(tuple(after.tolist()))
            at += 1

    def _irregular(self, lengths: tuple[int, ...]) -> int:
        assert self._problem.cheap is not None
        if lengths not in self._answers:
            self._answers[lengths] = bool(self._problem.cheap(lengths))
        return CHEAP if self._answers[lengths] else IRREGULAR
