"""The steps of finding cycles, each against a slow way that is plainly right."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from patterndb._native.geometry.leastarea import triangulate_cheapest
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.cycles import choosing, closing, find_cycles, packing
from patterndb_sketch.surfacing.cycles.chains import chain_curves, order_chains
from patterndb_sketch.surfacing.cycles.choosing import CycleChoice, choose_cycles
from patterndb_sketch.surfacing.cycles.closing import (
    NO_PLANE,
    OFF_PLANE,
    find_candidate_cycles,
    find_dangling,
    group_components,
    list_half_curves,
)
from patterndb_sketch.surfacing.cycles.found import find_pinches, orient_cycles
from patterndb_sketch.surfacing.cycles.measures import measure_cycles, price_folds, rate_badness
from patterndb_sketch.surfacing.cycles.packing import CycleProblem, bound_choices
from tests.support.surfacing.networks import cube, torus

#: Curves, gains, costs, forced, excluded and full, as choose() has them.
Packing = tuple[
    list[list[int]],
    list[float],
    dict[tuple[int, int], float],
    set[int],
    list[tuple[int, ...]],
    tuple[int, ...],
]


def value_of(
    subset: tuple[int, ...], gains: list[float], costs: dict[tuple[int, int], float]
) -> float:
    pairs = itertools.combinations(subset, 2)
    return sum(gains[i] for i in subset) - sum(costs.get(pair, 0.0) for pair in pairs)


@st.composite
def packings(draw: st.DrawFn) -> Packing:
    k = draw(st.integers(1, 7))
    curves = [sorted(draw(st.sets(st.integers(0, 5), min_size=1, max_size=4))) for _ in range(k)]
    gains = [draw(st.integers(-20, 40)) / 10 for _ in range(k)]
    pairs = list(itertools.combinations(range(k), 2))
    costs = {p: draw(st.integers(0, 30)) / 10 for p in pairs if draw(st.booleans())}
    forced = {i for i in range(k) if draw(st.integers(0, 4)) == 0}
    excluded = [
        tuple(sorted(draw(st.sets(st.integers(0, k - 1), min_size=2, max_size=3))))
        for _ in range(draw(st.integers(0, 2)) if k > 3 else 0)
    ]
    full = draw(st.sampled_from([(), (), (), (0,), (0, 1)]))
    return curves, gains, costs, forced, excluded, full


def assert_allowed(choice: CycleChoice | None, exact: CycleChoice | None, case: Packing) -> None:
    """Hold a choice to what any must be, and to the best one: at most as good, and so if proven."""
    curves, gains, costs, forced, excluded, _ = case
    assert (choice is None) == (exact is None)
    if choice is None or exact is None:
        return
    assert max(sum(c in curves[i] for i in choice.chosen) for c in range(6)) <= 2
    assert forced <= set(choice.chosen)
    assert not any(set(group) <= set(choice.chosen) for group in excluded)
    assert choice.value == pytest.approx(value_of(choice.chosen, gains, costs), abs=1e-6)
    assert choice.value <= exact.value + 1e-6
    if choice.proven:
        assert choice.value == pytest.approx(exact.value, abs=1e-3)


@settings(max_examples=150, deadline=None)
@given(packings())
def test_the_choice_is_the_best_of_all_subsets(case: Packing) -> None:
    curves, gains, costs, forced, excluded, full = case
    best = -math.inf
    for size in range(len(curves) + 1):
        for subset in itertools.combinations(range(len(curves)), size):
            count = [sum(c in curves[i] for i in subset) for c in range(6)]
            if max(count) > 2 or any(count[c] != 2 for c in full) or not forced <= set(subset):
                continue
            if any(set(group) <= set(subset) for group in excluded):
                continue
            best = max(best, value_of(subset, gains, costs))
    choice = choose_cycles(
        CycleProblem(curves, gains, costs, forced=forced, excluded=excluded, full=full)
    )
    if best == -math.inf:
        assert choice is None
        return
    assert choice is not None and choice.proven
    assert choice.value == pytest.approx(best, abs=1e-6)
    assert value_of(choice.chosen, gains, costs) == pytest.approx(best, abs=1e-6)


@settings(max_examples=150, deadline=None)
@given(packings(), st.booleans())
def test_a_choice_among_the_likely_is_called_the_best_only_if_it_is(
    case: Packing, prove: bool
) -> None:
    curves, gains, costs, forced, excluded, full = case
    problem = CycleProblem(curves, gains, costs, forced=forced, excluded=excluded, full=full)
    exact = choose_cycles(problem)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(packing, "LEAST_LIKELY", 1)
        choice = choose_cycles(problem, prove=prove)
    assert_allowed(choice, exact, case)


@settings(max_examples=150, deadline=None)
@given(packings(), st.integers(0, 20), st.integers(0, 2))
def test_no_choice_is_worth_more_than_its_bounds(case: Packing, sweeps: int, spare: int) -> None:
    curves, gains, costs, _, _, full = case
    room = dict.fromkeys(range(6), 2) | {1: max(spare, 1)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(packing, "SWEEPS", sweeps)
        problem = CycleProblem(curves, gains, costs, room, full=full)
        bounds = bound_choices(problem, range(len(curves)))
    assert bounds is not None
    for size in range(len(curves) + 1):
        for subset in itertools.combinations(range(len(curves)), size):
            count = [sum(c in curves[i] for i in subset) for c in range(6)]
            if any(n > room[c] for c, n in enumerate(count)):
                continue
            if any(count[c] != room[c] for c in full):
                continue
            value = value_of(subset, gains, costs)
            assert value <= bounds.best + 1e-6
            assert all(value <= bounds.most[i] + 1e-6 for i in subset)


def test_bounds_of_a_path_of_candidates_are_exact() -> None:
    # Of a tree the dual has no gap: the best choice and its bound are the same.
    curves = [[0, 1], [1, 2], [2, 3], [1, 3]]
    gains = [3.0, 5.0, 3.0, 1.0]
    room = dict.fromkeys(range(4), 1)
    bounds = bound_choices(CycleProblem(curves, gains, {(0, 1): math.inf}, room), range(3))
    assert bounds is not None and bounds.best == pytest.approx(6.0)
    assert 5.0 <= bounds.most[1] < 6.0, "the one between is not of the best choice"
    assert bounds.most[3] == -math.inf, "it was not asked for"


def test_tables_too_large_are_not_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packing, "MOST_PAIRS", 3)
    problem = CycleProblem([[0], [0]], [1.0, 2.0])
    assert bound_choices(problem, [0, 1]) is None
    choice = choose_cycles(problem)
    assert choice is not None and choice.chosen == (0, 1)


@settings(max_examples=150, deadline=None)
@given(packings())
def test_a_choice_by_windows_keeps_to_the_rules_and_is_proven_only_if_it_is_the_best(
    case: Packing,
) -> None:
    curves, gains, costs, forced, excluded, _ = case
    problem = CycleProblem(curves, gains, costs, forced=forced, excluded=excluded)
    exact = choose_cycles(problem)
    with pytest.MonkeyPatch.context() as patch:
        for name, size in (("MOST_AT_ONCE", 0), ("WINDOW", 3), ("CORE", 2)):
            patch.setattr(choosing, name, size)
        choice = choose_cycles(problem)
    assert_allowed(choice, exact, case)


@pytest.mark.parametrize("effort", [0.0, 1e-9])
def test_a_solver_out_of_time_leaves_a_greedy_choice(effort: float) -> None:
    choice = choose_cycles(CycleProblem([[0], [0], [0]], [1.0, 2.0, 3.0]), effort)
    assert choice is not None and choice.chosen == (1, 2)


def test_a_large_grid_has_all_its_squares() -> None:
    n = 24
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    points = np.stack([at // (n + 1), at % (n + 1), 0 * at], axis=-1).reshape(-1, 3).astype(float)
    across = np.stack([at[:, :-1], at[:, 1:]], axis=-1).reshape(-1, 2)
    along = np.stack([at[:-1], at[1:]], axis=-1).reshape(-1, 2)
    found = find_cycles(CurveNetwork.from_edges(points, np.concatenate([across, along])))
    assert found.proven and found.candidates > choosing.MOST_AT_ONCE
    assert len(found.cycles) == n * n
    assert {len(cycle.steps) for cycle in found.cycles} == {4}


#: The number of nodes whose ways are known, as in rust/surfacing/src/cycles/closing.rs.
NEAR_NODES = 512


@pytest.mark.parametrize(("n", "m"), [(12, 20), (700, 1_500)])
def test_ways_beyond_the_near_nodes_are_bounded_from_below(n: int, m: int) -> None:
    network = random_network(np.random.default_rng(5), n, m)
    halves = list_half_curves(network, np.ones(m, bool))
    weights = np.zeros((n, n))
    for curve in network.curves:
        a, b = curve.nodes
        weights[a, b] = weights[b, a] = curve.length
    expected = dijkstra(weights, directed=False)
    for target in range(0, n, n // 12):
        distance = np.full(n, np.inf)
        near = np.empty(n, np.int64)
        met, farther = closing.measure_ways(
            halves.end, halves.length, halves.first, halves.leaving, target, distance, near
        )
        assert np.isfinite(distance[near[:met]]).all() and np.isfinite(distance).sum() == met
        bound = np.minimum(distance, farther)
        assert (bound <= expected[target] + 1e-12).all()
        known = distance < farther
        assert np.allclose(distance[known], expected[target][known])
        n_reached = int(np.isfinite(expected[target]).sum())
        assert known.sum() >= min(NEAR_NODES, n_reached)
        assert np.isfinite(farther) == (n_reached > NEAR_NODES)


def test_a_choice_below_what_it_should_be_worth_is_none() -> None:
    assert choose_cycles(CycleProblem([[0], [0]], [1.0, 2.0], least=3.1)) is None
    choice = choose_cycles(CycleProblem([[0], [0]], [1.0, 2.0], least=2.9))
    assert choice is not None and choice.chosen == (0, 1)


def random_network(rng: np.random.Generator, n: int, m: int) -> CurveNetwork:
    points = rng.normal(size=(n, 3))
    pairs = list(itertools.combinations(range(n), 2))
    edges = [pairs[i] for i in rng.choice(len(pairs), m, replace=False)]
    return CurveNetwork.from_edges(points, edges)


def all_cycles(network: CurveNetwork) -> dict[frozenset[int], float]:
    """All simple cycles of three curves or more, and their lengths."""
    at: dict[int, list[tuple[int, int]]] = {}
    for i, curve in enumerate(network.curves):
        for a, b in (curve.nodes, curve.nodes[::-1]):
            at.setdefault(a, []).append((i, b))
    found: dict[frozenset[int], float] = {}

    def walk(first: int, node: int, seen: list[int], used: list[int]) -> None:
        for curve, other in at.get(node, []):
            if other == first and len(used) > 1 and curve not in used:
                key = frozenset([*used, curve])
                found[key] = sum(network.curves[c].length for c in key)
            elif other not in seen and other > first:
                walk(first, other, [*seen, other], [*used, curve])

    for first in range(len(network.nodes)):
        walk(first, first, [first], [])
    return found


@pytest.mark.parametrize("seed", range(8))
def test_the_shortest_cycles_of_every_pair_of_curves_are_candidates(seed: int) -> None:
    network = random_network(np.random.default_rng(seed), 7, 12)
    everything = all_cycles(network)
    alive = ~find_dangling(network)
    found, cut_short = find_candidate_cycles(network, list_half_curves(network, alive), 3)
    assert not cut_short
    expected: set[frozenset[int]] = set()
    for a, b in itertools.combinations(range(len(network.curves)), 2):
        meeting = set(network.curves[a].nodes) & set(network.curves[b].nodes)
        if meeting:
            through = sorted((v, sorted(k)) for k, v in everything.items() if {a, b} <= k)
            # Two curves that meet and are both in a cycle are beside each other in it, or
            # another pair is at their node.
            through = [(v, k) for v, k in through if _beside(network, k, a, b)]
            expected |= {frozenset(k) for _, k in through[:3]}
    flat = [cycle for key, cycle in found.items() if frozenset(key) not in expected]
    assert {frozenset(key) for key in found} >= expected
    assert all(_lies_in_a_plane(network, cycle) for cycle in flat)
    for key, cycle in found.items():
        network.walk(cycle)
        assert tuple(sorted(cycle.curves)) == key


def _lies_in_a_plane(network: CurveNetwork, cycle: Cycle) -> bool:
    """Do all straight curves of a cycle lie nearly in the plane of two of them that meet?"""
    ways = [network.along(step) for step in cycle.steps]
    ahead = np.array([(way[-1] - way[0]) / np.linalg.norm(way[-1] - way[0]) for way in ways])
    normals = np.cross(np.roll(ahead, 1, axis=0), ahead)
    sizes = np.linalg.norm(normals, axis=1)
    off = np.abs(ahead @ (normals / sizes[:, None]).T).max(axis=0)
    return bool((off[sizes >= NO_PLANE] <= OFF_PLANE).any())


def _beside(network: CurveNetwork, key: list[int], a: int, b: int) -> bool:
    node = next(iter(set(network.curves[a].nodes) & set(network.curves[b].nodes)))
    return {c for c in key if node in network.curves[c].nodes} == {a, b}


def test_every_curve_of_a_tree_dangles() -> None:
    tree = CurveNetwork.from_edges(
        np.eye(6, 3) + np.arange(6)[:, None], [[0, 1], [1, 2], [1, 3], [3, 4]]
    )
    assert find_dangling(tree).all()
    assert group_components(tree, ~find_dangling(tree)) == []
    assert [len(c) for c in group_components(tree, np.ones(4, bool))] == [4]


def plain_least_area(points: NDArray[np.float64]) -> float:
    """The least area over all triangulations, by recursion."""
    n = len(points)

    def best(i: int, j: int) -> float:
        if j - i < 2:
            return 0.0
        return min(
            best(i, k)
            + best(k, j)
            + float(np.linalg.norm(np.cross(points[k] - points[i], points[j] - points[i]))) / 2
            for k in range(i + 1, j)
        )

    return best(0, n - 1)


@pytest.mark.parametrize("n", range(3, 10))
def test_the_spanned_surface_has_the_least_area(n: int) -> None:
    points = np.random.default_rng(n).normal(size=(n, 3))
    triangles = np.empty((n - 2, 3), np.int64)
    area = triangulate_cheapest(points, 0.0, 0.0, triangles)
    assert area == pytest.approx(plain_least_area(points))
    corners = points[triangles]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(sides, axis=1).sum() / 2 == pytest.approx(area)


def test_measures_of_a_square_of_a_cube() -> None:
    network = cube()
    measures = measure_cycles(network, list_half_curves(network, np.ones(12, bool)), network.cycles)
    np.testing.assert_allclose(measures.length, 4.0)
    np.testing.assert_allclose(measures.area, 1.0)
    np.testing.assert_allclose(measures.corners, 4.0)
    for name in ("flatness", "bending", "cuts"):
        np.testing.assert_allclose(getattr(measures, name), 0.0, atol=1e-7)
    # Inward is towards the middle of the face, across the edge.
    at = 0
    for cycle in network.cycles:
        middle = network.polyline(cycle).mean(axis=0)
        for step in cycle.steps:
            inward = middle - network.along(step).mean(axis=0)
            np.testing.assert_allclose(
                measures.inward[at], inward / np.linalg.norm(inward), atol=1e-9
            )
            at += 1


def test_a_curve_that_runs_into_the_surface_cuts_it() -> None:
    # A square of side 2 with one corner joined to its middle, and on to another side.
    points = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 0]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [4, 2]]
    network = CurveNetwork.from_edges(points, edges)
    outer = Cycle(tuple((i, False) for i in range(4)))
    half = Cycle(((0, False), (1, False), (5, True), (4, True)))
    measures = measure_cycles(network, list_half_curves(network, np.ones(6, bool)), [outer, half])
    assert measures.cuts[0] == pytest.approx(2.0)
    assert measures.cuts[1] == 0.0
    bad = rate_badness(measures, np.array([4.0, 4.0]), np.array([4.0, 4.0]))
    assert bad[0] > bad[1]


def test_cycles_on_each_other_fold_and_cycles_beside_each_other_do_not() -> None:
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, -1, 0], [0, -1, 0]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 4], [4, 5], [5, 0]]
    network = CurveNetwork.from_edges(points, edges)
    square = Cycle(((0, False), (1, False), (2, False), (3, False)))
    triangle = Cycle(((0, False), (1, False), (4, True)))
    below = Cycle(((0, False), (5, False), (6, False), (7, False)))
    cycles = [square, triangle, below]
    measures = measure_cycles(network, list_half_curves(network, np.ones(8, bool)), cycles)
    first = np.cumsum([0, 4, 3, 4])
    inward = [measures.inward[a:b] for a, b in itertools.pairwise(first)]
    cost = price_folds(cycles, inward, np.ones(8))
    assert set(cost) == {(0, 1)}
    assert cost[0, 1] == pytest.approx(2.0)  # the two curves that both have


def test_curves_in_their_own_order_lead_back() -> None:
    network = torus(5, 4)
    own = order_chains(chain_curves(network, np.zeros(len(network.curves), bool)))
    steps = [step for chain in own.chains for step in chain]
    assert sorted(curve for curve, _ in steps) == list(range(len(network.curves)))
    for cycle in network.cycles:
        assert own.there(own.here(cycle)) == cycle
        own.network.walk(own.here(cycle))


def test_faces_are_turned_alike_whatever_their_sense_was() -> None:
    network = torus(5, 4)
    rng = np.random.default_rng(0)
    mixed = [cycle.turned if rng.integers(2) else cycle for cycle in network.cycles]
    result = orient_cycles(mixed)
    assert not result.twisted
    assert set(result.surfaces) == {0}
    steps = [step for cycle in result.cycles for step in cycle.steps]
    assert len(set(steps)) == len(steps) == 2 * len(network.curves)


def test_two_tetrahedra_that_share_a_corner_are_pinched() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    points = np.concatenate([points, -points[1:]])
    bodies = [(0, 1, 2, 3), (0, 4, 5, 6)]
    edges = [pair for body in bodies for pair in itertools.combinations(body, 2)]
    network = CurveNetwork.from_edges(points, edges)
    number = {pair: i for i, pair in enumerate(edges)}
    cycles = []
    for body in bodies:
        for a, b, c in itertools.combinations(body, 3):
            cycles.append(
                Cycle(((number[a, b], False), (number[b, c], False), (number[a, c], True)))
            )
    assert find_pinches(network, cycles[:4]) == []
    assert [node for node, _ in find_pinches(network, cycles)] == [0, 0]
    assert find_pinches(network, cycles)[0][1] == (0, 1, 2)
