"""Corners are those of the curves as drawn; and no cost depends on how the input is written."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.chords import decompose, find_endpoints
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)
from tests.support.surfacing.chords import SHAPES, ring, ring_network


def polygon(n: int) -> np.ndarray:
    angles = np.linspace(0, 2 * math.pi, n + 1)
    points = np.c_[np.cos(angles), np.sin(angles), 0 * angles]
    points[-1] = points[0]
    return points


@pytest.mark.parametrize("spacing", [None, 0.05, 0.3, 0.9])
def test_a_square_has_4_corners_however_it_is_sampled(spacing: float | None) -> None:
    square = polygon(4)
    closed = ring([square], spacing)
    sides = ring([square[i : i + 2] for i in range(4)], spacing)
    for loop in (closed, sides):
        assert loop.corners.sum() == 4
        found = loop.points[loop.corners]
        gaps = np.linalg.norm(found[:, None] - square[None, :4], axis=2).min(axis=0)
        assert gaps.max() < 1e-12
        assert set(np.flatnonzero(loop.corners)) <= set(find_endpoints(loop).tolist())


@pytest.mark.parametrize("spacing", [None, 0.05, 0.3, 0.9])
def test_a_circle_of_64_edges_has_no_corner_however_coarsely_it_is_sampled(
    spacing: float | None,
) -> None:
    assert ring([polygon(64)], spacing).corners.sum() == 0


@pytest.mark.parametrize(("degrees", "corners"), [(19.9, 0), (20.1, 1)])
def test_a_corner_turns_by_more_than_20_degrees(degrees: float, corners: int) -> None:
    turn = math.radians(degrees)
    bent = np.array([[0, 0, 0], [1, 0, 0], [1 + math.cos(turn), math.sin(turn), 0]])
    loop = ring([bent, np.array([bent[-1], [1, 3, 0], bent[0]])], 0.1)
    inner = loop.corners & (np.abs(loop.points - bent[1]).max(axis=1) < 1e-12)
    assert inner.sum() == corners


@given(st.integers(3, 40), st.floats(0.02, 2.0))
def test_corners_are_kept_where_a_curve_is_sampled(n: int, spacing: float) -> None:
    rng = np.random.default_rng(n)
    points = np.cumsum(rng.normal(size=(n, 3)), axis=0)
    network = CurveNetwork((Curve(points, (0, 1), 0, 0),), points[[0, -1]])
    sampling = sample(network, spacing)
    steps = np.diff(points, axis=0)
    cosines = (steps[:-1] * steps[1:]).sum(axis=1) / (
        np.linalg.norm(steps[:-1], axis=1) * np.linalg.norm(steps[1:], axis=1)
    )
    drawn = points[1:-1][cosines < math.cos(math.radians(20))]
    assert np.allclose(sampling.points[sampling.corners], drawn, atol=1e-12)


def rewritten(
    network: CurveNetwork, cycle: Cycle, rng: np.random.Generator
) -> tuple[CurveNetwork, Cycle]:
    """The same curves in another order, some reversed, and the cycle begun elsewhere."""
    order = rng.permutation(len(network.curves))
    place = np.argsort(order)
    reverse = rng.integers(0, 2, len(order)).astype(bool)
    nodes = rng.permutation(len(network.nodes))
    node_place = np.argsort(nodes)
    curves = []
    for number in order:
        curve = network.curves[number]
        a, b = (int(node_place[node]) for node in curve.nodes)
        turned = bool(reverse[number])
        points = curve.points[::-1] if turned else curve.points
        curves.append(Curve(points, (b, a) if turned else (a, b), curve.id, curve.stroke))
    steps = tuple((int(place[c]), bool(back) != bool(reverse[c])) for c, back in cycle.steps)
    start = int(rng.integers(len(steps)))
    again = Cycle(steps[start:] + steps[:start])
    return CurveNetwork(tuple(curves), network.nodes[nodes]), (
        again.turned if rng.integers(2) else again
    )


@pytest.mark.parametrize("name", SHAPES)
@settings(max_examples=12)
@given(seed=st.integers(0, 2**32 - 1), alpha=st.sampled_from([0.0, 0.1, 0.4]))
def test_order_and_orientation_of_the_input_change_no_cost(
    name: str, seed: int, alpha: float
) -> None:
    network, cycle = ring_network(SHAPES[name]())
    rng = np.random.default_rng(seed)
    expected = decompose(loop_of(network, sample(network), cycle), alpha)
    other, turned = rewritten(network, cycle, rng)
    loop = loop_of(other, sample(other), turned)
    found = decompose(loop, alpha)
    assert found.cost == pytest.approx(expected.cost, abs=1e-9)
    assert found.n_subproblems == expected.n_subproblems
    assert len(found.candidates) == len(expected.candidates)


@pytest.mark.parametrize("name", SHAPES)
@given(start=st.integers(0, 1000), turned=st.booleans())
def test_start_and_sense_of_a_loop_change_no_cost(name: str, start: int, turned: bool) -> None:
    loop = ring(SHAPES[name]())
    expected = decompose(loop)
    order = np.roll(np.arange(len(loop.points)), -start)[:: -1 if turned else 1]
    found = decompose(Loop(loop.points[order], loop.corners[order], loop.vertices[order]))
    assert found.cost == pytest.approx(expected.cost, abs=1e-9)
    same = {frozenset(chord) for chord in order[found.candidates].tolist()}
    assert same == {frozenset(chord) for chord in expected.candidates.tolist()}
