"""Regular counts: the integer program against all counts there are, and what it holds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from patterndb_sketch.retopo.counts import CountsProblem
from patterndb_sketch.retopo.counts.regular import IRREGULAR, solve_regular_counts


def cost(problem: CountsProblem, counts: np.ndarray) -> float:
    """Errors, and what four-sided patches cost whose opposite sides disagree; inf where odd."""
    lengths = problem.side_lengths(counts)
    if (problem.perimeters(counts) % 2).any():
        return np.inf
    total = float(problem.errors(counts).sum())
    for f in range(problem.n_patches):
        of = lengths[problem.first_side[f] : problem.first_side[f + 1]]
        if len(of) == 4:
            total += IRREGULAR * (of[0] != of[2] or of[1] != of[3])
        elif len(of) > 2 and 2 * of.max() > of.sum():
            return np.inf
    return total


def row(n: int) -> list[list[list[int]]]:
    """n four-sided patches in a row: chain k up between patches, n + 1 + k below and above."""
    return [[[n + 1 + k], [k + 1], [2 * n + 1 + k], [k]] for k in range(n)]


@pytest.mark.parametrize("seed", range(12))
def test_no_counts_cost_less(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shapes = [
        row(1),
        row(2),
        # Two patches on one side of a third: a T-junction.
        [[[0], [1], [2], [3]], [[4], [5], [0], [1]], [[6, 3], [5], [4], [2]]],
        # A triangle beside a patch.
        [[[0], [1], [2], [3]], [[0], [4], [5]]],
    ]
    shape = shapes[seed % len(shapes)]
    n = 1 + max(chain for patch in shape for side in patch for chain in side)
    problem = CountsProblem.of(rng.uniform(0.6, 3.4, n), shape)
    found = solve_regular_counts(problem)
    assert found is not None and (found >= problem.least).all()
    best = min(
        cost(problem, np.array(counts, np.int32))
        for counts in itertools.product(range(1, 5), repeat=n)
        if (np.array(counts) >= problem.least).all()
    )
    assert cost(problem, found) <= 1.031 * best + 1e-9


def test_pinned_counts_stay_and_strips_follow() -> None:
    problem = CountsProblem.of(np.full(7, 3.0), row(2), [5, 0, 0, 0, 0, 0, 0])
    found = solve_regular_counts(problem)
    assert found is not None
    assert found.tolist() == [5, 5, 5, 3, 3, 3, 3]


def test_nothing_to_count_and_what_cannot_be() -> None:
    empty = solve_regular_counts(CountsProblem.of([], []))
    assert empty is not None and not len(empty)
    odd = CountsProblem.of([1.0, 1.0, 1.0], [[[0], [1], [2]]], [3, 2, 2])
    assert solve_regular_counts(odd) is None
