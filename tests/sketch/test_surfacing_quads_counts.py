"""Edge counts: every cycle even, at the least change that there is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from networks import cube, faces_network, prism, ring, shuffled, torus

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.surfacing.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.quads import count_even_edges
from patterndb_sketch.surfacing.sampling import edges_at, loop_of, sample, stretches

TETRAHEDRON = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]
#: Walks round a tetrahedron over four of its edges: with the faces, edges are in four cycles.
WALKS = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2]]


def totals(network: CurveNetwork, edges: tuple[tuple[int, ...], ...]) -> list[int]:
    """The number of edges around every cycle."""
    return [sum(sum(edges[curve]) for curve in cycle.curves) for cycle in network.cycles]


def wanted(network: CurveNetwork, spacing: float) -> list[tuple[float, int]]:
    """Of every stretch of all curves how many edges are wanted, and the fewest."""
    result = []
    for curve in network.curves:
        fewest = edges_at(curve, math.inf)
        for part, few in zip(stretches(curve), fewest, strict=True):
            result.append((max(few, arc_length(part)[-1] / spacing), few))
    return result


def least_cost(network: CurveNetwork, spacing: float) -> float:
    """The least cost of even counts, of all that are near what is wanted or below six."""
    stretch = wanted(network, spacing)
    choices = [range(max(few, math.floor(w) - 1), max(math.ceil(w) + 2, 6)) for w, few in stretch]
    costs = [
        np.array([math.log(n / w) ** 2 for n in choice])
        for choice, (w, _) in zip(choices, stretch, strict=True)
    ]
    owner = np.repeat(np.arange(len(network.curves)), [len(stretches(c)) for c in network.curves])
    grids = np.meshgrid(*choices, indexing="ij", sparse=True)
    cost = sum(np.meshgrid(*costs, indexing="ij", sparse=True), np.zeros(()))
    sound = np.ones(cost.shape, bool)
    for cycle in network.cycles:
        total = sum(grids[s] for s in range(len(owner)) if owner[s] in cycle.curves)
        sound &= (total % 2 == 0) & (total >= 4)
    return float(cost[sound].min())


def drawn(seed: int, faces: list[list[int]]) -> CurveNetwork:
    """Faces of random points."""
    points = np.random.default_rng(seed).uniform(-1, 1, (4, 3))
    return faces_network(points, faces)


def lens(seed: int) -> CurveNetwork:
    """Three curves with two corners each between two nodes, and the cycles that they make."""
    rng = np.random.default_rng(seed)
    ends = np.array([[0, 0, 0], [3, 0, 0]], float)
    curves = []
    for number in range(3):
        inner = np.array([[1, 1, 0], [2, -1, 1]]) + rng.uniform(-0.3, 0.3, (2, 3))
        points = np.concatenate([ends[:1], inner, ends[1:]])
        curves.append(Curve(points, (0, 1), number, number))
    cycles = tuple(Cycle(((a, False), (b, True))) for a, b in ((0, 1), (1, 2), (2, 0)))
    return CurveNetwork(tuple(curves), ends, cycles)


@settings(max_examples=40)
@given(
    st.integers(0, 2**32),
    st.sampled_from([TETRAHEDRON, TETRAHEDRON[:2], TETRAHEDRON[:1], TETRAHEDRON + WALKS, WALKS]),
    st.floats(0.3, 3.0),
)
def test_no_other_even_counts_change_less(
    seed: int, faces: list[list[int]], spacing: float
) -> None:
    network = drawn(seed, faces)
    found = count_even_edges(network, network.cycles, spacing)
    assert found.least
    assert all(total % 2 == 0 and total >= 4 for total in totals(network, found.edges))
    assert found.cost == pytest.approx(least_cost(network, spacing), abs=1e-9)
    counts = [n for edges in found.edges for n in edges]
    told = sum(
        math.log(n / w) ** 2 for n, (w, _) in zip(counts, wanted(network, spacing), strict=True)
    )
    assert found.cost == pytest.approx(told, abs=1e-12)


@settings(max_examples=15)
@given(st.integers(0, 2**32), st.floats(0.5, 6.0))
def test_stretches_of_a_curve_share_its_change(seed: int, spacing: float) -> None:
    network = lens(seed)
    assert [len(stretches(curve)) for curve in network.curves] == [3, 3, 3]
    # Six cubed thrice is too much to try: one cycle of the three, and its two curves.
    one = CurveNetwork(network.curves[:2], network.nodes, network.cycles[:1])
    found = count_even_edges(one, one.cycles, spacing)
    assert found.cost == pytest.approx(least_cost(one, spacing), abs=1e-9)
    assert all(total % 2 == 0 and total >= 4 for total in totals(one, found.edges))
    found = count_even_edges(network, network.cycles, spacing)
    assert all(total % 2 == 0 and total >= 4 for total in totals(network, found.edges))


@pytest.mark.parametrize("make", [cube, prism, torus, lambda: ring(circle(60))])
@pytest.mark.parametrize("spacing", [0.13, 0.4, 1.7, 100.0])
def test_every_loop_is_even_and_keeps_its_shape(make: object, spacing: float) -> None:
    network: CurveNetwork = make()  # pyright: ignore[reportCallIssue]
    found = count_even_edges(network, network.cycles, spacing)
    assert found.least
    counts = [n for edges in found.edges for n in edges]
    fewest = [n for curve in network.curves for n in edges_at(curve, math.inf)]
    assert all(n >= few for n, few in zip(counts, fewest, strict=True))
    sampling = sample(network, spacing, found.edges)
    for cycle in network.cycles:
        n = len(loop_of(network, sampling, cycle).points)
        assert n >= 4 and n % 2 == 0


@settings(max_examples=10)
@given(st.integers(0, 2**32), st.floats(0.2, 2.0))
def test_the_order_and_sense_of_the_input_change_no_cost(seed: int, spacing: float) -> None:
    network = torus(5, 3)
    other = shuffled(network, seed)
    one = count_even_edges(network, network.cycles, spacing)
    two = count_even_edges(other, other.cycles, spacing)
    assert one.cost == pytest.approx(two.cost, abs=1e-9)
    assert one == count_even_edges(network, network.cycles, spacing)


def test_curves_of_no_cycle_have_the_nearest_number() -> None:
    network = cube()
    found = count_even_edges(network, (), 0.3)
    assert set(found.edges) == {(3,)}
    assert found.cost == pytest.approx(12 * math.log(0.9) ** 2)


def test_without_time_to_search_cycles_are_even_all_the_same() -> None:
    rng = np.random.default_rng(1)
    network = torus(12, 12)
    points = network.nodes + rng.normal(0, 0.02, network.nodes.shape)
    faces = [list(network.walk(cycle)) for cycle in network.cycles]
    network = faces_network(points, faces)
    hurried = count_even_edges(network, network.cycles, 0.24, most_work=1e-6)
    assert not hurried.least
    assert all(total % 2 == 0 and total >= 4 for total in totals(network, hurried.edges))
    assert count_even_edges(network, network.cycles, 0.24).cost < hurried.cost


def test_what_is_refused() -> None:
    network = cube()
    for spacing in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidNetworkError, match="spacing"):
            count_even_edges(network, network.cycles, spacing)
    with pytest.raises(InvalidNetworkError, match="no curves"):
        count_even_edges(CurveNetwork((), np.zeros((0, 3))), ())
    with pytest.raises(InvalidNetworkError, match="breaks"):
        count_even_edges(network, [Cycle(((0, False), (0, False)))])


def circle(n: int) -> np.ndarray:
    turn = 2 * np.pi * np.arange(n) / n
    return np.stack([np.cos(turn), np.sin(turn), np.zeros(n)], axis=1)
