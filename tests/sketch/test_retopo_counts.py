"""Counts for whole networks: even everywhere, the least there are, and few changes at a time."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from query.boundary import Boundary
from query.listing.familylookup import FamilyLookup
from sketch.retopo.counts import (
    Counts,
    CountsProblem,
    changed,
    choose,
    family_rule,
    has_cheap_fill,
    improved,
    improvements,
)
from sketch.retopo.counts.descent import Descent
from sketch.retopo.counts.evening import along_strips, fewest_changes, least_errors
from sketch.retopo.counts.rules import total
from sketch.retopo.counts.strips import strips
from sketch.retopo.errors import InvalidRetopoError

Patches = list[list[list[int]]]


def glued(seed: int, n_patches: int, pins: float = 0.0, regularity: float = 1.0) -> CountsProblem:
    """Random polygons of 1 to 7 sides of 1 to 3 chains, glued at random: also to themselves."""
    chance = np.random.default_rng(seed)
    sizes = [
        [
            int(chance.choice([1, 1, 1, 2, 3]))
            for _ in range(chance.choice([1, 2, 3, 4, 4, 4, 5, 6, 7]))
        ]
        for _ in range(n_patches)
    ]
    n_doors = sum(map(sum, sizes))
    n_pairs = int(chance.integers(0, n_doors // 2 + 1))
    names = np.r_[np.repeat(np.arange(n_pairs), 2), np.arange(n_pairs, n_doors - n_pairs)]
    left = chance.permutation(names).tolist()
    patches = [[[left.pop() for _ in range(side)] for side in patch] for patch in sizes]
    n_chains = n_doors - n_pairs
    targets = np.exp(chance.uniform(-1, 2.3, n_chains))
    pinned = np.where(chance.random(n_chains) < pins, chance.integers(1, 7, n_chains), 0)
    return CountsProblem.of(targets, patches, pinned, regularity=regularity)


def grid(rows: int, columns: int) -> tuple[Patches, int]:
    """Cells of a grid; chains along x first, row by row, then those along y."""
    across = (rows + 1) * columns
    patches = [
        [
            [i * columns + j],
            [across + i * (columns + 1) + j + 1],
            [(i + 1) * columns + j],
            [across + i * (columns + 1) + j],
        ]
        for i in range(rows)
        for j in range(columns)
    ]
    return patches, across + rows * (columns + 1)


def refuse_unless_sound(problem: CountsProblem, counts: Counts) -> None:
    """Bounds and pins are kept; a patch that is odd or small is stuck, and rightly so."""
    n = counts.counts
    pinned = problem.pinned > 0
    assert np.array_equal(n[pinned], problem.pinned[pinned])
    assert np.all(n[~pinned] >= problem.least[~pinned])
    perimeters = problem.perimeters(n)
    odd = np.flatnonzero(perimeters % 2)
    assert len(odd) == sum(one.odd for one in counts.stuck)
    for one in counts.stuck:
        assert all(problem.pinned[chain] for chain in one.pinned)
        if one.odd:
            assert len(set(odd.tolist()) & set(one.patches)) == 1
            # Whatever the free chains within get, they count twice; none leads out.
            inside = np.isin(problem.ends, one.patches)
            assert not np.any((inside.sum(axis=1) == 1) & ~pinned)
            assert problem.pinned[inside.sum(axis=1) == 1].sum() % 2
            assert "odd" in str(one)
        else:
            assert set(problem.patch_chains(one.patches[0])) == set(one.pinned)
            assert perimeters[one.patches[0]] < 4
    small = {one.patches[0] for one in counts.stuck if not one.odd}
    assert set(np.flatnonzero((perimeters < 4) & (perimeters % 2 == 0)).tolist()) == small
    assert counts.cost == pytest.approx(float(problem.errors(n).sum()))
    assert counts.total == pytest.approx(total(problem, n))
    assert counts.bound <= counts.total + 1e-6


def optimum(problem: CountsProblem, window: int, regularity: float) -> float:
    """The least total by a plain model of CP-SAT: numbers, and halves for evenness."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    costs: list[Any] = []
    counts: list[Any] = []
    for c in range(problem.n_chains):
        t, least = float(problem.targets[c]), int(problem.least[c])
        options = {max(least, n) for n in range(round(t) - window, round(t) + window + 1)}
        flags = {n: model.new_bool_var("") for n in sorted(options)}
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
        elif n in (3, 5):
            for i in range(n):
                far = [(i + 2) % 5, (i + 3) % 5] if n == 5 else [i]
                near = [k for k in range(n) if k not in far]
                room = sum(lengths[k] for k in near) - sum(lengths[k] for k in far)
                model.add(room >= 2).only_enforce_if(~irregular)
        else:
            model.add(irregular == 1)
    model.minimize(sum(costs))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    assert solver.solve(model) == cp_model.OPTIMAL
    return solver.objective_value / 1e6


