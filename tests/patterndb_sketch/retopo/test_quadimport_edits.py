"""Imported quad meshes are networks like others: filled, edited, and laid on another surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import trimesh

import patterndb
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import fill_network, find_open_edges, weld_patches
from patterndb_sketch.retopo.filling.fills import step_fill
from patterndb_sketch.retopo.network import Network, check_network
from patterndb_sketch.retopo.quadimport import import_quads
from patterndb_sketch.retopo.tools.erase import erase_chains
from tests.support.retopo.quadmeshes import cube, refined, thirds


def test_filling_leaves_what_was_imported() -> None:
    """Counts, fills and places are there already: filling changes no bit, and an edit only what
    is beside it."""
    ball = trimesh.creation.icosphere(subdivisions=0)
    points, quads = refined(*thirds(ball.vertices, ball.faces), 2)
    found = import_quads(points + 0.01 * np.random.default_rng(1).normal(size=points.shape), quads)
    assert len(found.network.patches) == 60
    with patterndb.open() as source:
        whole = fill_network(found.network, found.surface, source, found.sizes.edge)
        assert whole.network is found.network
        assert (
            weld_patches(whole).vertices.tobytes() == weld_patches(found.filled).vertices.tobytes()
        )
        # The fill is the database's own: another can be taken, and the first again.
        patch = min(found.network.patches)
        other = step_fill(found.network, patch, source, 1)
        assert other.patches[patch].choice != found.network.patches[patch].choice
        again = step_fill(other, patch, source, -1)
        former = found.network.patches[patch].choice.choice
        assert again.patches[patch].choice.choice == former
        # Without one curve two patches are one.
        edit = erase_chains(found.network, [0])
        check_network(edit.network)
        assert len(edit.network.patches) == 59
        after = fill_network(edit.network, found.surface, source, found.sizes.edge)
    made = weld_patches(after)
    assert len(find_open_edges(made)) == 0
    kept = found.network.patches.keys() & edit.network.patches.keys()
    assert len(kept) == 58
    for patch in kept:
        assert (
            after.placed[patch].vertices.tobytes() == found.filled.placed[patch].vertices.tobytes()
        )


def test_corners_that_were_regular_go_with_their_curves() -> None:
    """Erasing a curve from an irregular vertex to the border joins the border again."""
    points = np.array([[i, j, 0.0] for i in range(5) for j in range(5)])
    every = [
        [5 * i + j, 5 * i + 5 + j, 5 * i + 6 + j, 5 * i + 1 + j]
        for i in range(4)
        for j in range(4)
        if not (i >= 2 and j >= 2)
    ]
    # Without the limit to how long a loop may be, which this sheet's reach.
    network: Network = replace(import_quads(points, np.array(every)).network, longest=np.inf)
    inner = [chain.id for chain in network.chains.values() if not chain.marked]
    assert len(inner) == 2
    after = erase_chains(network, inner[:1]).network
    check_network(after)
    assert len(after.nodes) == len(network.nodes) - 1
    assert len(after.patches) == 2


def test_on_another_surface_vertices_lie_on_it() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    surface = Surface.from_arrays(ball.vertices, ball.faces).orient()
    points, quads = cube(4)
    points = 2.0 * points - 1.0
    found = import_quads(points, quads, surface)
    check_network(found.network)
    made = weld_patches(found.filled)
    gaps = surface.nearest(made.vertices).points - made.vertices
    assert abs(gaps).max() < 1e-12
    for chain in found.network.chains.values():
        gaps = surface.nearest(chain.points).points - chain.points
        assert abs(gaps).max() < 1e-12
    assert len(find_open_edges(made)) == 0


def test_quads_follow_a_curve_that_is_pulled() -> None:
    """Held vertices of the patches beside it are let go; all others stay where they were."""
    points, quads = cube(4)
    with patterndb.open() as source:
        editor = Retopology.of_quads(import_quads(points, quads), source)
        before = weld_patches(editor.fill())
        outcome = editor.do(Call("pull", {"at": [1.0, 0.5, 0.0], "to": [1.0, 0.5, 0.2]}))
        assert outcome.changed, outcome.refused
        check_network(editor.network)
        after = weld_patches(editor.fill())
        assert len(after.quads) == len(quads)
        assert len(find_open_edges(after)) == 0
        one, two = ({tuple(p) for p in m.vertices.tolist()} for m in (before, after))
        kept = one & two
        # The two patches beside the cube's edge moved, the inner vertices of the others not.
        assert 4 * 9 <= len(kept) < len(before.vertices) - 2 * 9
        editor.do(Call("undo"))
        assert np.array_equal(weld_patches(editor.fill()).vertices, before.vertices)
