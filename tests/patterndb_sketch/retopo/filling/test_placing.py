"""Where the vertices of fills lie: evenly on borders, at rest inside, and where a hand put them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import PlacedCache, divide_chain, fill_network, filling_of
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.network import Network, set_choice
from query.engine import PatternSource
from tests.support.retopo.editors import (
    do,
    drawn_grid,
    drawn_octants,
    line,
    patch_around,
    same_arrays,
)
from tests.support.retopo.filling import EDGE, same_fills
from tests.support.retopo.networks import plane, sphere


@pytest.fixture(scope="module")
def grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads."""
    return drawn_grid(source).fill().network


def test_borders_are_divided_evenly_with_ends_that_are_exact(grid: Network) -> None:
    for chain in grid.chains.values():
        for count in (1, 2, 7):
            points, normals = divide_chain(replace(chain, count=count))
            assert points.shape == normals.shape == (count + 1, 3)
            around = chain.round
            assert same_arrays(points[[0, -1]], around[[0, -1]])
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
            assert steps.max() <= chain.length / count * (1 + 1e-9)
            if not chain.marked:
                assert np.allclose(steps, chain.length / count, rtol=1e-3)


def neighbours(placed_quads: np.ndarray, n: int) -> list[set[int]]:
    found: list[set[int]] = [set() for _ in range(n)]
    for quad in placed_quads.tolist():
        for a, b in zip(quad, [*quad[1:], quad[0]], strict=True):
            found[a].add(b)
            found[b].add(a)
    return found


def test_inside_is_laplace_on_the_plane(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (0.6, 1.2), (1, 2)))
    do(editor, "subdivide", at=[2.5, 0, 0], count=7)
    found = editor.fill()
    inner = 0
    for placed in found.placed.values():
        beside = neighbours(placed.quads, len(placed.vertices))
        for v in range(placed.perimeter, len(placed.vertices)):
            mean = placed.vertices[sorted(beside[v])].mean(axis=0)
            assert np.linalg.norm(placed.vertices[v] - mean) < 1e-9
            inner += 1
        assert placed.at_rest
    assert inner > 50


def test_a_cap_of_eight_by_eight_lies_on_the_sphere(source: PatternSource) -> None:
    editor = Retopology(sphere(), source)
    do(editor, "loop", at=[1, 0, 0.2], normal=[0, 0, 1])
    for k in range(4):
        turn = np.pi / 4 + k * np.pi / 2
        do(editor, "corner", at=[np.cos(turn), np.sin(turn), 0.2])
    for chain in list(editor.network.chains.values()):
        do(editor, "subdivide", at=chain.points[len(chain.points) // 2].tolist(), count=8)
    found = editor.fill()
    (placed,) = found.placed.values()
    assert len(placed.quads) == 64
    assert len(placed.flipped) == 0
    assert placed.at_rest
    feet = editor.surface.nearest(placed.vertices).points
    assert np.linalg.norm(feet - placed.vertices, axis=1).max() < 1e-9


def test_vertices_moved_by_hand_stay_and_what_they_flip_is_told(
    source: PatternSource, grid: Network
) -> None:
    patch = patch_around(grid, 1.5, 1.5)
    filling = filling_of(grid.patches[patch])
    assert filling.choice is not None
    before = fill_network(grid, plane(), source, EDGE)
    inner = filling.choice.perimeter + 4
    near = before.placed[patch].vertices[inner] + [0.05, 0.05, 0]
    for place, flips in ((near, False), (np.array([2.4, 2.4, 0]), True)):
        network = set_choice(grid, patch, filling.with_moved([inner], [place]))
        found = fill_network(network, plane(), source, EDGE)
        placed = found.placed[patch]
        assert same_arrays(placed.vertices[inner], place)
        others = np.arange(len(placed.vertices)) != inner
        assert same_arrays(placed.vertices[others], before.placed[patch].vertices[others])
        assert bool(len(placed.flipped)) == flips
        assert any("flipped" in note for note in found.notes) == flips
    every = before.placed[patch].vertices * [1, 1, 0] + [0, 0, 0.5]
    whole = filling.with_moved(np.arange(len(every)), every)
    found = fill_network(set_choice(grid, patch, whole), plane(), source, EDGE)
    assert same_arrays(found.placed[patch].vertices, every)


def test_what_was_placed_before_changes_no_result(source: PatternSource) -> None:
    """An editor that keeps places, and one that does not, through edits and undoing."""
    editor = drawn_grid(source, 2)
    calls = (
        Call("sizes", {"edge": 0.2}),
        Call("subdivide", {"at": [0.5, 0, 0], "by": 1}),
        Call("stroke", {"points": line((0, 0.5), (1, 0.6))}),
        Call("undo"),
        Call("knot", {"at": [1, 1, 0], "radius": 0.3}),
        Call("flow", {"points": line((0.1, 1.5), (0.8, 1.5))}),
        Call("undo"),
        Call("undo"),
        Call("redo"),
        Call("recount", {"edge": 0.15}),
    )
    kept = PlacedCache()
    for call in calls:
        assert editor.do(call).changed
        network, surface, edge = editor.network, editor.surface, editor.sizes.edge
        fresh = fill_network(network, surface, source, edge)
        assert same_fills(fresh, fill_network(network, surface, source, edge, kept))
        assert same_fills(fresh, fill_network(network, surface, source, edge, kept))
        assert same_fills(fresh, editor.fill())


def test_points_are_found_in_their_patches(source: PatternSource) -> None:
    editor = drawn_grid(source)
    for x, y in ((0.5, 0.5), (1.1, 2.9), (2.95, 0.05)):
        middle = (int(x) + 0.5, int(y) + 0.5)
        assert find_patch(editor.network, plane(), [x, y, 0.3]) == patch_around(
            editor.network, *middle
        )
    for x, y in ((-1, -1), (-0.01, 0.5), (3.01, 2.99)):
        with pytest.raises(RefusedError, match="there is no patch here"):
            find_patch(editor.network, plane(), [x, y, 0])
    assert find_patch(editor.network, plane(), [0, 0.5, 0]) == patch_around(
        editor.network, 0.5, 0.5
    )
    octants = drawn_octants(source)
    found = {
        find_patch(octants.network, octants.surface, [x, y, z])
        for x in (-1, 1)
        for y in (-1, 1)
        for z in (-1, 1)
    }
    assert len(found) == 8
