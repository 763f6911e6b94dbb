"""Improve counts by cycles: closed paths across chains, each of them one edge more or fewer.

A path through a patch changes two of its chains by 1, so that it stays even. A cycle is closed, or
comes from outside and goes back there. It visits no patch twice, so that its gain is the sum over
its steps, and it is found as a shortest path of negative length. Of a cyclic sequence with a
negative sum some rotation has negative sums from its beginning to every place (Lin and Kernighan
1973, the gain criterion): paths that have cost something are given up at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.counts.walks import find_walk, judge_patches
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb_sketch.retopo.counts.problem import CountsProblem

Int8Array = NDArray[np.int8]

#: What a patch is after a change that no fill suits, or in which no cycle may go.
FORBIDDEN = 2

#: Patches that a cycle may visit: half the gain of longer ones is had by shorter ones in a tenth
#: of the time (200 to 1000 patches), and beyond the last hardly any is left.
MOST_STEPS = (6, 12, 24)


class CycleGraph(NamedTuple):
    """What cycles are searched in: *halves* are occurrences of chains in patches, two of a chain
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


def make_cycle_graph(problem: CountsProblem) -> CycleGraph:
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
    return CycleGraph(
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


class CycleSearch:
    """Counts that cycles improve; what these are searched in is kept from one to the next.

    former, change: chains with other counts than these cost ``change`` each beside their error.
    within: cycles go through these patches only, by default through any.
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
        self._graph = make_cycle_graph(problem)
        self._graph.after[:] = FORBIDDEN
        self._within = np.zeros(problem.n_patches, np.bool_)
        self._within[slice(None) if within is None else list(within)] = True
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
        """Change cycles from chains ``starts`` until none gains, short ones first; the gain."""
        halves = np.arange(len(self._graph.chain), dtype=np.int32)
        if starts is not None:
            halves = np.flatnonzero(np.isin(self._graph.chain, starts)).astype(np.int32)
        return sum(self._run(halves, steps) for steps in MOST_STEPS)

    def _run(self, halves: Int32Array, most_steps: int) -> float:
        cycle = np.empty((most_steps + 2, 2), np.int32)
        gained = 0.0
        begin, changed = 0, False
        while True:
            n, begin, gain = find_walk(
                self._graph, halves, begin, most_steps, self._problem.regularity, cycle
            )
            if n:
                gained += gain
                changed = True
                self.counts[cycle[:n, 0]] += cycle[:n, 1]
                self._update(cycle[:n, 0], self._patches(cycle[:n, 0]))
            elif changed:
                # Once more through all of them: what was changed may have opened others.
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
        judge_patches(self._graph, lengths, patches.astype(np.int32))
