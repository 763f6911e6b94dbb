"""Descent: counts made better by walks until no walk gains any more."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts import walks
from patterndb_sketch.retopo.counts.problem import MIN_PERIMETER, CountsProblem


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
        self._maze = walks.maze_of(problem)
        self._maze.after[:] = walks.FORBIDDEN
        self._within = np.zeros(problem.n_patches, np.bool_)
        self._within[slice(None) if within is None else list(within)] = True
        self._answers: dict[tuple[int, ...], bool] = {}
        self.counts = counts.astype(np.int32)
        self._update(
            np.arange(problem.n_chains, dtype=np.int32),
            np.arange(problem.n_patches, dtype=np.int32),
        )

    def reset(self, counts: Int32Array) -> None:
        """Go on from other counts."""
        changed = np.flatnonzero(counts != self.counts).astype(np.int32)
        self.counts = counts.astype(np.int32)
        self._update(changed, self._patches(changed))

    def run(self, starts: Int32Array | None = None) -> float:
        """Walk, from chains ``starts``, until nothing gains, short walks first; the gain."""
        doors = np.arange(len(self._maze.chain), dtype=np.int32)
        if starts is not None:
            doors = np.flatnonzero(np.isin(self._maze.chain, starts)).astype(np.int32)
        return sum(self._run(doors, steps) for steps in walks.MOST_STEPS)

    def _run(self, doors: Int32Array, most_steps: int) -> float:
        walk = np.empty((most_steps + 2, 2), np.int32)
        gained = 0.0
        begin, changed = 0, False
        while True:
            n, begin, gain = walks.find_walk(
                self._maze, doors, begin, most_steps, self._problem.regularity, walk
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
        """Costs of the chains' changes, and tables of the patches, from the counts."""
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
            self._maze.step[chains, column] = np.where(free, cost, np.inf)
        lengths = p.side_lengths(self.counts)
        patches = patches[self._within[patches]]
        if p.cheap is None:
            walks.judge(self._maze, lengths, patches.astype(np.int32))
        else:
            for patch in patches:
                self._ask(int(patch), lengths)

    def _ask(self, patch: int, lengths: Int32Array) -> None:
        """What a patch is, and would be, by the caller's rule."""
        maze = self._maze
        low, high = maze.first_side[patch : patch + 2]
        first, end = maze.first_door[patch : patch + 2]
        here = lengths[low:high]
        maze.state[patch] = self._irregular(tuple(here.tolist()))
        changes = [(maze.side[door] - low, by) for door in range(first, end) for by in (-1, 1)]
        at = maze.first_after[patch]
        for (one, by), (other, too) in product(changes, repeat=2):
            after = here.copy()
            after[one] += by
            after[other] += too
            small = after.sum() < MIN_PERIMETER or after.min() < 1
            maze.after[at] = walks.FORBIDDEN if small else self._irregular(tuple(after.tolist()))
            at += 1

    def _irregular(self, lengths: tuple[int, ...]) -> int:
        assert self._problem.cheap is not None
        if lengths not in self._answers:
            self._answers[lengths] = bool(self._problem.cheap(lengths))
        return walks.CHEAP if self._answers[lengths] else walks.IRREGULAR
