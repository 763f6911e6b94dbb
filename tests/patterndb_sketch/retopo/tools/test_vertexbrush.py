"""The vertex brush: placed vertices are dragged and smoothed, and curves follow them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import RetopoMesh, fill_network, filling_of, weld_patches
from patterndb_sketch.retopo.network import Edit, Network, are_equal, check_network, set_count
from patterndb_sketch.retopo.quadimport import import_quads
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.brush import STILL, drag_vertices, relax_vertices
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

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def grid(source: PatternSource) -> Network:
    """2 x 2 patches of 4 x 4 quads on the plane, filled."""
    return drawn_grid(source, 2).fill().network


def mesh_of(network: Network, surface: Surface, source: PatternSource) -> RetopoMesh:
    found = fill_network(network, surface, source, SIZES.edge)
    assert found.network is network, "counts and fills are there"
    return weld_patches(found)


def wide(radius: float) -> Sizes:
    return replace(SIZES, brush=radius)


def assert_kept(before: Network, edit: Edit) -> None:
    """Ids, loops, counts and fills are as they were."""
    after = edit.network
    check_network(after)
    assert after.nodes.keys() == before.nodes.keys()
    assert after.chains.keys() == before.chains.keys()
    assert after.patches.keys() == before.patches.keys()
    assert (edit.nodes, edit.chains, edit.patches) == ((), (), ())
    for c, chain in before.chains.items():
        assert (after.chains[c].count, after.chains[c].pinned) == (chain.count, chain.pinned)
    for p, patch in before.patches.items():
        assert after.patches[p].loop == patch.loop
        assert filling_of(after.patches[p]).choice == filling_of(patch).choice


def shares(points: Points, at: Points, radius: float) -> Points:
    """(v, 1) the falloff, in its words."""
    t = np.minimum(np.linalg.norm(points - at, axis=1) / radius, 1.0)
    return ((1.0 - t) ** 4 * (4.0 * t + 1.0))[:, None]


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_vertices_follow_by_the_shares_that_are_said(
    source: PatternSource, grid: Network, seed: int
) -> None:
    """Inner ones exactly, also at the next call; what is not under the brush stays bit for bit."""
    rng = np.random.default_rng(seed)
    at = np.r_[rng.uniform(0.1, 1.9, 2), 0.0]
    radius = float(rng.uniform(0.2, 0.8))
    drag = np.r_[rng.uniform(-0.08, 0.08, 2), 0.0]
    former = mesh_of(grid, plane(), source)
    edit = drag_vertices(grid, plane(), source, wide(radius), at, UP, at + drag)
    assert_kept(grid, edit)
    mesh = mesh_of(edit.network, plane(), source)
    assert (mesh.quads == former.quads).all()
    wanted = former.vertices + shares(former.vertices, at, radius) * drag
    inner = (former.node < 0) & (former.chain < 0)
    nodes = former.node >= 0
    assert np.allclose(mesh.vertices[inner | nodes], wanted[inner | nodes], rtol=0, atol=2e-8)
    for chain in edit.network.chains.values():
        old = grid.chains[chain.id]
        on = former.chain == chain.id
        ends = np.isin(former.node, (chain.start, chain.end))
        off = np.abs(wanted[on | ends] - former.vertices[on | ends]).max()
        if off < 0.9 * STILL * plane().diagonal:
            assert chain is old
        elif off > 1.1 * STILL * plane().diagonal:
            # It passes where its vertices went; samples are as near as those of any curve.
            for point in wanted[on]:
                assert np.linalg.norm(chain.points - point, axis=1).min() <= SIZES.sampling
    again = drag_vertices(
        edit.network, plane(), source, wide(0.05), inside(mesh), UP, inside(mesh) + drag
    )
    held = mesh_of(again.network, plane(), source)
    still = np.linalg.norm(mesh.vertices - inside(mesh), axis=1) >= 0.05
    assert np.array_equal(held.vertices[still], mesh.vertices[still])


def inside(mesh: RetopoMesh) -> Points:
    """An inner vertex."""
    return mesh.vertices[np.flatnonzero((mesh.node < 0) & (mesh.chain < 0))[5]]


def test_no_drag_is_no_change(source: PatternSource, grid: Network) -> None:
    at = np.array([0.7, 0.7, 0.0])
    assert drag_vertices(grid, plane(), source, SIZES, at, UP, at).network is grid
    # A drag across the plane is none either.
    lifted = drag_vertices(grid, plane(), source, SIZES, at, UP, at + UP)
    assert lifted.network is grid
    # And quads that are at rest are so after smoothing.
    assert relax_vertices(grid, plane(), source, wide(0.4), at, UP).network is grid


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_smoothing_takes_vertices_to_the_mean_of_all_around(
    source: PatternSource, grid: Network, seed: int
) -> None:
    """Corners and sides, too; as told by a plain count of neighbours."""
    rng = np.random.default_rng(seed)
    at = np.r_[rng.uniform(0.8, 1.2, 2), 0.0]
    bent = drag_vertices(
        grid, plane(), source, wide(0.5), at, UP, at + np.array([0.08, -0.05, 0.0])
    ).network
    former = mesh_of(bent, plane(), source)
    middle = np.r_[rng.uniform(0.7, 1.3, 2), 0.0]
    edit = relax_vertices(bent, plane(), source, wide(0.6), middle, UP, rounds=1)
    assert_kept(bent, edit)
    mesh = mesh_of(edit.network, plane(), source)
    share = shares(former.vertices, middle, 0.6)
    beside: dict[int, set[int]] = {}
    for quad in former.quads.tolist():
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            beside.setdefault(a, set()).add(b)
            beside.setdefault(b, set()).add(a)
    for v in range(len(former.vertices)):
        mean = former.vertices[sorted(beside[v])].mean(axis=0)
        wanted = former.vertices[v] + share[v] * (mean - former.vertices[v])
        if former.chain[v] < 0 and len(beside[v]) == 4:
            assert np.allclose(mesh.vertices[v], wanted, atol=1e-9)
        elif len(beside[v]) < 4:
            assert np.allclose(mesh.vertices[v], former.vertices[v], atol=1e-12)
        else:
            points = edit.network.chains[int(former.chain[v])].points
            assert np.linalg.norm(points - wanted, axis=1).min() <= SIZES.sampling


def test_what_was_bent_is_smoothed_straight_again(source: PatternSource, grid: Network) -> None:
    at = np.array([1.0, 1.0, 0.0])
    network = drag_vertices(
        grid, plane(), source, wide(0.6), at, UP, at + np.array([0.1, 0.07, 0.0])
    ).network
    straight = mesh_of(grid, plane(), source).vertices

    def bent() -> float:
        return float(np.abs(mesh_of(network, plane(), source).vertices - straight).max())

    off = [bent()]
    for _ in range(4):
        network = relax_vertices(network, plane(), source, wide(2.0), at, UP, rounds=40).network
        off.append(bent())
    assert off[0] > 0.05 and off[1] < 0.1 * off[0]
    # Placing is at rest to so much.
    assert max(off[2:]) < 5e-4


def test_on_a_ball_vertices_stay_on_it_and_those_behind_stay(source: PatternSource) -> None:
    editor = drawn_octants(source)
    found = editor.fill()
    surface, before = editor.surface, editor.network
    foot = surface.nearest(np.array([[0.1, 0.2, 1.0]]))
    sizes = replace(editor.sizes, brush=2.5)
    at, up = foot.points[0], foot.normals[0]
    former = weld_patches(found)
    to = surface.nearest((at + np.array([0.1, 0.0, 0.0]))[None]).points[0]
    edits = [drag_vertices(before, surface, source, sizes, at, up, to)]
    edits.append(relax_vertices(edits[0].network, surface, source, sizes, at, up))
    for edit in edits:
        assert_kept(before, edit)
        mesh = mesh_of(edit.network, surface, source)
        off = np.linalg.norm(surface.nearest(mesh.vertices).points - mesh.vertices, axis=1)
        assert off.max() < 1e-9
        behind = (former.normals @ up < -0.1) & (former.chain < 0)
        assert np.array_equal(mesh.vertices[behind], former.vertices[behind])
        assert not np.array_equal(mesh.vertices, former.vertices)


def test_borders_and_the_seam_stay(source: PatternSource) -> None:
    """What is beside them moves."""
    editor = Retopology(plane(), source, SIZES)
    do(editor, "stroke", points=line((-5, 4), (-4, 4)))
    do(editor, "stroke", points=line((-4, 4), (-4, 5)))
    editor.fill()
    marked = {c: chain for c, chain in editor.network.chains.items() if chain.marked}
    before = editor.network
    do(editor, "brush", at=[-4.7, 4.7, 0], to=[-4.6, 4.7, 0], radius=1.5)
    for c, chain in marked.items():
        assert editor.network.chains[c] is chain
    assert not are_equal(editor.network, before)
    # A curve that ends on a border bends towards its end, which stays, and does not jump.
    do(editor, "brush", at=[-4.9, 4.1, 0], to=[-4.9, 4.4, 0], radius=0.9)
    curve = editor.network.chains[chain_at(before, -4.5, 4)].points
    assert np.array_equal(curve[0], [-5.0, 4.0, 0.0])
    steps = np.diff(curve, axis=0)
    assert (np.abs(steps[:, 1]) < 3.0 * steps[:, 0]).all()
    assert curve[:, 1].max() > 4.1
    do(editor, "relax", at=[-4.7, 4.7, 0], radius=1.5)
    for c, chain in marked.items():
        assert editor.network.chains[c] is chain


def test_calls_are_undone_exactly(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    before = editor.fill()
    state = editor.state
    do(editor, "brush", at=[0.9, 0.9, 0], to=[1.0, 0.85, 0])
    after = editor.fill()
    assert after.notes == ()
    do(editor, "relax", at=[1, 1, 0], radius=0.8, rounds=3)
    editor.fill()
    do(editor, "undo")
    assert editor.fill().network is after.network
    do(editor, "undo")
    assert editor.state is state
    assert are_equal(editor.network, before.network)
    for call in (
        Call("brush", {"at": [-3, -3, 0], "to": [-3, -2.9, 0]}),
        Call("relax", {"at": [-3, -3, 0]}),
    ):
        outcome = editor.do(call)
        assert outcome.refused == "no quads are near; point at some"
    same = editor.do(Call("brush", {"at": [0.9, 0.9, 0], "to": [0.9, 0.9, 0]}))
    assert (same.changed, same.refused) == (False, None)
    assert editor.state is state


def test_only_the_patches_under_the_brush_are_filled(source: PatternSource) -> None:
    """Counts are chosen for all, which costs little."""
    editor = drawn_grid(source, 3)
    at = np.array([0.5, 0.5, 0.0])
    edit = drag_vertices(
        editor.network, plane(), source, wide(0.2), at, UP, at + np.array([0.05, 0, 0])
    )
    filled = {p for p in edit.network.patches if filling_of(edit.network.patches[p]).choice}
    assert filled == {patch_around(edit.network, 0.5, 0.5)}


def test_an_imported_mesh_keeps_all_its_other_vertices(source: PatternSource) -> None:
    """Where its vertices are not spread evenly along its curves, too."""
    step = np.cumsum([0.0, 0.1, 0.2, 0.15, 0.1, 0.25, 0.2])
    vertices = np.array([[x, y, 0.0] for y in step for x in step])
    quads = [[7 * j + i, 7 * j + i + 1, 7 * j + i + 8, 7 * j + i + 7]
             for j in range(6) for i in range(6)]  # fmt: skip
    found = import_quads(vertices, quads)
    at = vertices[24]
    sizes = replace(found.sizes, brush=0.3)
    former = weld_patches(found.filled)
    edit = drag_vertices(
        found.network, found.surface, source, sizes, at, UP, at + np.array([0.05, 0.02, 0])
    )
    mesh = mesh_of(edit.network, found.surface, source)
    rim = np.abs(former.vertices[:, :2] - 0.5).max(axis=1) > 0.5 - 1e-9
    wanted = former.vertices + shares(former.vertices, at, 0.3) * [0.05, 0.02, 0] * ~rim[:, None]
    assert np.allclose(mesh.vertices, wanted, atol=1e-9)
    # On a border they slide along it alone, and its corners stay.
    edge = np.array([0.45, 0.0, 0.0])
    slid = relax_vertices(found.network, found.surface, source, sizes, edge, UP, rounds=1)
    mesh = mesh_of(slid.network, found.surface, source)
    on = np.flatnonzero(
        (former.vertices[:, 1] == 0.0) & (mesh.vertices != former.vertices).any(axis=1)
    )
    assert len(on) >= 2
    assert np.allclose(mesh.vertices[on, 1], 0.0)
    for v in on:
        x = former.vertices[v, 0]
        k = int(np.abs(step - x).argmin())
        share = shares(former.vertices[[v]], edge, 0.3)[0, 0]
        assert mesh.vertices[v, 0] == pytest.approx(
            x + share * ((step[k - 1] + step[k + 1]) / 2 - x)
        )
    chains = slid.network.chains
    assert all(chains[c] is one for c, one in found.network.chains.items() if one.marked)


def test_what_cannot_be_filled_is_told_and_the_rest_moves(
    source: PatternSource, grid: Network
) -> None:
    """All counts around one patch are pinned, and their sum is odd."""
    patch = patch_around(grid, 0.5, 0.5)
    network = grid
    for half, count in zip(grid.patches[patch].loop, (4, 4, 4, 3), strict=True):
        network = set_count(network, half >> 1, count, pinned=True)
    at = np.array([1.0, 0.5, 0.0])
    to = at + np.array([0.03, 0.0, 0.0])
    edit = drag_vertices(network, plane(), source, wide(0.3), at, UP, to)
    assert len(edit.notes) == 2 and all(str(patch) in note for note in edit.notes)
    other = filling_of(edit.network.patches[patch_around(edit.network, 1.5, 0.5)])
    assert len(other.moved_vertices[0]) > 0
    assert not len(filling_of(edit.network.patches[patch]).moved_vertices[0])
    chain = chain_at(network, 1, 0.5)
    assert not np.array_equal(edit.network.chains[chain].points, network.chains[chain].points)
