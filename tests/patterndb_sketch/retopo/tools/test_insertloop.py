"""Edge loops that are inserted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import patterndb
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import (
    Choice,
    find_irregular_vertices,
    rank_fills,
    side_lengths,
    weld_patches,
)
from patterndb_sketch.retopo.network import Network, are_equal, set_count
from patterndb_sketch.retopo.quadimport import import_quads
from patterndb_sketch.retopo.tools.insertloop import find_edge_at, find_nearest_edge, insert_loop
from query.engine import PatternSource
from tests.support.retopo.editors import (
    SIZES,
    chain_at,
    do,
    drawn_grid,
    drawn_octants,
    line,
    patch_around,
)
from tests.support.retopo.networks import plane
from tests.support.retopo.topology import (
    UP,
    assert_manifold,
    assert_sound,
    choice_of,
    drawn_quads,
    same_poles,
)


@pytest.fixture(scope="module")
def filled_grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads, filled."""
    return drawn_grid(source).fill().network


def test_a_loop_through_a_row_is_twelve_quads_more(
    source: PatternSource, filled_grid: Network
) -> None:
    before = len(drawn_quads(source, filled_grid))
    at = np.array([0.4, 0.03, 0.0])
    edit = insert_loop(filled_grid, plane(), source, SIZES, at, UP)
    assert edit.notes == () and edit.patches == ()
    assert_sound(edit.network)
    assert len(drawn_quads(source, edit.network)) == before + 12
    more = {
        c: edit.network.chains[c].count - chain.count for c, chain in filled_grid.chains.items()
    }
    assert {c for c, n in more.items() if n} == {chain_at(filled_grid, 0.5, y) for y in range(4)}
    assert {edit.network.chains[c].count for c, n in more.items() if n} == {5}
    # What it becomes is what the list would offer for these counts.
    patch = patch_around(filled_grid, 0.5, 1.5)
    listed = rank_fills(edit.network, edit.network.patches[patch], source)
    assert choice_of(edit.network, patch) == Choice.of(next(listed))


def test_a_strip_that_comes_back_at_right_angles_makes_both_counts_grow(
    source: PatternSource,
) -> None:
    editor = drawn_grid(source, 2)
    arc = [[2, 0, 0], [3, 0.2, 0], [3.4, 1.5, 0], [3, 3, 0], [1.5, 3.4, 0], [0.2, 3, 0], [0, 2, 0]]
    do(editor, "stroke", points=arc)
    do(editor, "corner", at=[2, 2, 0], wedge=[2.1, 2.1, 0])
    do(editor, "corner", at=[2, 1, 0], wedge=[2.1, 1, 0])
    bow = next(c for c, chain in editor.network.chains.items() if 4.0 < chain.length < 12.0)
    do(editor, "subdivide", at=editor.network.chains[bow].points[40].tolist(), count=8)
    before = editor.fill()
    assert sorted(len(patch.corners) for patch in before.network.patches.values()) == [4] * 5
    steps = editor.undoable
    do(editor, "insertloop", at=[0.01, 0.3, 0])
    after = editor.fill()
    assert_sound(after.network)
    assert_manifold(weld_patches(after))
    assert editor.undoable == steps + 1
    for x, y in ((0.5, 0), (0, 0.5), (1, 0.5), (0.5, 1), (0.5, 2), (2, 0.5)):
        chain = chain_at(after.network, x, y)
        assert after.network.chains[chain].count == 5, (x, y)
    both = side_lengths(after.network, after.network.patches[patch_around(after.network, 0.5, 0.5)])
    assert both == (5, 5, 5, 5)
    assert after.network.chains[bow].count == 8
    # Both ways through the corner cell, once through the others on the way.
    assert len(weld_patches(after).quads) - len(weld_patches(before).quads) == 9 + 4 + 4 + 8
    do(editor, "undo")
    assert are_equal(editor.network, before.network)


def test_a_strip_around_a_ball_is_closed(source: PatternSource) -> None:
    """Through fills with irregular vertices, from wherever it begins."""
    editor = drawn_octants(source)
    before = editor.fill()
    chain = next(iter(before.network.chains.values()))
    at = chain.points[len(chain.points) // 3]
    do(editor, "insertloop", at=at.tolist())
    after = editor.fill()
    assert_sound(after.network)
    mesh, former = weld_patches(after), weld_patches(before)
    assert_manifold(mesh)
    gained = {
        c: after.network.chains[c].count - one.count for c, one in before.network.chains.items()
    }
    assert gained[chain.id] >= 1
    grown = sum(gained.values())
    sides = sum(sum(side_lengths(after.network, p)) for p in after.network.patches.values())
    assert (
        sides - sum(sum(side_lengths(before.network, p)) for p in before.network.patches.values())
        == 2 * grown
    )
    assert len(mesh.vertices) - len(mesh.quads) == 2
    assert same_poles(find_irregular_vertices(mesh)[1], find_irregular_vertices(former)[1])


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1))
def test_loops_anywhere_keep_what_must_hold(source: PatternSource, seed: int) -> None:
    """In a network with irregular patches, from curves and from within patches."""
    rng = np.random.default_rng(seed)
    editor = mixed(source)
    before = editor.fill()
    former = weld_patches(before)
    at = rng.uniform(0.02, 1.98, 2)
    outcome = editor.do(Call("insertloop", {"at": [*at.tolist(), 0.0]}))
    assert outcome.refused is None and outcome.changed
    assert_sound(editor.network)
    after = editor.fill()
    mesh = weld_patches(after)
    assert_manifold(mesh)
    assert after.network.patches.keys() == before.network.patches.keys()
    for patch in before.network.patches:
        one, two = choice_of(before.network, patch), choice_of(after.network, patch)
        assert (one.code, one.by) == (two.code, two.by)
        assert one.lengths == two.lengths or sum(two.lengths) > sum(one.lengths)
    assert len(mesh.quads) > len(former.quads)
    assert same_poles(find_irregular_vertices(mesh)[1], find_irregular_vertices(former)[1])
    editor.do(Call("undo"))
    assert are_equal(editor.network, before.network)


