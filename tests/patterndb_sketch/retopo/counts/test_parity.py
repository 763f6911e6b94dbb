"""Counts are even everywhere, by the least errors or the fewest changes there are."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Bools
from patterndb_sketch.retopo.counts import CountsProblem, solve_counts
from patterndb_sketch.retopo.counts.parity import (
    even_along_strips,
    even_by_fewest_changes,
    even_by_least_errors,
    find_cheapest_join,
    label_components,
    label_strips,
    pair_cheaply,
)
from patterndb_sketch.retopo.errors import InvalidRetopoError
from tests.support.retopo.counts import glued, lists, refuse_unless_sound


def optimum(problem: CountsProblem, window: int, regularity: float) -> float:
    """The least total by a plain model of CP-SAT: numbers, and halves for evenness."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    costs: list[Any] = []
    counts: list[Any] = []
    for c in range(problem.n_chains):
        t, least = float(problem.targets[c]), int(problem.least[c])
        low = max(least, round(t) - window)
        options = range(low, max(low, round(t)) + window + 1)
        flags = {n: model.new_bool_var("") for n in options}
        model.add_exactly_one(flags.values())
        counts.append(sum(n * flag for n, flag in flags.items()))
        costs += [
            round(1e6 * float(problem.weights[c]) * abs(n - t)) * flag for n, flag in flags.items()
        ]
    for f in range(problem.n_patches):
        lengths = [
            sum(
                counts[c]
                for c in problem.chains[problem.first_chain[k] : problem.first_chain[k + 1]]
            )
            for k in range(problem.first_side[f], problem.first_side[f + 1])
        ]
        model.add(sum(lengths) == 2 * model.new_int_var(2, 1000, ""))
        irregular = model.new_bool_var("")
        costs.append(round(1e6 * regularity) * irregular)
        n = len(lengths)
        if n == 4:
            model.add(lengths[0] == lengths[2]).only_enforce_if(~irregular)
            model.add(lengths[1] == lengths[3]).only_enforce_if(~irregular)
        for i in range(n if n in (3, 5, 6, 7) else 0):
            # A side, or two neighbours, and all that do not touch them.
            touching = {(i - 1) % n, i, (i + 1) % n} if n > 3 else {i}
            across = sum(lengths[k] for k in range(n) if k not in touching)
            model.add(lengths[i] <= across).only_enforce_if(~irregular)
            if n > 3:
                others = sum(lengths[k] for k in range(n) if k not in (i, (i + 1) % n))
                model.add(lengths[i] + lengths[(i + 1) % n] <= others).only_enforce_if(~irregular)
    model.minimize(sum(costs))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    assert solver.solve(model) == cp_model.OPTIMAL
    return solver.objective_value / 1e6


@settings(max_examples=100)
@given(st.integers(0, 2**32), st.integers(0, 30), st.sampled_from([0.0, 0.2, 0.9]))
def test_every_patch_is_even_and_bounds_and_pins_are_kept(
    seed: int, n_patches: int, pins: float
) -> None:
    problem = glued(seed, n_patches, pins, regularity=3.0)
    refuse_unless_sound(problem, solve_counts(problem, searches=int(seed % 8 == 0)))


def test_strips_stop_where_a_pinned_count_is_too_few_for_others() -> None:
    # A quad whose side of one edge is across from a triangle's, which needs two.
    problem = CountsProblem.of(
        np.full(6, 4.0), [[[0], [1], [2], [3]], [[2], [4], [5]]], [1] + [0] * 5
    )
    assert label_strips(problem).tolist() == [0, 1, 2, 1, 4, 5]
    refuse_unless_sound(problem, solve_counts(problem))


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.integers(1, 30))
@example(648045, 6)
def test_the_join_is_the_optimum_of_errors_alone(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches)
    found = even_by_least_errors(problem)
    least = optimum(problem, 2, 0.0)
    assert found.bound <= least + 1e-4
    # Where no patch of one chain or two had to be raised to four edges afterwards:
    if found.bound == pytest.approx(float(problem.errors(found.counts).sum())):
        assert found.bound == pytest.approx(least, abs=1e-4)


@settings(max_examples=20)
@given(st.integers(0, 2**32), st.integers(1, 7))
def test_small_networks_get_the_best_counts_there_are(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches)
    found = solve_counts(problem, searches=100)
    assert found.finished
    # The second solver looks at counts near the lengths alone; better ones may be further off.
    assert found.total <= optimum(problem, 3, 1.0) + 1e-3


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 3), st.sampled_from([0.0, 0.3]))
def test_no_fewer_chains_can_change(seed: int, n_patches: int, pins: float) -> None:
    problem = glued(seed, n_patches, pins)
    free = np.flatnonzero(problem.pinned == 0)
    if len(free) > 11:
        return
    before = np.maximum(
        np.random.default_rng(seed).integers(4, 9, problem.n_chains), problem.least
    ).astype(np.int32)
    start = np.where(problem.pinned > 0, problem.pinned, before).astype(np.int32)
    found = even_by_fewest_changes(problem, before)
    fewest = len(free) + 1
    for flips in product((0, 1), repeat=len(free)):
        tried = start.copy()
        tried[free] += np.array(flips, np.int32)
        if not np.any(problem.perimeters(tried) % 2):
            fewest = min(fewest, sum(flips))
    if fewest > len(free):
        assert any(one.odd for one in found.stuck)
    else:
        assert not any(one.odd for one in found.stuck)
        raised = np.abs(found.counts - start) > 1
        assert (found.counts != start).sum() - raised.sum() <= fewest


@settings(max_examples=40)
@given(st.integers(0, 2**32), st.integers(1, 40))
def test_strips_end_regular_wherever_nothing_is_in_their_way(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches)
    strip = label_strips(problem)
    made = even_along_strips(problem, strip)
    assert not np.any(problem.perimeters(made.counts) % 2)
    tied = [
        (side[i][0], side[i + 2][0])
        for side in lists(problem)
        if len(side) == 4
        for i in (0, 1)
        if len(side[i]) == len(side[i + 2]) == 1
    ]
    assert all(strip[a] == strip[b] for a, b in tied)
    one = np.arange(problem.n_chains)
    for a, b in tied:
        one[one == max(one[a], one[b])] = min(one[a], one[b])
    assert np.array_equal(one, strip)


def test_pinned_chains_without_a_way_out_are_named() -> None:
    # Two triangles back to back, a closed surface: all three chains are around both.
    triangles = [[[0], [1], [2]], [[2], [1], [0]]]
    problem = CountsProblem.of([4.0, 4.0, 4.0], triangles, [3, 4, 4])
    found = solve_counts(problem)
    assert [one.odd for one in found.stuck] == [True, True]
    assert found.stuck[0].pinned == (0, 1, 2)
    assert "change one of chains 0, 1, 2 by 1, or free it" in str(found.stuck[0])
    assert not solve_counts(problem.with_pinned(1, 0)).stuck
    small = CountsProblem.of([4.0, 4.0], [[[0], [1]]], [1, 1])
    assert "fewer than 4 edges" in str(solve_counts(small).stuck[0])
    assert solve_counts(small.with_pinned(0, 0)).counts.tolist() in ([3, 1], [5, 1])


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
