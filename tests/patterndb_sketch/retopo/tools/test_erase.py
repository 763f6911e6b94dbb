"""Erasing by scribbles, by chain and all open ones; cleaning knots."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    Free,
    Network,
    add_borders,
    are_equal,
    check_network,
    set_count,
)
from patterndb_sketch.retopo.tools.erase import (
    erase_chains,
    erase_crossed_chains,
    erase_open_chains,
)
from patterndb_sketch.retopo.tools.knot import clean_knot
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from tests.support.retopo.networks import (
    SIZES,
    chain_between,
    drawn,
    flat,
    genus,
    node_at,
    plane,
    square,
)

UP = (0.0, 0.0, 1.0)


def shapes(network: Network, chains: Iterable[int]) -> list[bytes]:
    return sorted(network.chains[chain].points.tobytes() for chain in chains)


def test_a_chord_comes_and_goes() -> None:
    before = square()
    made = insert_stroke(before, plane(), SIZES, flat([[1, 0], [1, 1]]))
    assert len(made.network.patches) == 2
    done = erase_crossed_chains(made.network, flat([[0.8, 0.5], [1.2, 0.6]])).network
    check_network(done)
    (patch,) = done.patches.values()
    assert len(patch.corners) == 4
    # The four chains as they were, sample for sample.
    assert shapes(done, done.chains) == shapes(before, before.chains)
    assert done.nodes.keys() == before.nodes.keys()
    # Undo is the network that was kept.
    again = insert_stroke(before, plane(), SIZES, flat([[1, 0], [1, 1]]))
    assert are_equal(again.network, made.network)


def test_one_arm_of_a_cross_leaves_a_t_junction_and_two_leave_nothing() -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, -0.5], [0.5, 0.5]])
    one = erase_chains(network, [chain_between(network, (0.5, 0), (0.5, 0.5))]).network
    check_network(one)
    node = one.nodes[node_at(one, 0.5, 0)]
    assert sorted(node.corner_flags) == [False, True, True]
    two = erase_chains(one, [chain_between(one, (0.5, 0), (0.5, -0.5))]).network
    check_network(two)
    (chain,) = two.chains.values()
    assert chain.length == pytest.approx(1.0)


def test_corners_that_were_drawn_as_such_stay() -> None:
    bent = drawn([[0, 0], [0.5, 0]])
    bent = insert_stroke(bent, plane(), SIZES, flat([[0.5, 0], [1, 0.01]])).network
    stem = insert_stroke(bent, plane(), SIZES, flat([[0.5, 0], [0.5, 0.5]])).network
    done = erase_chains(stem, [chain_between(stem, (0.5, 0), (0.5, 0.5))]).network
    check_network(done)
    assert len(done.chains) == 2
    assert done.nodes[node_at(done, 0.5, 0)].valence == 2
    # Two arms of different lines, which turn by more than 30 degrees, stay a corner, too.
    cross = drawn([[0, 0], [1, 0]], [[0.5, -0.5], [0.5, 0.5]])
    arms = [chain_between(cross, (0.5, 0), end) for end in ((0.5, 0.5), (1, 0))]
    left = erase_chains(cross, arms).network
    check_network(left)
    assert left.nodes[node_at(left, 0.5, 0)].valence == 2


def test_a_curve_that_was_cut_is_one_again_however_it_bends() -> None:
    # At a right angle, just where a stem ends on it, and where a line crosses it.
    bent = [[-1, 0], [0, 0], [0, 1]]
    for other, crossed in (([[0, 0], [1, -1]], 1), ([[-1, 1], [1, -1]], 2)):
        for order in (0, 1):
            network = drawn(*((bent, other) if order == 0 else (bent, other[::-1])))
            node = network.nodes[node_at(network, 0, 0)]
            assert node.valence == 2 + crossed
            stems = [
                half >> 1
                for half in node.ends
                if any(
                    np.hypot(*(network.chains[half >> 1].points[k][:2] - end)) < 1e-6
                    for k in (0, -1)
                    for end in other
                    if end != [0, 0]
                )
            ]
            done = erase_chains(network, stems).network
            check_network(done)
            (chain,) = done.chains.values()
            assert chain.length == pytest.approx(2.0)
            assert len(done.nodes) == 2


@given(st.lists(st.floats(-0.8, 0.8), min_size=1, max_size=4, unique=True), st.booleans())
def test_drawing_curves_on_one_and_erasing_them_leaves_it_as_it_was(places, across: bool) -> None:
    apart = sorted(places)
    if any(b - a < 3 * SIZES.snap for a, b in itertools.pairwise(apart)):
        return
    wave = np.linspace(-1, 1, 60)
    before = drawn(np.c_[wave, 0.1 * np.sin(7 * wave)])
    network = before
    for x in apart:
        foot = [x, 0.1 * np.sin(7 * x)]
        begin = [x, -0.7] if across else foot
        network = insert_stroke(network, plane(), SIZES, flat([begin, [x, 0.7]])).network
        check_network(network)
    (old,) = before.chains
    line = before.chains[old].points
    others = [chain.id for chain in network.chains.values() if abs(chain.points[:, 1]).max() > 0.5]
    done = erase_chains(network, others).network
    check_network(done)
    (left,) = done.chains.values()
    assert len(done.nodes) == 2
    # Sample for sample, but for those that the cuts added.
    kept = {tuple(p) for p in left.points}
    assert sum(tuple(p) in kept for p in line) >= len(line) - 2 * len(apart)
    assert left.length == pytest.approx(before.chains[old].length, rel=0.01)


def test_counts_that_no_patch_uses_are_forgotten_but_for_chosen_ones() -> None:
    network = drawn([[1, 0], [1, 1]], network=square())
    kept = chain_between(network, (0, 1), (0, 0))
    for chain in network.chains:
        network = set_count(network, chain, 5, chain == kept)
    gone = chain_between(network, (0, 0), (1, 0))
    done = erase_chains(network, [gone]).network
    check_network(done)
    (patch,) = done.patches.values()
    used = {half >> 1 for half in patch.loop}
    for chain in done.chains.values():
        assert chain.count == (5 if chain.id in used or chain.id == kept else 0)
    assert done.chains[kept].pinned


def test_merged_counts_add() -> None:
    network = drawn([[1, 0], [1, 1]], network=square())
    for count, chain in enumerate(sorted(network.chains), 3):
        network = set_count(network, chain, count)
    counts = [network.chains[chain_between(network, a, (1, 0))].count for a in ((0, 0), (2, 0))]
    done = erase_chains(network, [chain_between(network, (1, 0), (1, 1))]).network
    assert done.chains[chain_between(done, (0, 0), (2, 0))].count == sum(counts)


def test_borders_are_never_erased() -> None:
    network = add_borders(Network(), plane(), 0.02)
    (border,) = network.chains
    for call in (lambda: erase_chains(network, [border]), lambda: erase_open_chains(network)):
        with pytest.raises(RefusedError):
            call()
    cut = drawn([[-5, 1], [5, 1]], network=network)
    done = erase_crossed_chains(cut, flat([[4.9, 0.9], [4.95, 1.1]])).network
    check_network(done)
    assert [chain.points.tobytes() for chain in done.chains.values()] != []
    (left,) = done.chains.values()
    assert left.is_closed_loop and left.marked
    both = erase_crossed_chains(cut, flat([[4.9, 0.9], [4.95, 1.1], [6, 2]]))
    assert both.notes


def test_what_cannot_be_erased_is_refused() -> None:
    with pytest.raises(RefusedError, match="crosses no curve"):
        erase_crossed_chains(square(), flat([[5, 5], [4, 4]]))
    with pytest.raises(InvalidRetopoError, match="no chain 999"):
        erase_chains(square(), [999])
    with pytest.raises(RefusedError, match="open end"):
        erase_open_chains(square())


def test_erase_open_leaves_what_has_no_open_end() -> None:
    network = drawn(
        [[1, 0], [1, -1]],
        [[1, -1], [1.5, -1.5]],
        [[1, -1], [0.5, -1.5]],
        [[3, 0], [4, 0]],
        network=square(),
    )
    done = erase_open_chains(network).network
    check_network(done)
    assert shapes(done, done.chains) == shapes(square(), square().chains)
    assert len(done.patches) == 1


@given(st.integers(0, 2**32 - 1))
def test_erasing_keeps_the_rest_in_its_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = Network()
    for _ in range(5):
        line = rng.uniform(-1, 1, (2, 2))
        if np.linalg.norm(line[1] - line[0]) > 0.3:
            with suppress(RefusedError):  # it may lie on another
                network = insert_stroke(network, plane(), SIZES, flat(line)).network
    if not network.chains:
        return
    chosen = rng.choice(sorted(network.chains), rng.integers(1, len(network.chains) + 1), False)
    gone = {int(chain) for chain in chosen}
    done = erase_chains(network, gone).network
    check_network(done)
    kept = sum(chain.length for chain in network.chains.values() if chain.id not in gone)
    assert sum(chain.length for chain in done.chains.values()) == pytest.approx(kept, abs=1e-9)
    points = {tuple(p) for c in network.chains.values() if c.id not in gone for p in c.points}
    assert {tuple(p) for c in done.chains.values() for p in c.points} <= points


def test_a_knot_becomes_one_corner() -> None:
    # Three lines that meet in a small triangle, and a stub that hangs within.
    lines = [[[-1, 0.01], [1, 0.01]], [[-0.5, -1], [0.55, 1]], [[-0.5, 1], [0.5, -1]]]
    network = drawn(*lines)
    stub = flat([[0.03, -0.02], [0.09, -0.02]])
    network = insert_stroke(network, plane(), SIZES, stub, Free(), Free()).network
    done = clean_knot(network, plane(), SIZES, (0, 0, 0), UP).network
    check_network(done)
    assert genus(done) == 0
    node = done.nodes[node_at(done, 0, 0)]
    assert node.valence == 6 and node.corner_flags == (True,) * 6
    assert len(done.chains) == 6 and len(done.nodes) == 7
    for chain in done.chains.values():
        away = np.linalg.norm(chain.points, axis=1)
        away.sort()
        assert (away[1:] > away[:-1]).all()


def test_a_knot_leaves_the_counts_outside() -> None:
    network = drawn([[-1, 0], [1, 0]], [[0, -1], [0, 1]])
    for chain in network.chains:
        network = set_count(network, chain, 10, True)
    done = clean_knot(network, plane(), SIZES, (0.01, 0.01, 0), UP).network
    check_network(done)
    assert [chain.count for chain in done.chains.values()] == [9] * 4


def test_knots_are_refused_where_nothing_can_be_done() -> None:
    network = drawn([[-0.05, 0], [0.06, 0.02]])
    with pytest.raises(RefusedError, match="nothing is within"):
        clean_knot(network, plane(), SIZES, (3, 0, 0), UP)
    with pytest.raises(RefusedError, match="leaves the circle"):
        clean_knot(network, plane(), SIZES, (0, 0, 0), UP)
    bordered = add_borders(Network(), plane(), 0.02)
    with pytest.raises(RefusedError, match="border"):
        clean_knot(bordered, plane(), SIZES, (5, 0, 0), UP)
