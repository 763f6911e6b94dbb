"""Walks make counts better until none gains, and gain what they say."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.counts import (
    CountsProblem,
    has_cheap_fill,
    improve_counts,
    solve_counts,
)
from patterndb_sketch.retopo.counts.evening import even_by_least_errors
from patterndb_sketch.retopo.counts.rules import sum_costs
from patterndb_sketch.retopo.counts.walks import Descent
from tests.support.retopo.counts import glued, lists, refuse_unless_sound


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 25), st.sampled_from([0.0, 0.2]))
def test_walks_gain_what_they_say_and_keep_evenness(seed: int, n_patches: int, pins: float) -> None:
    problem = glued(seed, n_patches, pins, regularity=2.0)
    start = even_by_least_errors(problem)
    descent = Descent(problem, start.counts)
    gained = descent.run()
    assert sum_costs(problem, start.counts) - gained == pytest.approx(
        sum_costs(problem, descent.counts)
    )
    assert np.array_equal(
        problem.perimeters(descent.counts) % 2, problem.perimeters(start.counts) % 2
    )
    assert descent.run() == 0.0
    asked = Descent(
        CountsProblem.of(
            problem.targets, lists(problem), problem.pinned, regularity=2.0, cheap=has_cheap_fill
        ),
        start.counts,
    )
    assert asked.run() == pytest.approx(gained)
    assert np.array_equal(asked.counts, descent.counts)


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.integers(1, 4))
def test_no_single_change_and_no_short_walk_is_left(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches, regularity=2.0)
    descent = Descent(problem, even_by_least_errors(problem).counts)
    descent.run()
    least = sum_costs(problem, descent.counts)
    for one, other in product(range(problem.n_chains), repeat=2):
        for by, too in product((-2, -1, 1, 2), (-1, 0, 1)):
            tried = descent.counts.copy()
            tried[one] += by
            tried[other] += too
            perimeters = problem.perimeters(tried)
            allowed = np.all(perimeters % 2 == 0) and np.all(perimeters >= 4)
            # Two chains that change, by 1 each, are a walk through one patch or two.
            if allowed and np.all(tried >= problem.least) and (abs(by) == 1) == (too != 0):
                ends = problem.ends[[one, other]]
                if one == other or np.any(ends[:, 0] == ends[:, 1]):
                    continue
                assert sum_costs(problem, tried) >= least - 1e-5


def test_improvements_never_get_worse_and_end() -> None:
    problem = glued(5, 40)
    last = solve_counts(problem, n_balls=0)
    for step in improve_counts(problem, last):
        refuse_unless_sound(problem, step)
        assert step.total <= last.total
        last = step
    assert last.finished
