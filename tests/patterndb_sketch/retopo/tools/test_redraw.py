"""Redrawing the part of a chain between two places."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    Chain,
    Network,
    add_borders,
    check_network,
    set_choice,
    set_count,
)
from patterndb_sketch.retopo.tools.redraw import redraw_chain
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from tests.support.retopo.networks import SIZES, chain_between, drawn, flat, plane, square


def off_line(points: np.ndarray, line: np.ndarray) -> float:
    """How far the points are off a polyline, at most."""
    a, b = line[:-1], line[1:]
    way = b - a
    share = np.einsum("nsc,sc->ns", points[:, None] - a, way) / (way**2).sum(axis=1)
    foot = a + np.clip(share, 0.0, 1.0)[..., None] * way
    return float(np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1).max())


def test_the_part_between_the_stroke_s_ends_runs_along_it_and_the_rest_stays() -> None:
    network = square()
    side = chain_between(network, (0, 0), (2, 0))
    network = set_count(network, side, 7, True)
    (patch,) = network.patches
    network = set_choice(network, patch, "a fill")
    old = network.chains[side]
    bow = [[0.5, 0.03], [1.0, -0.3], [1.5, -0.02]]
    for stroke in (flat(bow), flat(bow[::-1])):
        edit = redraw_chain(network, plane(), SIZES, stroke)
        check_network(edit.network)
        assert (edit.nodes, edit.chains, edit.patches, edit.notes) == ((), (), (), ())
        assert edit.network.patches == network.patches
        line = edit.network.chains[side]
        assert (line.count, line.pinned) == (7, True)
        assert line.points[:, 1].min() < -0.27
        steps = np.diff(arc_length(line.points))
        assert steps.max() < 1.1 * SIZES.sampling and steps.min() > 0.5 * SIZES.sampling
        x = old.points[:, 0]
        kept = {tuple(p) for p in old.points[(x < 0.49) | (x > 1.51)]}
        assert kept <= {tuple(p) for p in line.points}
        others = network.chains.keys() - {side}
        assert all(edit.network.chains[k] is network.chains[k] for k in others)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_redrawing_along_the_curve_itself_changes_nothing_but_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    closed = bool(rng.random() < 0.5)
    turn = np.linspace(0.0, 2.0 * np.pi * (1.0 if closed else 0.7), 60, endpoint=not closed)
    shape = np.c_[1.3 * np.cos(turn), np.sin(turn)]
    network = insert_stroke(Network(), plane(), SIZES, flat(shape, closed)).network
    (line,) = network.chains.values()
    n = len(line.points)
    begin = int(rng.integers(n))
    size = int(rng.integers(20, n // 2))
    k = np.arange(begin, begin + size)
    # An open one keeps clear of its ends, which draw the stroke to themselves.
    k = k % n if closed else k[(k > 6) & (k < n - 7)]
    if len(k) < 8:
        return
    part = line.points[k] if rng.random() < 0.5 else line.points[k][::-1]
    done = redraw_chain(network, plane(), SIZES, flat(part[:, :2])).network
    check_network(done)
    new = done.chains[line.id]
    assert off_line(new.points, line.round) < 1e-9
    assert off_line(line.points, new.round) < 0.1 * SIZES.sampling
    assert abs(new.length - line.length) < 1e-3 * line.length
    # Samples go the same way round.
    at = [int(np.argmin(np.linalg.norm(line.points - p, axis=1))) for p in new.points]
    steps = np.diff(at)
    assert ((steps >= 0) | (steps < -n // 2)).all()


def test_the_nearer_part_of_a_closed_curve_goes_with_a_node_or_without() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    ring = insert_stroke(
        Network(), plane(), SIZES, flat(np.c_[np.cos(turn), np.sin(turn)], True)
    ).network
    stem = insert_stroke(ring, plane(), SIZES, flat([[1.0, 0.0], [1.6, 0.0]])).network
    for network in (ring, stem):
        loop = max(network.chains.values(), key=lambda line: line.length)
        assert loop.is_closed_loop == (network is ring)
        for sign in (1.0, -1.0):
            stroke = flat([[1.0, 0.0], [0.5, 0.5 * sign], [0.0, sign]])
            done = redraw_chain(network, plane(), SIZES, stroke).network
            check_network(done)
            new = done.chains[loop.id]
            area = _area(new)
            # A quarter of the circle less, but for the triangle of the chord.
            assert area == pytest.approx(np.pi - (np.pi / 4 - 0.5), abs=0.01)
            assert (new.points[:, 1] * sign > 0.95).any()


def _area(line: Chain) -> float:
    x, y = line.points[:, 0], line.points[:, 1]
    return float(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def test_a_stroke_that_ends_near_a_corner_ends_in_it() -> None:
    network = square()
    side = chain_between(network, (0, 0), (2, 0))
    done = redraw_chain(
        network, plane(), SIZES, flat([[0.06, 0.05], [0.5, 0.3], [1.0, 0.0]])
    ).network
    check_network(done)
    line = done.chains[side]
    ends = {tuple(line.points[0]), tuple(line.points[-1])}
    assert ends == {(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)}
    # The whole stroke is used: nothing of the old line is left before it.
    assert (line.points[(line.points[:, 0] > 0.02) & (line.points[:, 0] < 0.9)][:, 1] > 0.0).all()


def test_what_cannot_be_redrawn_is_refused() -> None:
    network = square()
    for stroke, why in (
        (flat([[0.5, 0.0], [0.5, 0.5]]), "both ends"),
        (flat([[0.5, 0.0], [1.0, 1.0]]), "both ends"),
        (flat([[0.5, 0.0], [0.6, 0.3], [0.5, 0.005]]), "one place"),
        (flat([[0.5, 0.0], [1.0, 0.3], [1.0, 0.0]], True), "closed"),
        (flat([[0.5, 0.0], [1.0, 1.5], [1.5, 0.0]]), "cross"),
        (flat([[0.5, 0], [1.5, 0.5], [0.7, 0.7], [1.5, 0]]), "cross"),
    ):
        with pytest.raises(RefusedError, match=why):
            redraw_chain(network, plane(), SIZES, stroke)
    bordered = add_borders(Network(), plane(), 0.02)
    with pytest.raises(RefusedError, match="border"):
        redraw_chain(bordered, plane(), SIZES, flat([[5, 0], [4, 0.5], [5, 1]]))


def test_leaving_a_corner_beside_another_curve_is_no_crossing() -> None:
    network = drawn([[0, 0], [2, 0]], [[0, 0], [2, 0.2]])
    low = chain_between(network, (0, 0), (2, 0))
    done = redraw_chain(network, plane(), SIZES, flat([[0, 0], [1, 0.05], [2, 0]])).network
    check_network(done)
    assert done.chains[low].points[:, 1].max() == pytest.approx(0.05, abs=1e-3)
