"""Edge counts: every cycle even, and regular where the network allows it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.quads import count_even_edges
from patterndb_sketch.surfacing.sampling import (
    edges_at,
    loop_of,
    sample,
    stretches,
)
from tests.support.surfacing.networks import cube, faces_network, prism, ring, shuffled, torus

TETRAHEDRON = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]
#: Walks round a tetrahedron over four of its edges: with the faces, edges are in four cycles.
WALKS = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2]]


def totals(network: CurveNetwork, edges: tuple[tuple[int, ...], ...]) -> list[int]:
    """The number of edges around every cycle."""
    return [sum(sum(edges[curve]) for curve in cycle.curves) for cycle in network.cycles]


def assert_sound(network: CurveNetwork, edges: tuple[tuple[int, ...], ...]) -> None:
    """Every cycle is even, of four edges or more, and every stretch keeps its shape."""
    assert all(total % 2 == 0 and total >= 4 for total in totals(network, edges))
    for curve, of_curve in zip(network.curves, edges, strict=True):
        fewest = edges_at(curve, math.inf)
        assert len(of_curve) == len(fewest)
        assert all(n >= few for n, few in zip(of_curve, fewest, strict=True))


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


@settings(max_examples=10, deadline=None)
@given(
    st.integers(0, 2**32),
    st.sampled_from([TETRAHEDRON, TETRAHEDRON[:2], TETRAHEDRON[:1], TETRAHEDRON + WALKS, WALKS]),
    st.floats(0.1, 3.0),
)
def test_cycles_are_even_however_many_share_a_curve(
    seed: int, faces: list[list[int]], spacing: float
) -> None:
    points = np.random.default_rng(seed).uniform(-1, 1, (4, 3))
    network = faces_network(points, faces)
    found = count_even_edges(network, network.cycles, spacing)
    assert_sound(network, found.edges)
    assert found == count_even_edges(network, network.cycles, spacing)


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**32), st.floats(0.5, 6.0))
def test_stretches_of_a_curve_count_each(seed: int, spacing: float) -> None:
    network = lens(seed)
    assert [len(stretches(curve)) for curve in network.curves] == [3, 3, 3]
    assert_sound(network, count_even_edges(network, network.cycles, spacing).edges)


@settings(max_examples=8, deadline=None)
@given(
    st.integers(5, 9), st.integers(4, 6), st.integers(0, 2**32), st.floats(0.2, 1.0), st.booleans()
)
def test_a_torus_of_four_sided_cells_is_a_regular_grid(
    m: int, n: int, seed: int, spacing: float, mixed: bool
) -> None:
    """Curves inside are half as long as those outside; opposite sides have equal numbers."""
    network = torus(m, n)
    if mixed:
        network = shuffled(network, seed)
    found = count_even_edges(network, network.cycles, spacing)
    assert_sound(network, found.edges)
    assert found.irregular == ()
    for cycle in network.cycles:
        one, two, three, four = (sum(found.edges[curve]) for curve in cycle.curves)
        assert (one, two) == (three, four)


def test_a_side_of_several_curves_has_as_many_edges_as_the_one_across() -> None:
    """Two cells below a long one: the sum of both is what lies across, not each by itself."""
    points = [[0, 0, 0], [1.1, 0, 0], [2, 0, 0], [2, 1, 0], [1.1, 1, 0], [0, 1, 0], [2, 2, 0]]
    points += [[0, 2, 0]]
    faces = [[0, 1, 4, 5], [1, 2, 3, 4], [5, 4, 3, 6, 7]]
    network = faces_network(points, faces)
    for spacing in (0.09, 0.13, 0.21, 0.34):
        found = count_even_edges(network, network.cycles, spacing)
        assert_sound(network, found.edges)
        assert found.irregular == ()
        upper = [sum(found.edges[curve]) for curve in network.cycles[2].curves]
        assert upper[0] + upper[1] == upper[3]
        assert upper[2] == upper[4]


def test_a_cycle_with_a_reflex_corner_is_even() -> None:
    points = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2.2, 0], [0, 2.2, 0]]
    network = faces_network(points, [[0, 1, 2, 3, 4, 5]])
    for spacing in (0.1, 0.27, 0.9, 5.0):
        assert_sound(network, count_even_edges(network, network.cycles, spacing).edges)


@pytest.mark.parametrize("make", [cube, prism, torus, lambda: ring(circle(60))])
@pytest.mark.parametrize("spacing", [0.13, 0.4, 1.7, 100.0])
def test_every_loop_is_even_and_keeps_its_shape(make: object, spacing: float) -> None:
    network: CurveNetwork = make()  # pyright: ignore[reportCallIssue]
    found = count_even_edges(network, network.cycles, spacing)
    assert_sound(network, found.edges)
    assert found.irregular == ()
    sampling = sample(network, spacing, found.edges)
    for cycle in network.cycles:
        n = len(loop_of(network, sampling, cycle).points)
        assert n >= 4 and n % 2 == 0


def test_counts_follow_the_spacing() -> None:
    network = cube()
    for n in (2, 3, 5, 8):
        assert set(count_even_edges(network, network.cycles, 1.0 / n).edges) == {(n,)}


def test_curves_of_no_cycle_have_the_nearest_number() -> None:
    assert set(count_even_edges(cube(), (), 0.3).edges) == {(3,)}


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
