"""Curve networks: what they refuse, and what cycles are."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.curvenetwork.network import (
    Curve,
    CurveNetwork,
    Cycle,
    InvalidNetworkError,
    list_steps_at_nodes,
)
from patterndb_sketch.curvenetwork.polylines import measure_angles
from tests.support.surfacing.networks import cube, ring, shuffled, torus


def test_faces_of_a_cube_are_walks_of_four_nodes() -> None:
    network = cube()
    assert len(network.curves) == 12
    for cycle in network.cycles:
        nodes = network.walk(cycle)
        assert len(set(nodes)) == 4
        assert len(network.polyline(cycle)) == 4
        assert set(network.walk(cycle.turned)) == set(nodes)


def test_a_cycle_is_the_same_from_any_curve_on_in_either_sense() -> None:
    for cycle in torus().cycles:
        keys = set()
        for walk in (cycle.steps, cycle.turned.steps):
            for i in range(len(walk)):
                keys.add(Cycle(walk[i:] + walk[:i]).key)
        assert keys == {cycle.key}
    keys = {cycle.key for cycle in torus().cycles}
    assert len(keys) == 48


def test_shuffling_keeps_the_cycles() -> None:
    network = cube()
    other = shuffled(network, 5)
    names = {frozenset(network.names(cycle)) for cycle in network.cycles}
    assert {frozenset(other.names(cycle)) for cycle in other.cycles} == names


def test_every_curve_leaves_both_its_nodes() -> None:
    leaving = list_steps_at_nodes(ring(np.eye(3)))
    assert leaving == [[(0, False), (0, True)]]
    assert all(len(steps) == 3 for steps in list_steps_at_nodes(cube()))


def test_parts_of_one_curve_in_a_row_are_named_once() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0)]
    names = ["long", "long", "b", "long"]
    curves = tuple(
        Curve(points[[a, b]], (a, b), name, name) for (a, b), name in zip(pairs, names, strict=True)
    )
    network = CurveNetwork(curves, points)
    cycle = Cycle(tuple((i, False) for i in range(4)))
    assert network.names(cycle) == ["long", "b"]


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        ((), "at least one curve"),
        (((0, False), (99, False)), "curve 99"),
        (((0, False), (1, False), (2, True)), "breaks"),
    ],
)
def test_walks_that_are_no_cycles_are_refused(
    steps: tuple[tuple[int, bool], ...], message: str
) -> None:
    with pytest.raises(InvalidNetworkError, match=message):
        cube().walk(Cycle(steps))


def test_a_walk_that_passes_a_node_twice_is_refused() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    network = CurveNetwork.from_edges(points, [[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]])
    network.walk(Cycle(((0, False), (1, False), (2, False))))
    with pytest.raises(InvalidNetworkError, match=r"passes node 0 .* twice"):
        network.walk(Cycle(tuple((i, False) for i in range(6))))


@pytest.mark.parametrize(
    ("points", "nodes", "message"),
    [
        ([[0, 0, 0]], (0, 0), "two points"),
        ([[0, 0, 0], [0, 0, 0], [1, 0, 0]], (0, 1), "one place"),
        ([[0, 0, 0], [np.nan, 0, 0], [1, 0, 0]], (0, 1), "not finite"),
        ([[0, 0, 0], [2, 0, 0]], (0, 1), "not at its node 1"),
        ([[0, 0, 0], [1, 0, 0]], (0, 7), "not at its node 7"),
    ],
)
def test_curves_that_are_none_are_refused(
    points: list[list[float]], nodes: tuple[int, int], message: str
) -> None:
    ends = np.array([[0.0, 0, 0], [1, 0, 0]])
    with pytest.raises(InvalidNetworkError, match=message):
        CurveNetwork((Curve(np.array(points, float), nodes, "c", "c"),), ends)


def test_angles_keep_their_precision_near_zero_and_half_a_turn() -> None:
    tiny = 1e-9
    a = np.array([[1.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]])
    b = np.array([[1.0, tiny, 0], [-1.0, tiny, 0], [0, 2.0, 0]])
    assert np.allclose(measure_angles(a, b), [tiny, np.pi - tiny, np.pi / 2], rtol=1e-12)
