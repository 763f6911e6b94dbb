"""Corners: toggled on curves, and wedges switched between corner and T-junction."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    Network,
    add_borders,
    are_equal,
    check_network,
    set_count,
)
from patterndb_sketch.retopo.tools.corner import flip_wedge, toggle_corner
from patterndb_sketch.retopo.tools.erase import erase_chains
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from tests.support.retopo.networks import SIZES, chain_between, drawn, flat, node_at, plane, square

UP = (0.0, 0.0, 1.0)


def test_a_corner_of_a_square_is_toggled_away_and_back() -> None:
    network = square()
    for count, chain in enumerate(sorted(network.chains), 5):
        network = set_count(network, chain, count)
    sides = [chain_between(network, (2, 0), end) for end in ((0, 0), (2, 1))]
    total = sum(network.chains[side].count for side in sides)
    less = toggle_corner(network, SIZES, (1.97, 0.02, 0), UP).network
    check_network(less)
    (patch,) = less.patches.values()
    assert len(patch.corners) == 3
    assert less.chains[chain_between(less, (0, 0), (2, 1))].count == total
    again = toggle_corner(less, SIZES, (2.01, -0.005, 0), UP).network
    check_network(again)
    (patch,) = again.patches.values()
    assert len(patch.corners) == 4
    parts = [again.chains[chain_between(again, (2, 0), end)] for end in ((0, 0), (2, 1))]
    assert sum(chain.count for chain in parts) == total
    old = {network.chains[side].points.tobytes() for side in sides}
    assert {chain.points.tobytes() for chain in parts} == old


def test_a_corner_is_made_on_a_curve_for_both_sides() -> None:
    network = drawn([[1, 0], [1, 1]], network=square())
    done = toggle_corner(network, SIZES, (1.02, 0.5, 0), UP).network
    check_network(done)
    assert [len(patch.corners) for patch in done.patches.values()] == [5, 5]
    node = done.nodes[node_at(done, 1, 0.5)]
    assert node.corner_flags == (True, True) and not node.cut


def test_toggling_is_refused_where_it_cannot_be() -> None:
    with pytest.raises(RefusedError, match="no curve is near"):
        toggle_corner(square(), SIZES, (3, 3, 0), UP)
    lens = drawn([[0, 0], [1, 0.3], [2, 0]], [[0, 0], [1, -0.3], [2, 0]])
    (patch,) = lens.patches.values()
    assert len(patch.corners) == 2
    with pytest.raises(RefusedError, match="at least 2 corners"):
        toggle_corner(lens, SIZES, (0, 0, 0), UP)
    tee = drawn([[0, 0], [1, 0]], [[0.5, 0], [0.5, 1]])
    with pytest.raises(RefusedError, match="several curves"):
        toggle_corner(tee, SIZES, (0.5, 0, 0), UP)
    # Just an open end is there.
    with pytest.raises(RefusedError, match="one ends"):
        toggle_corner(tee, SIZES, (-0.05, 0, 0), UP)


def test_a_corner_on_a_closed_chain_and_away_again() -> None:
    t = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    ring = insert_stroke(Network(), plane(), SIZES, flat(np.c_[np.cos(t), np.sin(t)], True)).network
    one = toggle_corner(ring, SIZES, (1.03, 0, 0), UP).network
    check_network(one)
    (node,) = one.nodes.values()
    (chain,) = one.chains.values()
    assert chain.start == chain.end == node.id and not one.patches
    two = toggle_corner(one, SIZES, (-1.03, 0, 0), UP).network
    check_network(two)
    (patch,) = two.patches.values()
    assert len(patch.corners) == 2
    none = toggle_corner(one, SIZES, (1.03, 0, 0), UP).network
    check_network(none)
    (back,) = none.chains.values()
    (old,) = ring.chains.values()
    assert back.is_closed_loop
    assert {tuple(p) for p in back.points} == {tuple(p) for p in old.points}


def test_a_border_cannot_lose_the_corner_where_it_ends_at_another_curve() -> None:
    network = drawn([[-5, 1], [5, 1]], network=add_borders(Network(), plane(), 0.02))
    left = chain_between(network, (-5, 1), (5, 1)) if len(network.chains) == 1 else None
    assert left is None
    corner = network.nodes[node_at(network, 5, 1)]
    assert corner.valence == 3
    with pytest.raises(RefusedError, match="several curves"):
        toggle_corner(network, SIZES, (5, 1, 0), UP)


def two_under_one() -> Network:
    """Two squares under one long rectangle, which meets their common side in a T-junction."""
    lines = [
        [[0, 1], [2, 1]], [[0, 1], [0, 0]], [[0, 0], [2, 0]], [[2, 0], [2, 1]], [[1, 0], [1, 1]],
        [[0, 1], [0, 2]], [[0, 2], [2, 2]], [[2, 2], [2, 1]],
    ]  # fmt: skip
    return drawn(*lines)


def test_a_t_junction_becomes_a_corner_and_back() -> None:
    network = two_under_one()
    assert sorted(len(patch.corners) for patch in network.patches.values()) == [4, 4, 4]
    lower = {patch.id: patch for patch in network.patches.values() if len(patch.loop) == 4}
    flipped = flip_wedge(network, SIZES, (1, 1.3, 0), (1.01, 1, 0), UP).network
    check_network(flipped)
    assert sorted(len(patch.corners) for patch in flipped.patches.values()) == [4, 4, 5]
    assert len(lower) == 2
    assert all(flipped.patches[k] is patch for k, patch in lower.items())
    back = flip_wedge(flipped, SIZES, (1, 1.3, 0), (1, 1, 0), UP).network
    check_network(back)
    assert sorted(len(patch.corners) for patch in back.patches.values()) == [4, 4, 4]
    assert [n.corner_flags for n in back.nodes.values()] == [
        n.corner_flags for n in network.nodes.values()
    ]


def test_the_last_corner_of_a_node_stays() -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, 0], [0.5, 1]])
    one = flip_wedge(network, SIZES, (0.2, 0.3, 0), (0.5, 0, 0), UP).network
    check_network(one)
    node = one.nodes[node_at(one, 0.5, 0)]
    assert sum(node.corner_flags) == 1
    with pytest.raises(RefusedError, match="last corner"):
        flip_wedge(one, SIZES, (0.8, 0.3, 0), (0.5, 0, 0), UP)
    # An open end has no wedge to switch; nothing is where nothing is.
    with pytest.raises(RefusedError, match="no corner"):
        flip_wedge(one, SIZES, (0.2, 0.1, 0), (0, 0, 0), UP)
    with pytest.raises(RefusedError, match="begins on the corner"):
        flip_wedge(one, SIZES, node.point, node.point, UP)


def test_a_patch_keeps_two_corners() -> None:
    lens = drawn([[0, 0], [1, 0.3], [2, 0]], [[0, 0], [1, -0.3], [2, 0]], [[2, 0], [3, 0]])
    with pytest.raises(RefusedError, match="at least 2 corners"):
        flip_wedge(lens, SIZES, (1.5, 0, 0), (2, 0, 0), UP)


def test_a_corner_that_the_user_made_of_a_t_junction_outlives_its_stem() -> None:
    network = two_under_one()
    flipped = flip_wedge(network, SIZES, (1, 1.3, 0), (1, 1, 0), UP).network
    stem = chain_between(flipped, (1, 0), (1, 1))
    done = erase_chains(flipped, [stem]).network
    check_network(done)
    assert done.nodes[node_at(done, 1, 1)].valence == 2
    plain = erase_chains(network, [chain_between(network, (1, 0), (1, 1))]).network
    check_network(plain)
    assert not are_equal(plain, done)
    assert chain_between(plain, (0, 1), (2, 1))
