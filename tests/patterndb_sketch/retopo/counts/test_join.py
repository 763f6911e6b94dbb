"""Matchings and T-joins: the cheapest there are, against all of them and against CP-SAT."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Bools
from patterndb_sketch.retopo.counts.tjoin import (
    find_cheapest_join,
    label_components,
    pair_cheaply,
)
from patterndb_sketch.retopo.errors import InvalidRetopoError


def weights(seed: int, n: int, most: int) -> Int64Array:
    """Symmetric; every third time distances on a line, with many ties."""
    chance = np.random.default_rng(seed)
    if seed % 3 == 0:
        at = chance.integers(0, most + 1, n)
        return np.abs(at[:, None] - at[None]).astype(np.int64)
    half = np.triu(chance.integers(0, most + 1, (n, n)), 1)
    return (half + half.T).astype(np.int64)


def least_matching(weight: Int64Array) -> int:
    """The least sum of weights over all perfect matchings, tried in full."""
    n = len(weight)

    @cache
    def rest(taken: int) -> int:
        first = next((v for v in range(n) if not taken >> v & 1), n)
        if first == n:
            return 0
        return min(
            int(weight[first, v]) + rest(taken | 1 << first | 1 << v)
            for v in range(first + 1, n)
            if not taken >> v & 1
        )

    return rest(0)


def sum_of(weight: Int64Array, mate: np.ndarray[tuple[int], np.dtype[np.int32]]) -> int:
    n = len(weight)
    assert np.array_equal(mate[mate], np.arange(n))
    assert not np.any(mate == np.arange(n))
    return int(weight[np.arange(n), mate].sum()) // 2


@settings(max_examples=300)
@given(st.integers(0, 2**32), st.integers(0, 6), st.sampled_from([0, 1, 3, 10, 10**9]))
def test_no_perfect_matching_weighs_less(seed: int, half: int, most: int) -> None:
    weight = weights(seed, 2 * half, most)
    found = pair_cheaply(weight)
    assert sum_of(weight, found) == least_matching(weight)
    assert np.array_equal(found, pair_cheaply(weight))


@pytest.mark.parametrize("seed", range(4))
def test_cp_sat_finds_no_lighter_matching(seed: int) -> None:
    from ortools.sat.python import cp_model

    n = 30
    weight = weights(3 * seed + 1, n, 30)
    model = cp_model.CpModel()
    pair = {(i, j): model.new_bool_var("") for i in range(n) for j in range(i)}
    for v in range(n):
        model.add_exactly_one([flag for key, flag in pair.items() if v in key])
    model.minimize(sum(int(weight[key]) * flag for key, flag in pair.items()))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    assert solver.solve(model) == cp_model.OPTIMAL
    assert sum_of(weight, pair_cheaply(weight)) == solver.objective_value


@settings(max_examples=300)
@given(st.integers(0, 2**32), st.integers(1, 7), st.integers(0, 10), st.integers(0, 20))
def test_no_join_costs_less(seed: int, n_nodes: int, n_edges: int, most: int) -> None:
    chance = np.random.default_rng(seed)
    ends = chance.integers(0, n_nodes, (n_edges, 2)).astype(np.int32)
    costs = chance.integers(0, most + 1, n_edges)
    odd = chance.random(n_nodes) < 0.5
    found = find_cheapest_join(n_nodes, ends, costs, odd)
    component = label_components(n_nodes, ends)
    wanted = odd.copy()
    wanted[found.left] = False
    # One node is left for every component with an odd number of them.
    assert np.all(odd[found.left])
    assert np.all(np.bincount(component[wanted], minlength=1) % 2 == 0)
    assert len(set(component[found.left])) == len(found.left)

    def parity(edges: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Bools:
        return np.bincount(ends[edges].ravel(), minlength=n_nodes) % 2 == 1

    assert np.array_equal(parity(found.edges), wanted)
    costs_of_all = [
        int(costs[np.array(flags, np.bool_)].sum())
        for flags in product((False, True), repeat=n_edges)
        if np.array_equal(parity(np.array(flags, np.bool_)), wanted)
    ]
    assert int(costs[found.edges].sum()) == min(costs_of_all)


def test_bad_weights_are_refused() -> None:
    with pytest.raises(InvalidRetopoError, match="cannot be paired"):
        pair_cheaply(np.zeros((3, 3), np.int64))
    with pytest.raises(InvalidRetopoError, match="below 0"):
        pair_cheaply(np.full((2, 2), -1, np.int64))
