"""A thin handle fused into a sheet: patches whose sides differ ten times in the length of edges."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import islice, pairwise

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import Choice, filling_of, place_fill, rank_fills
from patterndb_sketch.retopo.filling.report import report_mesh
from patterndb_sketch.retopo.network import Network, Patch, check_network, set_choice
from patterndb_sketch.retopo.sizes import Sizes
from query.engine import PatternSource
from tests.support.retopo.bridges import FOOT, THIN, bridge, ring

#: The target edge: 3 % of the diagonal, where a quarter of the handle is 0.4 %.
EDGE = 0.03 * bridge().diagonal


def arch(begin: float, end: float, n: int = 30) -> list[list[float]]:
    """Places on the outside of the handle, from angle to angle."""
    out = FOOT + THIN
    return [
        [float(-out * np.cos(a)), 0.0, float(out * np.sin(a))] for a in np.linspace(begin, end, n)
    ]


@cache
def drawn(source: PatternSource) -> Retopology:
    """Rings of four curves along the handle, and around each foot a ring on the sheet."""
    surface = bridge()
    sizes = replace(Sizes.of(surface.diagonal), edge=EDGE, snap=0.002, sampling=0.0005)
    editor = Retopology(surface, source, sizes)

    def do(tool: str, **arguments: object) -> None:
        outcome = editor.do(Call(tool, arguments))
        assert outcome.refused is None, outcome.refused

    places = np.linspace(0.03, np.pi - 0.03, 9)
    for a in places:
        normal = [float(np.sin(a)), 0.0, float(np.cos(a))]
        do("loop", at=arch(a, a, 1)[0], normal=normal)
    for a, b in pairwise(places):
        do("cylinder", points=arch(a, b), division=4, caps="never")
    for end, x in ((places[0], -FOOT), (places[-1], FOOT)):
        circle = ring(0.25, 64) + np.array([x, 0.0])
        do("stroke", points=np.c_[circle, np.zeros(64)].tolist(), closed=True)
        down = arch(end, 0.02 if x < 0 else np.pi - 0.02, 20)
        out = [[float(x + np.sign(x) * r), 0.0, 0.0] for r in np.linspace(1.2 * THIN, 0.25, 29)]
        do("cylinder", points=down + out, division=4, caps="never")
    do("recount")
    return editor


def feet(network: Network) -> list[Patch]:
    """The patches from the handle to the sheet."""
    found: list[Patch] = []
    for patch in network.patches.values():
        long = [sum(network.chains[half >> 1].length for half in side) for side in patch.sides]
        if max(long) > 0.3:
            found.append(patch)
    return found


def test_handle_and_sheet_are_filled_without_a_flip(source: PatternSource) -> None:
    editor = drawn(source)
    found = editor.fill()
    check_network(found.network)
    made = report_mesh(found, bridge())
    assert found.notes == ()
    assert (made.unfilled, made.flipped, made.tangled) == (0, 0, 0)
    assert made.patches == {4: 40}
    # An annulus: what the rings on the sheet leave open are two borders.
    assert made.euler == 0
    mesh = editor.mesh(found)
    edges = np.linalg.norm(
        mesh.vertices[mesh.quads] - mesh.vertices[np.roll(mesh.quads, -1, axis=1)], axis=2
    )
    assert edges.max() > 10 * edges.min()
    assert made.to_surface < 0.004


@pytest.mark.parametrize("seed", range(6))
def test_feet_flip_for_no_counts_that_leave_the_rings_round(
    source: PatternSource, seed: int
) -> None:
    network = drawn(source).fill().network
    chance = np.random.default_rng(seed)
    patches = feet(network)
    assert len(patches) == 8
    for patch in patches[seed % 2 :: 2]:
        # Two edges or more, but on the handle's quarter, which is shorter than any target.
        chains = {half >> 1: network.chains[half >> 1] for half in patch.loop}
        counts = {
            c: int(chance.integers(1 if chain.length < EDGE else 2, 8))
            for c, chain in chains.items()
        }
        longest = max(counts, key=lambda c: chains[c].length)
        counts[longest] += sum(counts.values()) % 2
        counted = {c: replace(chains[c], count=n) for c, n in counts.items()}
        tried = replace(network, chains={**network.chains, **counted})
        for fill in islice(rank_fills(tried, patch, source), 3):
            one = set_choice(tried, patch.id, filling_of(patch).with_choice(Choice.of(fill)))
            assert not len(place_fill(one, bridge(), one.patches[patch.id]).flipped), counts
