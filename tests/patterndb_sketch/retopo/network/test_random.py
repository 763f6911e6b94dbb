"""Random sequences of all edits, on a plane with borders and on a sphere, with undo."""

from __future__ import annotations

import copy
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    Edit,
    Network,
    add_borders,
    are_equal,
    check_network,
    set_count,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.corner import flip_wedge, toggle_corner
from patterndb_sketch.retopo.tools.erase import erase_crossed_chains, erase_open_chains
from patterndb_sketch.retopo.tools.knot import clean_knot
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.networks import genus, is_drawn_within, plane, sphere

#: Coarse for what is drawn, so that much is near to each other.
SIZES = Sizes(snap=0.1, spine=1.0, autocompletion=1.0, brush=1.0, edge=0.2, sampling=0.03)

EDITS = ("insert",) * 5 + ("erase", "erase open", "toggle", "flip", "knot", "count", "undo")


def scribble(rng: np.random.Generator, surface: Surface) -> SurfaceCurve:
    """A stroke through some random places; on a plane at times on a grid, over others."""
    places = rng.uniform(-0.9, 0.9, (rng.integers(2, 7), 2))
    if surface is plane() and rng.random() < 0.3:
        places = np.round(places * 4.0) / 4.0
    if rng.random() < 0.1:
        places[-1] = [6.0, 0.0]
    height = 0.9 if surface is sphere() else 0.0
    return clean_stroke(np.c_[places, np.full(len(places), height)], surface, SIZES)


def place(rng: np.random.Generator, network: Network, surface: Surface) -> tuple[np.ndarray, ...]:
    """A point on the surface and its normal, mostly at or near a chain."""
    at = rng.uniform(-0.9, 0.9, 3)
    if network.chains and rng.random() < 0.8:
        chain = network.chains[int(rng.choice(sorted(network.chains)))]
        at = chain.points[rng.choice([0, len(chain.points) // 2, -1])] + rng.normal(0.0, 0.02, 3)
    foot = surface.nearest(at[None])
    return foot.points[0], foot.normals[0]


def edited(rng: np.random.Generator, name: str, network: Network, surface: Surface) -> Network:
    """After one edit by name; raises RefusedError as the tools do."""
    point, normal = place(rng, network, surface)
    made: Edit
    match name:
        case "insert":
            smooth = (bool(rng.random() < 0.3), bool(rng.random() < 0.3))
            made = insert_stroke(network, surface, SIZES, scribble(rng, surface), smooth=smooth)
        case "erase":
            made = erase_crossed_chains(network, scribble(rng, surface))
        case "erase open":
            made = erase_open_chains(network)
        case "toggle":
            made = toggle_corner(network, SIZES, point, normal)
        case "flip":
            made = flip_wedge(network, SIZES, point + rng.normal(0, 0.05, 3), point, normal)
        case "knot":
            made = clean_knot(network, surface, SIZES, point, normal)
        case _:
            if not network.chains:
                raise RefusedError("no chain yet")
            chain = int(rng.choice(sorted(network.chains)))
            return set_count(network, chain, int(rng.integers(1, 20)), bool(rng.random() < 0.5))
    for ids, now, before in (
        (made.nodes, made.network.nodes, network.nodes),
        (made.chains, made.network.chains, network.chains),
        (made.patches, made.network.patches, network.patches),
    ):
        assert set(ids) == now.keys() - before.keys()
        assert all(k >= network.next_id for k in ids), "an id was used again"
    return made.network


@pytest.mark.parametrize("surface", [plane, sphere], ids=["plane", "sphere"])
@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from(EDITS), min_size=1, max_size=12))
def test_any_edits_leave_a_sound_network(surface, seed: int, names: list[str]) -> None:
    rng = np.random.default_rng(seed)
    on = surface()
    network = add_borders(Network(longest=2.0 * on.diagonal), on, 0.1)
    history = [network]
    kept = [copy.deepcopy(network)]
    for name in names:
        if name == "undo":
            back = int(rng.integers(len(history)))
            network = history[back]
            assert are_equal(network, kept[back])
            continue
        try:
            after = edited(rng, name, network, on)
        except RefusedError:
            assert are_equal(network, kept[history.index(network)])
            continue
        check_network(after)
        assert genus(after) == 0 and is_drawn_within(after)
        network = after
        history.append(network)
        kept.append(copy.deepcopy(network))
    assert all(are_equal(one, two) for one, two in zip(history, kept, strict=True))


@pytest.mark.parametrize("surface", [plane, sphere], ids=["plane", "sphere"])
@pytest.mark.parametrize("seed", range(6))
def test_the_order_around_nodes_is_that_of_a_drawing(surface, seed: int) -> None:
    rng = np.random.default_rng(seed)
    on = surface()
    network = Network()
    for _ in range(10):
        places = rng.uniform(-0.9, 0.9, (3, 2))
        height = 0.9 if on is sphere() else 0.0
        stroke = clean_stroke(np.c_[places, np.full(3, height)], on, SIZES)
        with suppress(RefusedError):  # it may lie on another
            network = insert_stroke(network, on, SIZES, stroke).network
        check_network(network)
        assert genus(network) == 0


@pytest.mark.parametrize("surface", [plane, sphere], ids=["plane", "sphere"])
def test_the_same_edits_give_the_same_network(surface) -> None:
    results: list[Network] = []
    for _ in range(2):
        rng = np.random.default_rng(7)
        network = Network()
        for name in EDITS[:-1] * 2:
            try:
                network = edited(rng, name, network, surface())
            except RefusedError:
                continue
        results.append(network)
    assert are_equal(*results)
