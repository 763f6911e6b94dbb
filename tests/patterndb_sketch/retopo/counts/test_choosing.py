"""Choosing counts for whole networks, changing one, and what is refused."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb_sketch.retopo.counts import (
    CountsProblem,
    change_count,
    even_by_fewest_changes,
    solve_counts,
)
from patterndb_sketch.retopo.errors import InvalidRetopoError
from tests.support.retopo.counts import Patches, glued, grid, refuse_unless_sound


@pytest.mark.parametrize("target", [1.0, 2.4, 3.6, 7.0])
def test_a_square_grid_with_equal_targets_is_rounded_and_no_more(target: float) -> None:
    patches, n_chains = grid(4, 5)
    found = solve_counts(CountsProblem.of(np.full(n_chains, target), patches))
    assert set(found.counts.tolist()) == {round(target)}
    assert not len(found.irregular)
    assert found.finished


@pytest.mark.parametrize("more", [-2, -1, 1, 2])
def test_one_more_on_a_border_chain_of_a_grid_changes_few_others(more: int) -> None:
    patches, n_chains = grid(3, 3)
    problem = CountsProblem.of(np.full(n_chains, 4.0), patches)
    before = np.full(n_chains, 4)
    for chain in np.flatnonzero((problem.ends == problem.n_patches).any(axis=1)).tolist():
        found = change_count(problem, before, chain, 4 + more)
        pinned = problem.with_pinned(chain, 4 + more)
        refuse_unless_sound(pinned, found)
        others = np.flatnonzero(found.counts != before)
        assert chain in others
        assert len(others) <= (4 if more % 2 else 1)


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 25), st.integers(-3, 3))
def test_a_changed_count_leaves_all_patches_even(seed: int, n_patches: int, more: int) -> None:
    problem = glued(seed, n_patches, 0.1)
    chain = seed % problem.n_chains
    before = solve_counts(problem, searches=0).counts
    count = max(1, int(before[chain]) + more)
    found = change_count(problem, before, chain, count)
    refuse_unless_sound(problem.with_pinned(chain, count), found)
    assert found.counts[chain] == count
    fewest = even_by_fewest_changes(problem.with_pinned(chain, count), before).counts
    assert (found.counts != before).sum() <= max(5, (fewest != before).sum())
    if problem.n_patches and not more and found.stuck == solve_counts(problem, searches=0).stuck:
        # Nothing was asked for: what changes must pay for itself.
        n_changed = int((found.counts != before).sum())
        assert found.total + 2.0 * n_changed <= problem.sum_costs(before) + 1e-6


def test_counts_do_not_depend_on_threads() -> None:
    problems = [glued(seed, 40, 0.05, 3.0) for seed in range(2)]
    alone = [solve_counts(problem, searches=3) for problem in problems]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda problem: solve_counts(problem, searches=3), problems * 2))
    for one, other in zip(alone * 2, together, strict=True):
        assert np.array_equal(one.counts, other.counts)
        assert one.total == other.total


def test_further_neighbourhoods_never_make_counts_worse_and_end() -> None:
    problem = glued(5, 40)
    last = solve_counts(problem, searches=0)
    for n in (1, 2, 4, 8, 1000):
        step = solve_counts(problem, searches=n)
        refuse_unless_sound(problem, step)
        assert step.total <= last.total
        last = step
    assert last.finished


def test_nothing_is_chosen_where_there_is_nothing() -> None:
    for n_chains in (0, 3):
        found = solve_counts(CountsProblem.of(np.full(n_chains, 2.2), []))
        assert found.counts.tolist() == [2] * n_chains
        assert found.finished
    alone = CountsProblem.of([2.2, 3.0], [[[0]]])
    assert solve_counts(alone).counts.tolist() == [4, 3]
    assert change_count(alone, [4, 3], 1, 7).counts.tolist() == [4, 7]


@pytest.mark.parametrize(
    ("targets", "patches", "pinned", "message"),
    [
        ([1.0, 0.0], [], None, "above 0"),
        ([1.0, np.nan], [], None, "above 0"),
        ([1.0], [[]], None, "patch 0 has no side"),
        ([1.0], [[[0], []]], None, "side 1 of patch 0 has no chain"),
        ([1.0], [[[0], [1]]], None, "names chain 1"),
        ([1.0], [[[0], [0], [0]]], None, "occurs a third time"),
        ([1.0], [[[0]]], [-1], "pinned counts"),
        ([1.0], [[[0]]], [1, 2], "pinned counts"),
        ([1.0], [[[0]]], [1.5], "whole"),
    ],
)
def test_bad_problems_are_refused(
    targets: list[float], patches: Patches, pinned: list[float] | None, message: str
) -> None:
    with pytest.raises(InvalidRetopoError, match=message):
        CountsProblem.of(targets, patches, pinned)


def test_bad_changes_are_refused() -> None:
    patches, n_chains = grid(1, 1)
    problem = CountsProblem.of(np.full(n_chains, 3.0), patches)
    before: NDArray[np.int64] = np.full(n_chains, 3)
    with pytest.raises(InvalidRetopoError, match="there is no chain 4"):
        change_count(problem, before, 4, 2)
    with pytest.raises(InvalidRetopoError, match="cannot have 0 edges"):
        change_count(problem, before, 0, 0)
    with pytest.raises(InvalidRetopoError, match="choose them first"):
        change_count(problem, before[1:], 0, 2)
