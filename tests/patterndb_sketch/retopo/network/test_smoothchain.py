"""Smoothing chains: what stays, and that nothing gets rougher."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    Network,
    add_borders,
    add_chain,
    check_network,
    set_choice,
    set_count,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.smooth import smooth_chain
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import clean_stroke
from tests.support.retopo.networks import SIZES, chain_between, drawn, flat, plane, sphere, square

UP = (0.0, 0.0, 1.0)


def roughness(points: np.ndarray, closed: bool) -> float:
    """The sum of the squared steps."""
    ends = points[:1] if closed else points[:0]
    return float((np.diff(np.concatenate([points, ends]), axis=0) ** 2).sum())


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_a_closed_curve_on_a_plane_keeps_its_middle_and_gets_no_rougher(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 80))
    turn = 2.0 * np.pi * np.arange(n) / n
    ring = np.c_[np.cos(turn), np.sin(turn)] * rng.uniform(0.5, 1.5, (n, 1))
    network = insert_stroke(Network(), plane(), SIZES, flat(ring, True)).network
    if any(not line.is_closed_loop for line in network.chains.values()):
        return
    (before,) = network.chains.values()
    done = smooth_chain(network, plane(), SIZES, before.id).network
    check_network(done, patches=False)
    after = done.chains[before.id]
    assert len(after.points) == len(before.points)
    assert np.allclose(after.points.mean(axis=0), before.points.mean(axis=0), atol=1e-9)
    assert roughness(after.points, True) <= roughness(before.points, True) + 1e-12


def test_a_straight_line_stays_and_a_jittered_one_gets_nearer_to_it() -> None:
    line = drawn([[0, 0], [1, 0]])
    (chain,) = line.chains.values()
    done = smooth_chain(line, plane(), SIZES, chain.id).network
    assert np.allclose(done.chains[chain.id].points, chain.points, atol=1e-12)
    rng = np.random.default_rng(1)
    points = chain.points.copy()
    points[1:-1, 1] += rng.normal(0.0, 0.01, len(points) - 2)
    rough, at = add_chain(Network(), points, chain.normals)
    done = smooth_chain(rough, plane(), SIZES, at)
    after = done.network.chains[at]
    assert (after.points[[0, -1]] == points[[0, -1]]).all()
    assert np.abs(after.points[:, 1]).max() < 0.5 * np.abs(points[:, 1]).max()
    assert done.chains == () and done.nodes == ()


def test_patches_keep_their_ids_counts_and_choices() -> None:
    network = drawn([[1, 0], [0.9, 0.3], [1.1, 0.6], [1, 1]], network=square())
    stem = chain_between(network, (1, 0), (1, 1))
    for k, chain in enumerate(network.chains, 2):
        network = set_count(network, chain, k)
    for patch in network.patches:
        network = set_choice(network, patch, ("some fill", patch))
    edit = smooth_chain(network, plane(), SIZES, stem)
    check_network(edit.network)
    assert edit.patches == () and edit.notes == ()
    assert edit.network.patches == network.patches
    for chain, line in network.chains.items():
        assert edit.network.chains[chain].count == line.count
        same = edit.network.chains[chain].points.tobytes() == line.points.tobytes()
        assert same == (chain != stem)


def test_on_a_sphere_it_stays_on_the_surface() -> None:
    sizes = Sizes.of(sphere().diagonal)
    drawn_line = [[0.6, -0.5, 0.7], [0.7, 0.0, 0.7], [0.4, 0.3, 0.8]]
    network = insert_stroke(
        Network(), sphere(), sizes, clean_stroke(drawn_line, sphere(), sizes)
    ).network
    (chain,) = network.chains
    done = smooth_chain(network, sphere(), sizes, chain).network
    check_network(done)
    line = done.chains[chain]
    feet = sphere().nearest(line.points)
    assert np.linalg.norm(feet.points - line.points, axis=1).max() < 1e-9
    assert not np.allclose(line.points, network.chains[chain].points, atol=1e-6)


def test_what_cannot_be_smoothed_is_refused() -> None:
    with pytest.raises(InvalidRetopoError, match="no chain 999"):
        smooth_chain(square(), plane(), SIZES, 999)
    bordered = add_borders(Network(), plane(), 0.02)
    (border,) = bordered.chains
    with pytest.raises(RefusedError, match="border"):
        smooth_chain(bordered, plane(), SIZES, border)
    short, chain = add_chain(Network(), [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], [UP] * 3)
    with pytest.raises(RefusedError, match="fewer than 5"):
        smooth_chain(short, plane(), SIZES, chain)