def mixed(source: PatternSource) -> Retopology:
    """Two by two cells, one cut into triangles, one in two, others with sides of several counts
    and of several curves."""
    editor = drawn_grid(source, 2)
    do(editor, "stroke", points=line((1.5, 0), (1.5, 1)))
    do(editor, "stroke", points=line((0, 0), (1, 1)))
    do(editor, "subdivide", at=[1.3, 1, 0], count=5)
    return editor


def test_pinned_counts_grow_too_and_stay_pinned(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    do(editor, "subdivide", at=[0.5, 0, 0], count=6, strip=True)
    editor.fill()
    do(editor, "insertloop", at=[0.3, 0, 0])
    chain = editor.network.chains[chain_at(editor.network, 0.5, 1)]
    assert (chain.count, chain.pinned) == (7, True)


def test_where_there_are_no_quads_no_loop_is_inserted(source: PatternSource) -> None:
    editor = drawn_grid(source, 1)
    do(editor, "stroke", points=line((3, 0), (4, 0)))
    before = editor.state
    for at in ([3.5, 0, 0], [-2, -2, 0]):
        outcome = editor.do(Call("insertloop", {"at": at}))
        assert outcome.refused == "there is no patch here; point into one"
    assert editor.state is before


def test_no_loop_makes_a_boundary_longer_than_can_be(filled_grid: Network) -> None:
    """The call before it says so, and the network stays as it was."""
    network = filled_grid
    for y in range(4):
        network = set_count(network, chain_at(network, 0.5, y), 996)
    with patterndb.open() as opened, pytest.raises(RefusedError, match="2000 are the most"):
        insert_loop(network, plane(), opened, SIZES, np.array([0.5, 0.0, 0.0]), UP)


def test_edges_of_a_chain_are_told_by_arc_length(filled_grid: Network) -> None:
    chain = filled_grid.chains[chain_at(filled_grid, 0.5, 0)]
    along = arc_length(chain.points)
    for place in np.linspace(0, len(chain.points) - 1, 41):
        length = np.interp(place, np.arange(len(along)), along)
        wanted = min(int(4 * length / along[-1]), 3)
        assert find_edge_at(chain, float(place)) == wanted


def test_a_loop_through_an_imported_mesh_goes_on_to_its_borders(source: PatternSource) -> None:
    """Its patches hold all their vertices; those on the way are placed anew, which is told."""
    side = np.linspace(0.0, 1.0, 7)
    vertices = np.array([[x, y, 0.0] for y in side for x in side])
    vertices[24, :2] += 0.03
    quads = [[7 * j + i, 7 * j + i + 1, 7 * j + i + 8, 7 * j + i + 7]
             for j in range(6) for i in range(6)]  # fmt: skip
    found = import_quads(vertices, quads)
    at, up = np.array([0.5, 0.02, 0.0]), UP
    edit = insert_loop(found.network, found.surface, source, found.sizes, at, up)
    assert_sound(edit.network)
    assert edit.notes and all("placed anew" in note for note in edit.notes)
    total = sum(len(choice_of(edit.network, p).faces) for p in edit.network.patches)
    assert total == 42


def test_the_nearest_edge_of_quads_is_the_nearest(source: PatternSource) -> None:
    placed = next(iter(drawn_grid(source, 1).fill().placed.values()))
    for x, y, middle in ((0.5, 0.38, (0.5, 0.375)), (0.49, 0.6, (0.5, 0.625))):
        half = find_nearest_edge(placed, np.array([x, y, 0.0]))
        tail = placed.quads.ravel()[half]
        head = np.roll(placed.quads, -1, axis=1).ravel()[half]
        at = (placed.vertices[tail] + placed.vertices[head]) / 2
        assert np.linalg.norm(at[:2] - middle) < 0.13


def test_surfaces_need_not_be_flat(source: PatternSource) -> None:
    """On a ball nothing leaves it."""
    editor = drawn_octants(source)
    editor.fill()
    do(editor, "insertloop", at=[0.0, 0.6, 0.8])
    mesh = weld_patches(editor.fill())
    surface: Surface = editor.surface
    off = np.linalg.norm(surface.nearest(mesh.vertices).points - mesh.vertices, axis=1)
    assert off.max() < 1e-9
