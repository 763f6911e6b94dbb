"""How many edges curves need so as to keep their shape, and that counts respect it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.retopo.filling import change_counts, choose_counts
from patterndb_sketch.retopo.filling.edgecounts import SAGITTA, STRETCH, count_fewest_edges
from patterndb_sketch.retopo.network import Chain
from query.engine import PatternSource
from tests.support.retopo.editors import drawn_octants
from tests.support.retopo.filling import assert_even


def chain(line: Points, loose: bool = False) -> Chain:
    ends = (-1, -1) if loose else (0, 1)
    return Chain(0, *ends, line.copy(), np.zeros_like(line))


def arc(turn: float, n: int = 400) -> Points:
    t = np.linspace(0.0, turn, n)
    return np.stack([np.cos(t), np.sin(t), 0.0 * t], axis=1)


def cut_off(line: Points, edges: int) -> float:
    """The furthest that a point of a line lies from its division into edges."""
    corners = sample_polyline(line, edges)
    along = corners[1:] - corners[:-1]
    share = np.einsum("nec,ec->ne", line[:, None] - corners[:-1], along) / (along**2).sum(axis=1)
    feet = corners[:-1] + np.clip(share, 0.0, 1.0)[..., None] * along
    return float(np.linalg.norm(line[:, None] - feet, axis=2).min(axis=1).max())


@given(st.floats(0.1, 2 * np.pi - 0.01), st.floats(0.05, 3.0))
def test_edges_cut_off_the_allowed_sagitta_of_an_arc_and_are_no_more_than_that_asks_for(
    turn: float, edge: float
) -> None:
    n = count_fewest_edges(chain(arc(turn)), edge)
    # The chord of a whole arc is its sagitta e^2 kappa / 8 but for the fourth power of e.
    assert cut_off(arc(turn), n) <= SAGITTA * edge * 1.01 or n == 1
    by_bends, by_length = turn / np.sqrt(8.0 * SAGITTA * edge), turn / edge / STRETCH
    # A polyline of 400 points turns by a little less than the arc, and is a little shorter.
    least, most = (np.ceil(max(by_bends * s, by_length * s)) for s in (0.997, 1.0 + 1e-9))
    assert max(1, least) <= n <= max(1, most)


def test_a_straight_curve_and_one_with_a_sharp_corner_need_few() -> None:
    straight = np.linspace([0.0, 0.0, 0.0], [6.0, 0.0, 0.0], 50)
    assert count_fewest_edges(chain(straight), 1.0) == np.ceil(6.0 / STRETCH)
    corner = np.concatenate([straight[:25], straight[24] + straight[:25, [1, 0, 2]]])
    assert count_fewest_edges(chain(corner), 1.0) == np.ceil(chain(corner).length / STRETCH)
    assert count_fewest_edges(chain(straight[:2]), 1.0) == 1


@pytest.mark.parametrize("edge", [0.2, 0.7, 2.0])
def test_a_closed_curve_turns_where_it_begins_too(edge: float) -> None:
    circle = arc(2 * np.pi, 401)[:-1]
    turned = np.roll(circle, 133, axis=0)
    wanted = np.ceil(max(2 * np.pi / np.sqrt(8 * SAGITTA * edge), 2 * np.pi / edge / STRETCH))
    assert count_fewest_edges(chain(circle, True), edge) == wanted
    assert count_fewest_edges(chain(turned, True), edge) == wanted


def test_counts_keep_the_shapes_of_curves_and_a_user_may_ask_for_fewer(
    source: PatternSource,
) -> None:
    network = drawn_octants(source).fill().network
    edge = 1.2
    network, notes = choose_counts(network, edge)
    assert notes == ()
    assert_even(network)
    assert all(one.count >= count_fewest_edges(one, edge) > 1 for one in network.chains.values())
    one = min(network.chains)
    fewer, _ = change_counts(network, edge, {one: 1})
    assert fewer.chains[one].count == 1
    # With another target edge all would have more: what is settled stays.
    same, _ = change_counts(network, edge / 4, {one: network.chains[one].count + 2})
    assert sum(same.chains[c].count != network.chains[c].count for c in same.chains) == 1