@settings(max_examples=200)
@given(st.integers(0, 2**32), st.integers(0, 30), st.sampled_from([0.0, 0.2, 0.9]))
def test_every_patch_is_even_and_bounds_and_pins_are_kept(
    seed: int, n_patches: int, pins: float
) -> None:
    problem = glued(seed, n_patches, pins, regularity=3.0)
    refuse_unless_sound(problem, choose(problem, n_balls=int(seed % 8 == 0)))


def test_strips_stop_where_a_pinned_count_is_too_few_for_others() -> None:
    # A quad whose side of one edge is across from a triangle's, which needs two.
    problem = CountsProblem.of(
        np.full(6, 4.0), [[[0], [1], [2], [3]], [[2], [4], [5]]], [1] + [0] * 5
    )
    assert strips(problem).tolist() == [0, 1, 2, 1, 4, 5]
    refuse_unless_sound(problem, choose(problem))


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.integers(1, 30))
def test_the_join_is_the_optimum_of_errors_alone(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches)
    found = least_errors(problem)
    least = optimum(problem, 2, 0.0)
    assert found.bound <= least + 1e-4
    # Where no patch of one chain or two had to be raised to four edges afterwards:
    if found.bound == pytest.approx(float(problem.errors(found.counts).sum())):
        assert found.bound == pytest.approx(least, abs=1e-4)


@settings(max_examples=20)
@given(st.integers(0, 2**32), st.integers(1, 7))
def test_small_networks_get_the_best_counts_there_are(seed: int, n_patches: int) -> None:
    problem = glued(seed, n_patches)
    found = choose(problem, n_balls=100)
    assert found.finished
    assert found.n_proven == found.n_balls
    assert found.total <= optimum(problem, 3, 1.0) + 1e-3


@pytest.mark.parametrize("target", [1.0, 2.4, 3.6, 7.0])
def test_a_square_grid_with_equal_targets_is_rounded_and_no_more(target: float) -> None:
    patches, n_chains = grid(4, 5)
    found = choose(CountsProblem.of(np.full(n_chains, target), patches))
    assert set(found.counts.tolist()) == {round(target)}
    assert not len(found.irregular)
    assert found.finished


@pytest.mark.parametrize("more", [-2, -1, 1, 2])
def test_one_more_on_a_border_chain_of_a_grid_changes_few_others(more: int) -> None:
    patches, n_chains = grid(3, 3)
    problem = CountsProblem.of(np.full(n_chains, 4.0), patches)
    before = np.full(n_chains, 4)
    for chain in np.flatnonzero((problem.ends == problem.n_patches).any(axis=1)).tolist():
        found = changed(problem, before, chain, 4 + more)
        pinned = problem.with_pinned(chain, 4 + more)
        refuse_unless_sound(pinned, found)
        others = np.flatnonzero(found.counts != before)
        assert chain in others
        assert len(others) <= (4 if more % 2 else 1)
        better = improved(pinned, before, found, chain)
        refuse_unless_sound(pinned, better)
        assert len(np.flatnonzero(better.counts != before)) <= 4


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 25), st.integers(-3, 3), st.booleans())
def test_a_changed_count_leaves_all_patches_even(
    seed: int, n_patches: int, more: int, by_family: bool
) -> None:
    problem = glued(seed, n_patches, 0.1)
    chain = seed % problem.n_chains
    before = choose(problem, n_balls=0).counts
    if by_family:
        problem = CountsProblem.of(
            problem.targets, lists(problem), problem.pinned, cheap=has_cheap_fill
        )
    count = max(1, int(before[chain]) + more)
    found = changed(problem, before, chain, count)
    refuse_unless_sound(problem.with_pinned(chain, count), found)
    assert found.counts[chain] == count
    fewest = fewest_changes(problem.with_pinned(chain, count), before).counts
    assert (found.counts != before).sum() <= max(5, (fewest != before).sum())
    if problem.n_patches and not more and found.stuck == choose(problem, n_balls=0).stuck:
        # Nothing was asked for: what changes must pay for itself.
        n_changed = int((found.counts != before).sum())
        assert found.total + 2.0 * n_changed <= total(problem, before) + 1e-6


