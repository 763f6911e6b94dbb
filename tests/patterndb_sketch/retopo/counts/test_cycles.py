"""Cycles make counts better until none gains, by what is reported."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.counts.cycles import CycleSearch
from patterndb_sketch.retopo.counts.parity import even_by_least_errors
from tests.support.retopo.counts import glued


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 25), st.sampled_from([0.0, 0.2]))
def test_cycles_gain_what_is_reported_and_keep_evenness(
    seed: int, n_patches: int, pins: float
) -> None:
    problem = glued(seed, n_patches, pins, regularity=2.0)
    start = even_by_least_errors(problem)
    search = CycleSearch(problem, start.counts)
    gained = search.run()
    assert problem.sum_costs(start.counts) - gained == pytest.approx(
        problem.sum_costs(search.counts)
    )
    assert np.array_equal(
        problem.perimeters(search.counts) % 2, problem.perimeters(start.counts) % 2
    )
    assert search.run() == 0.0


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.integers(1, 4))
def test_no_single_change_and_no_short_cycle_is_left(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches, regularity=2.0)
    search = CycleSearch(problem, even_by_least_errors(problem).counts)
    search.run()
    least = problem.sum_costs(search.counts)
    for one, other in product(range(problem.n_chains), repeat=2):
        for by, too in product((-2, -1, 1, 2), (-1, 0, 1)):
            tried = search.counts.copy()
            tried[one] += by
            tried[other] += too
            perimeters = problem.perimeters(tried)
            allowed = np.all(perimeters % 2 == 0) and np.all(perimeters >= 4)
            # Two chains that change, by 1 each, are a cycle through one patch or two.
            if allowed and np.all(tried >= problem.least) and (abs(by) == 1) == (too != 0):
                ends = problem.ends[[one, other]]
                if one == other or np.any(ends[:, 0] == ends[:, 1]):
                    continue
                assert problem.sum_costs(tried) >= least - 1e-5
