"""Widths by kernel, by CP-SAT and by trying: the same lists, best first."""

from __future__ import annotations

import os
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.query.cases import (
    Chords,
    Widths,
    brute_force,
    find_widths,
    is_feasible,
    random_system,
)

#: Random systems to compare all solvers on; a release is held to 5,000.
SYSTEMS = int(os.environ.get("QUERY_SYSTEMS", "120"))
LIMITS = (1, 2, 3, 5, 20)


def assert_best(chords: Chords, lengths: list[int], all_of_them: list[Widths]) -> None:
    assert is_feasible(chords, lengths) == bool(all_of_them)
    assert find_widths(chords, lengths) == all_of_them
    for limit in LIMITS:
        assert find_widths(chords, lengths, limit) == all_of_them[:limit]


@pytest.mark.parametrize("seed", range(4))
def test_kernel_cpsat_and_trying_agree(seed: int) -> None:
    chance = random.Random(seed)
    solvable = 0
    for _ in range(SYSTEMS // 4):
        chords, lengths = random_system(chance)
        expected = brute_force(chords, lengths)
        solvable += bool(expected)
        assert_best(chords, lengths, expected)
        assert find_widths(chords, lengths, by_cpsat=True) == expected
        assert is_feasible(chords, lengths, by_cpsat=True) == bool(expected)
    assert solvable > SYSTEMS // 12


@settings(max_examples=100, derandomize=True)
@given(st.integers(0, 2**32))
def test_the_best_are_the_best_of_all(seed: int) -> None:
    chords, lengths = random_system(random.Random(seed), most_chords=6, widest=6)
    assert_best(chords, lengths, brute_force(chords, lengths))


@pytest.mark.parametrize("seed", range(8))
def test_cpsat_lists_the_same_best(seed: int) -> None:
    chance = random.Random(seed)
    chords, lengths = random_system(chance, most_sides=3, most_chords=6)
    for limit in (1, 3):
        kernel = find_widths(chords, lengths, limit)
        assert kernel == find_widths(chords, lengths, limit, by_cpsat=True)


@pytest.mark.parametrize("seed", range(30))
def test_long_sides_need_no_list_of_all_solutions(seed: int) -> None:
    """The best widths add up, in order, whichever the limit.

    The lists have up to 10**30 entries: only a bounded search comes back at all.
    """
    chance = random.Random(seed)
    n_sides = chance.randint(3, 10)
    sides = [
        ((a := chance.randrange(n_sides)), (a + chance.choice([0, 1, 1, 2, 2, 3])) % n_sides)
        for _ in range(2 * n_sides)
    ]
    chords = Chords.from_sides(n_sides, sides)
    planted = [chance.randint(1, 100) for _ in range(chords.n)]
    lengths = chords.side_lengths(planted)
    best = find_widths(chords, lengths, 10)
    keys = [sum(x * x for x in widths) for widths in best]
    assert all(min(widths) >= 1 for widths in best)
    assert all((chords.side_lengths(widths) == lengths).all() for widths in best)
    assert sorted(zip(keys, best, strict=True)) == list(zip(keys, best, strict=True))
    assert len(set(best)) == len(best)
    assert keys[0] <= sum(x * x for x in planted)
    longer = find_widths(chords, lengths, 15)
    assert longer[: len(best)] == best
    assert len(best) == 10 or longer == best


def test_what_only_a_flow_can_refuse_is_refused() -> None:
    # Sides 0 to 2 reach only 3 and 4, which are too short for them together: every side by
    # itself looks fine, and so do parities. 5 and 6 make up the colours.
    cross = [(i, j) for i in range(3) for j in (3, 4)] + [(5, j) for j in (3, 4)]
    chords = Chords.from_sides(8, [*cross, (5, 6), (5, 7), (6, 7)])
    slack = np.array([300, 300, 300, 440, 440, 500, 260, 260])
    assert not is_feasible(chords, chords.base_lengths() + slack)
    slack = np.array([300, 300, 300, 460, 460, 500, 240, 240])
    assert is_feasible(chords, chords.base_lengths() + slack)


def test_ties_go_to_the_lexicographically_smaller_widths() -> None:
    chords = Chords.from_sides(2, [(0, 1)] * 3)
    assert find_widths(chords, [4, 4], 2) == [(1, 1, 2), (1, 2, 1)]
    assert find_widths(chords, [5, 5], None) == [
        (1, 2, 2),
        (2, 1, 2),
        (2, 2, 1),
        (1, 1, 3),
        (1, 3, 1),
        (3, 1, 1),
    ]


def test_a_polychord_with_both_ends_on_a_side_counts_twice() -> None:
    chords = Chords.from_label(((0, 1, 0), (1,)))
    assert chords.sides.tolist() == [[0, 0], [0, 1]]
    assert chords.base_lengths().tolist() == [3, 1]
    assert find_widths(chords, [9, 3], None) == [(3, 3)]
    assert not is_feasible(chords, [9, 2])