def lists(problem: CountsProblem) -> Patches:
    return [
        [
            problem.chains[problem.first_chain[k] : problem.first_chain[k + 1]].tolist()
            for k in range(problem.first_side[f], problem.first_side[f + 1])
        ]
        for f in range(problem.n_patches)
    ]


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
    found = fewest_changes(problem, before)
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
    strip = strips(problem)
    made = along_strips(problem, strip)
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


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 25), st.sampled_from([0.0, 0.2]))
def test_walks_gain_what_they_say_and_keep_evenness(seed: int, n_patches: int, pins: float) -> None:
    problem = glued(seed, n_patches, pins, regularity=2.0)
    start = least_errors(problem)
    descent = Descent(problem, start.counts)
    gained = descent.run()
    assert total(problem, start.counts) - gained == pytest.approx(total(problem, descent.counts))
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
    descent = Descent(problem, least_errors(problem).counts)
    descent.run()
    least = total(problem, descent.counts)
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
                assert total(problem, tried) >= least - 1e-5


def test_counts_do_not_depend_on_threads() -> None:
    problems = [glued(seed, 60, 0.05, 3.0) for seed in range(3)]
    alone = [choose(problem, n_balls=3) for problem in problems]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda problem: choose(problem, n_balls=3), problems * 2))
    for one, other in zip(alone * 2, together, strict=True):
        assert np.array_equal(one.counts, other.counts)
        assert one.total == other.total


def test_improvements_never_get_worse_and_end() -> None:
    problem = glued(5, 40)
    last = choose(problem, n_balls=0)
    for step in improvements(problem, last):
        refuse_unless_sound(problem, step)
        assert step.total <= last.total
        last = step
    assert last.finished


@settings(max_examples=150)
@given(st.integers(3, 5), st.data())
def test_cheap_patches_have_the_family_s_fill(n_sides: int, data: st.DataObject) -> None:
    lengths = tuple(data.draw(st.integers(2, 12)) for _ in range(n_sides))
    if sum(lengths) % 2:
        lengths = (lengths[0] + 1, *lengths[1:])
    count = FamilyLookup.shared().count(Boundary(lengths))
    assert count is not None
    strict = FamilyLookup.shared().count(Boundary(lengths), strict=True)
    assert has_cheap_fill(lengths) == (strict == abs(n_sides - 4))
    # With corners elsewhere the family has fills for some more.
    assert family_rule(lengths) == (count <= abs(n_sides - 4))
    assert family_rule(lengths) or not has_cheap_fill(lengths)


def test_the_family_s_rule_serves_whole_networks() -> None:
    problem = glued(3, 25)
    asked = CountsProblem.of(problem.targets, lists(problem), cheap=family_rule)
    found = choose(asked, n_balls=2)
    refuse_unless_sound(asked, found)
    by_hand = [
        f
        for f, sides in enumerate(lists(problem))
        if not family_rule(tuple(int(sum(found.counts[c] for c in side)) for side in sides))
    ]
    assert found.irregular.tolist() == by_hand


def test_pinned_chains_without_a_way_out_are_named() -> None:
    # Two triangles back to back, a closed surface: all three chains are around both.
    triangles = [[[0], [1], [2]], [[2], [1], [0]]]
    problem = CountsProblem.of([4.0, 4.0, 4.0], triangles, [3, 4, 4])
    found = choose(problem)
    assert [one.odd for one in found.stuck] == [True, True]
    assert found.stuck[0].pinned == (0, 1, 2)
    assert "change one of chains 0, 1, 2 by 1, or free it" in str(found.stuck[0])
    assert not choose(problem.with_pinned(1, 0)).stuck
    small = CountsProblem.of([4.0, 4.0], [[[0], [1]]], [1, 1])
    assert "fewer than 4 edges" in str(choose(small).stuck[0])
    assert choose(small.with_pinned(0, 0)).counts.tolist() in ([3, 1], [5, 1])


def test_nothing_is_chosen_where_there_is_nothing() -> None:
    for n_chains in (0, 3):
        found = choose(CountsProblem.of(np.full(n_chains, 2.2), []))
        assert found.counts.tolist() == [2] * n_chains
        assert found.finished
    alone = CountsProblem.of([2.2, 3.0], [[[0]]])
    assert choose(alone).counts.tolist() == [4, 3]
    assert changed(alone, [4, 3], 1, 7).counts.tolist() == [4, 7]


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
        changed(problem, before, 4, 2)
    with pytest.raises(InvalidRetopoError, match="cannot have 0 edges"):
        changed(problem, before, 0, 0)
    with pytest.raises(InvalidRetopoError, match="choose them first"):
        changed(problem, before[1:], 0, 2)
