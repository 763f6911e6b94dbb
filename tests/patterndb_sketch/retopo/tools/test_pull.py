"""Pulling corners, open ends and sides, and what they snap to when they are let go."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.retopo.network.attaching import find_departure, measure_turn
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    AtChain,
    AtNode,
    Edit,
    Network,
    add_borders,
    add_chain,
    are_equal,
    check_network,
    set_choice,
    set_count,
)
from patterndb_sketch.retopo.network.attaching import TOO_CLOSE
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.pull import find_held, pull_held, release_held
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import clean_stroke
from tests.support.retopo.networks import (
    SIZES,
    chain_between,
    drawn,
    flat,
    genus,
    node_at,
    plane,
    sphere,
    square,
)

UP = (0.0, 0.0, 1.0)


def let_go(network: Network, at: tuple[float, float], to: tuple[float, float]) -> Edit:
    """Pull the node at a place to another and let it go."""
    old = {k: chain.points.tobytes() for k, chain in network.chains.items()}
    done = release_held(network, plane(), SIZES, AtNode(node_at(network, *at)), (*to, 0.0), UP)
    check_network(done.network)
    assert old == {k: chain.points.tobytes() for k, chain in network.chains.items()}
    return done


def corners(network: Network) -> list[int]:
    return sorted(len(patch.corners) for patch in network.patches.values())


def test_a_press_takes_hold_of_a_corner_before_a_side() -> None:
    network = square()
    assert find_held(network, SIZES, (0.06, 0.0, 0), UP) == AtNode(node_at(network, 0, 0))
    at = find_held(network, SIZES, (1.0, 0.05, 0), UP)
    assert isinstance(at, AtChain) and at.chain == chain_between(network, (0, 0), (2, 0))
    with pytest.raises(RefusedError, match="no curve is near"):
        find_held(network, SIZES, (1.0, 0.5, 0), UP)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_a_side_follows_by_the_shares_that_are_said(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = square()
    for patch in network.patches:
        network = set_choice(network, patch, "a fill")
    side = chain_between(network, (0, 0), (2, 0))
    old = network.chains[side].points
    k = int(rng.integers(1, len(old) - 1))
    # So near that samples stay those that were.
    to = old[k] + np.r_[rng.uniform(-0.1, 0.1, 2), 0.0] * min(k, len(old) - k) / len(old)
    edit = pull_held(network, plane(), SIZES, AtChain(side, k + rng.uniform(-0.4, 0.4)), to, UP)
    check_network(edit.network)
    new = edit.network.chains[side].points
    along = np.arange(len(old)) / (len(old) - 1.0)
    here = along[k]
    for i, point in enumerate(new):
        t = (here - along[i]) / here if i <= k else (along[i] - here) / (1.0 - here)
        share = (1.0 - t) ** 4 * (4.0 * t + 1.0)
        assert np.allclose(point, old[i] + share * (to - old[k]), atol=1e-9)
    assert np.allclose(new[k], to, atol=1e-12)
    assert edit.network.patches == network.patches and edit.notes == ()


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_the_curves_of_a_corner_follow_evenly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = drawn([[1, 0], [1, 1]], network=square())
    chosen = network.nodes[int(rng.choice(sorted(network.nodes)))]
    move = np.r_[rng.uniform(-0.05, 0.05, 2), 0.0]
    done = pull_held(network, plane(), SIZES, AtNode(chosen.id), chosen.point + move, UP).network
    check_network(done)
    assert done.patches == network.patches
    for node in network.nodes.values():
        goes = move if node.id == chosen.id else 0.0
        assert np.allclose(done.nodes[node.id].point, node.point + goes, atol=1e-12)
        assert done.nodes[node.id].corner_flags == node.corner_flags
    for chain, line in network.chains.items():
        share = np.linspace(0.0, 1.0, len(line.points))[:, None]
        share = (line.start == chosen.id) * (1.0 - share) + (line.end == chosen.id) * share
        assert np.allclose(done.chains[chain].points, line.points + share * move, atol=1e-9)


def test_what_is_stretched_is_sampled_anew_and_a_closed_curve_bends_half_way_round() -> None:
    network = drawn([[0, 0], [0.5, 0]])
    (chain,) = network.chains
    done = pull_held(
        network, plane(), SIZES, AtNode(node_at(network, 0.5, 0)), (2, 1, 0), UP
    ).network
    check_network(done)
    steps = np.diff(arc_length(done.chains[chain].points))
    assert steps.max() < 1.1 * SIZES.sampling and steps.min() > 0.9 * SIZES.sampling
    turn = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    ring = insert_stroke(
        Network(), plane(), SIZES, flat(np.c_[np.cos(turn), np.sin(turn)], True)
    ).network
    (line,) = ring.chains.values()
    bent = pull_held(ring, plane(), SIZES, AtChain(line.id, 0.0), (1.2, 0, 0), UP).network
    check_network(bent)
    off = np.linalg.norm(bent.chains[line.id].points - line.points, axis=1)
    assert off[0] == pytest.approx(0.2) and off[len(off) // 2] < 1e-9
    assert np.allclose(off[1:], off[:0:-1], atol=1e-3)


def test_on_a_sphere_all_stays_on_the_surface() -> None:
    sizes = Sizes.of(sphere().diagonal)
    lines = [[[0.6, -0.5, 0.7], [0.7, 0.0, 0.7]], [[0.7, 0.0, 0.7], [0.4, 0.3, 0.8]]]
    network = Network()
    for line in lines:
        network = insert_stroke(
            network, sphere(), sizes, clean_stroke(line, sphere(), sizes)
        ).network
    (corner,) = [node for node in network.nodes.values() if node.valence == 2]
    to = sphere().nearest([[0.9, 0.3, 0.3]])
    edit = pull_held(network, sphere(), sizes, AtNode(corner.id), to.points[0], to.normals[0])
    check_network(edit.network)
    assert np.allclose(edit.network.nodes[corner.id].point, to.points[0], atol=1e-9)
    for line in edit.network.chains.values():
        feet = sphere().nearest(line.points)
        assert np.linalg.norm(feet.points - line.points, axis=1).max() < 1e-9


def test_open_ends_meet_in_a_corner_or_smoothly() -> None:
    network = drawn([[0, 0], [1, 0]], [[1.5, 0], [2.5, 0.2]])
    done = let_go(network, (1, 0), (1.45, 0.03)).network
    node = done.nodes[node_at(done, 1.5, 0)]
    assert node.corner_flags == (True, True) and len(done.chains) == 2
    at = AtNode(node_at(network, 1, 0))
    smooth = release_held(network, plane(), SIZES, at, (1.45, 0.03, 0), UP, smooth=True).network
    check_network(smooth)
    (chain,) = smooth.chains.values()
    assert len(smooth.nodes) == 2 and chain.length == pytest.approx(
        1.5 + np.hypot(1, 0.2), abs=0.01
    )


def test_the_ends_of_an_open_curve_close_to_a_loop_if_it_goes_round() -> None:
    network = drawn([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0.4]])
    done = let_go(network, (0, 0.4), (0.02, 0.05)).network
    (node,), (chain,) = done.nodes.values(), done.chains.values()
    assert chain.start == chain.end == node.id and node.valence == 2
    at = AtNode(node_at(network, 0, 0.4))
    smooth = release_held(network, plane(), SIZES, at, (0.02, 0.05, 0), UP, smooth=True).network
    check_network(smooth)
    (chain,) = smooth.chains.values()
    assert chain.is_closed_loop and not smooth.nodes
    # A straight one is just pulled: it would vanish.
    line = drawn([[0, 0], [0.5, 0]])
    done = let_go(line, (0.5, 0), (0.05, 0.0)).network
    assert len(done.nodes) == 2


def test_an_open_end_meets_a_corner_and_a_side_as_a_stroke_does() -> None:
    network = drawn([[0.5, 0.6], [1, 0.6]], network=square())
    assert corners(network) == [4]
    side = let_go(network, (1, 0.6), (1.95, 0.5)).network
    tee = side.nodes[node_at(side, 2, 0.5)]
    assert tee.valence == 3 and sorted(tee.corner_flags) == [False, True, True]
    done = let_go(side, (0.5, 0.6), (0.02, 0.5)).network
    assert corners(done) == [4, 4]
    corner = let_go(network, (1, 0.6), (1.95, 0.97)).network
    assert corner.nodes[node_at(corner, 2, 1)].valence == 3
    split = let_go(corner, (0.5, 0.6), (0.02, 0.05)).network
    assert corners(split) == [3, 3]
    assert genus(split) == 0


def apart() -> Network:
    """Two squares with a gap between."""
    network = square()
    for line in ([[2.3, 0], [4, 0]], [[4, 0], [4, 1]], [[4, 1], [2.3, 1]], [[2.3, 1], [2.3, 0]]):
        network = drawn(line, network=network)
    return network


def test_the_gap_between_two_patches_is_zipped() -> None:
    network = apart()
    kept = chain_between(network, (2, 0), (2, 1))
    for chain in network.chains:
        network = set_count(network, chain, 6 if chain == kept else 4)
    one = let_go(network, (2.3, 0), (2.02, 0.03)).network
    assert corners(one) == [4, 4] and len(one.chains) == 8 and len(one.nodes) == 7
    both = let_go(one, (2.3, 1), (2.02, 0.97)).network
    assert corners(both) == [4, 4] and len(both.chains) == 7 and len(both.nodes) == 6
    assert genus(both) == 0
    shared = both.chains[chain_between(both, (2, 0), (2, 1))]
    assert shared.id == kept and shared.count == 6
    assert (shared.points == network.chains[kept].points).all()
    assert both.patch_of().keys() >= {2 * kept, 2 * kept + 1}
    for place in ((2, 0), (2, 1)):
        node = both.nodes[node_at(both, *place)]
        assert node.valence == 3 and node.corner_flags == (True, True, True)


def test_a_corner_that_meets_a_side_leaves_a_t_junction_there() -> None:
    network = apart()
    done = let_go(network, (2.3, 1), (2.04, 0.5)).network
    tee = done.nodes[node_at(done, 2, 0.5)]
    assert tee.valence == 4 and sum(tee.corner_flags) == 3
    assert corners(done) == [4, 4] and genus(done) == 0
    low = let_go(done, (2.3, 0), (2.01, 0.01)).network
    assert corners(low) == [4, 4] and len(low.chains) == 8
    tee = low.nodes[node_at(low, 2, 0.5)]
    assert tee.valence == 3 and sorted(tee.corner_flags) == [False, True, True]


def test_a_side_collapses_when_its_corners_meet() -> None:
    network = drawn([[1, 0], [1, 1]], network=square())
    done = let_go(network, (2, 1), (2.02, 0.04)).network
    assert corners(done) == [3, 4] and len(done.chains) == 6 and genus(done) == 0
    # The sides of a triangle that lie on each other then are one, and the patch is gone.
    flat_one = let_go(done, (1, 1), (1.02, 0.04)).network
    assert genus(flat_one) == 0
    assert corners(flat_one) == [3]
    ends = {node_at(flat_one, 1, 0), node_at(flat_one, 2, 0)}
    (between,) = [c for c in flat_one.chains.values() if {c.start, c.end} == ends]
    assert not between.is_closed_loop


def test_a_stub_is_pulled_in() -> None:
    network = drawn([[2, 1], [2.5, 1.5]], network=square())
    done = let_go(network, (2.5, 1.5), (2.03, 1.02)).network
    assert len(done.chains) == 4 and corners(done) == [4]
    node = done.nodes[node_at(done, 2, 1)]
    assert node.valence == 2 and all(node.corner_flags)
    back = let_go(network, (2, 1), (2.48, 1.48)).network
    assert len(back.chains) == 4 and node_at(back, 2.5, 1.5)


def test_what_cannot_be_joined_stays_where_it_is_dropped() -> None:
    lens = drawn([[0, 0], [1, 0.5], [2, 0]], [[0, 0], [1, -0.5], [2, 0]])
    done = let_go(lens, (2, 0), (0.05, 0.0))
    assert "several curves" in done.notes[0] and corners(done.network) == [2]
    # A corner with patches all round, and another corner: no gap for its curves.
    network = drawn([[1, 0], [1, 1]], [[0, 0.5], [2, 0.5]], network=square())
    network = drawn([[2.6, 0.5], [3, 0.2]], [[2.6, 0.5], [3, 0.8]], network=network)
    done = let_go(network, (2.6, 0.5), (1.05, 0.52))
    assert done.notes[0].startswith("not joined: both corners need one gap")
    assert len(done.network.nodes) == len(network.nodes)
    assert node_at(done.network, 1.05, 0.52)


def test_crossings_are_told() -> None:
    network = drawn([[3, 0], [3, 1]], network=square())
    edit = pull_held(network, plane(), SIZES, AtNode(node_at(network, 2, 1)), (3.5, 1, 0), UP)
    check_network(edit.network)
    assert any("crosses" in note for note in edit.notes)
    clear = pull_held(network, plane(), SIZES, AtNode(node_at(network, 2, 1)), (2.5, 1.2, 0), UP)
    assert clear.notes == ()


def test_what_cannot_be_pulled_is_refused() -> None:
    bordered = add_borders(Network(), plane(), 0.02)
    (border,) = bordered.chains
    for call in (pull_held, release_held):
        with pytest.raises(RefusedError, match="border"):
            call(bordered, plane(), SIZES, AtChain(border, 3.0), (0, 0, 0), UP)
    line = insert_stroke(bordered, plane(), SIZES, flat([[5, 0], [4, 0]])).network
    (tee,) = [node for node in line.nodes.values() if node.valence == 3]
    with pytest.raises(RefusedError, match="border"):
        pull_held(line, plane(), SIZES, AtNode(tee.id), (4.5, 0, 0), UP)
    # An open end may be let go on the border.
    (end,) = [node for node in line.nodes.values() if node.open]
    done = release_held(line, plane(), SIZES, AtNode(end.id), (4.0, 4.97, 0), UP).network
    check_network(done)
    assert len(done.patches) == 2
    for at in (AtNode(999), AtChain(999, 0.0)):
        with pytest.raises(InvalidRetopoError, match="999"):
            release_held(square(), plane(), SIZES, at, (0, 0, 0), UP)
    short, chain = add_chain(Network(), [[0, 0, 0], [0.1, 0, 0]], [UP] * 2)
    with pytest.raises(RefusedError, match="too short"):
        pull_held(short, plane(), SIZES, AtChain(chain, 0.5), (0, 1, 0), UP)
    with pytest.raises(RefusedError, match="no length"):
        pull_held(short, plane(), SIZES, AtNode(node_at(short, 0.1, 0)), (0, 0, 0), UP)


def closest(network: Network) -> float:
    """The least angle, in radians, between two curves that leave one node."""
    least = np.pi
    for node in network.nodes.values():
        lines = [(network.chains[half >> 1], bool(half & 1)) for half in node.ends]
        ways = [find_departure(line.points, back, 3.0 * SIZES.sampling) for line, back in lines]
        turns = [measure_turn(node.normal, ways[k - 1], way) for k, way in enumerate(ways)]
        if len(turns) > 1:
            least = min(least, *(min(t, 2.0 * np.pi - t) for t in turns))
    return least


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_whatever_is_pulled_the_network_holds_and_stays_a_drawing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = Network()
    for _ in range(5):
        line = rng.uniform(-1, 1, (2, 2))
        if np.linalg.norm(line[1] - line[0]) > 0.3:
            with suppress(RefusedError):  # it may lie on another
                network = insert_stroke(network, plane(), SIZES, flat(line)).network
    if closest(network) < TOO_CLOSE:
        return
    for _ in range(6):
        if not network.chains:
            return
        nodes = sorted(network.nodes)
        chain = network.chains[int(rng.choice(sorted(network.chains)))]
        at: AtNode | AtChain = AtChain(chain.id, float(rng.uniform(0, chain.segments)))
        if nodes and rng.random() < 0.8:
            at = AtNode(int(rng.choice(nodes)))
        to = np.r_[rng.uniform(-1, 1, 2), 0.0]
        if rng.random() < 0.8:
            other = network.chains[int(rng.choice(sorted(network.chains)))]
            to = (
                other.points[rng.choice([0, len(other.points) // 2, -1])]
                + np.r_[rng.normal(0.0, 0.03, 2), 0.0]
            )
        try:
            edit = release_held(network, plane(), SIZES, at, to, UP)
        except RefusedError:
            continue
        check_network(edit.network)
        again = release_held(network, plane(), SIZES, at, to, UP)
        assert are_equal(edit.network, again.network) and edit.notes == again.notes
        if any("crosses" in note for note in edit.notes):
            continue
        if closest(edit.network) < TOO_CLOSE:
            # What lies on what: its order around the node is anyone's guess.
            return
        assert genus(edit.network) == 0
        network = edit.network
