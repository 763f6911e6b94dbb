"""Quads fitted to a surface: nearer than they were laid, nothing flipped, and what stays, stays."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.crossfield import FieldSolver
from patterndb_sketch.retopo.draft.fieldmesh import remesh_evenly
from patterndb_sketch.retopo.draft.fitting import SPACING, fit_quads, sample_surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.judging import DraftJudge
from patterndb_sketch.retopo.draft.layout import lay_out
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    divide_chain,
    fill_network,
    place_fill,
    weld_patches,
)
from patterndb_sketch.retopo.filling.report import Report, report_mesh
from patterndb_sketch.retopo.network import Network, check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half, Plane, cut_half
from query.engine import PatternSource
from tests.support.retopo.editors import do


@cache
def horned(bent: float = 0.0) -> Surface:
    """A ball with two horns, each about an edge of the draft thick."""
    mesh = trimesh.creation.icosphere(subdivisions=5)
    at = np.array(mesh.vertices)
    for tip in ([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):
        near = np.exp(-60.0 * (1.0 - at @ np.array(tip)))
        at = at + near[:, None] * np.array(tip) + bent * near[:, None] * np.array([0.0, 0.3, 0.0])
    return Surface.from_arrays(at, mesh.faces).orient()


@cache
def laid(source: PatternSource) -> tuple[FilledNetwork, frozenset[int], Surface, Sizes]:
    """A draft that is filled, and fitted to nothing."""
    surface = horned(0.5)
    sizes = Sizes.of(surface.diagonal)
    mesh = TangentFrames.of(
        Surface.from_arrays(*remesh_evenly(surface, SETTINGS.field_edge * sizes.edge)).orient()
    )
    empty = Network(longest=2.0 * surface.diagonal, surface=surface)
    setting = SETTINGS.fields[0]
    field = FieldSolver(mesh, setting.alignment).solve(setting.merging * sizes.edge)
    one = lay_out(empty, surface, sizes, setting, field)
    return fill_network(one.network, surface, source, sizes.edge), one.laid, surface, sizes


def fit(source: PatternSource, kept: tuple[int, ...] = (), still: int = 0) -> FilledNetwork:
    """The draft, fitted; without some of its patches, and of its chains as many of the first."""
    found, lines, surface, sizes = laid(source)
    samples = sample_surface(surface, SPACING * sizes.edge)
    return fit_quads(found, surface, samples, sizes, sorted(lines)[still:], kept)


@cache
def draft_once(bent: float, symmetry: bool, source: PatternSource) -> Retopology:
    """Draft a ball with horns; not to be changed."""
    editor = Retopology(horned(bent), source)
    do(editor, "draft", symmetry=symmetry)
    return editor


def drafted(bent: float, symmetry: bool, source: PatternSource) -> Retopology:
    """Return a retopology of a ball with horns that was just drafted."""
    one = draft_once(bent, symmetry, source)
    editor = Retopology(one.surface, source)
    editor.restore(one.state)
    editor.adopt(editor.network, one.fill())
    return editor


def measure(found: FilledNetwork, surface: Surface) -> tuple[Report, float]:
    made = report_mesh(found, surface)
    return made, max(made.to_surface, made.from_surface)


def test_fitted_quads_are_nearer_and_none_is_flipped(source: PatternSource) -> None:
    before, lines, surface, sizes = laid(source)
    after = fit(source)
    one, far = measure(before, surface)
    two, near = measure(after, surface)
    assert near < 0.02 and near < far
    assert two.flipped == two.open_edges == two.tangled == 0
    assert (one.quads, one.irregular, one.euler) == (two.quads, two.irregular, two.euler)
    check_network(after.network, patches=False)
    assert lines == after.network.chains.keys()
    # Curves lie on the surface, and run through the vertices: these divide them.
    for chain in after.network.chains.values():
        off = np.linalg.norm(surface.nearest(chain.points).points - chain.points, axis=1)
        assert off.max() < 1e-6 * surface.diagonal
        points, _ = divide_chain(chain, after.network.density)
        size = np.linalg.norm(np.diff(points, axis=0), axis=1)
        assert size.min() > 0.2 * size.max()
    # What the network keeps is all that it takes to place them again.
    for patch, placed in after.placed.items():
        again = place_fill(after.network, surface, after.network.patches[patch])
        assert np.array_equal(again.vertices, placed.vertices)
    assert sizes.edge > 0.0


def test_what_is_not_to_move_stays_bit_for_bit(source: PatternSource) -> None:
    before, lines, surface, _ = laid(source)
    kept = tuple(sorted(before.placed)[:3])
    after = fit(source, kept, still=5)
    held = sorted(lines)[:5]
    nodes = {
        n for c in held for n in (before.network.chains[c].start, before.network.chains[c].end)
    }
    for chain in held:
        assert after.network.chains[chain] is before.network.chains[chain]
    for node in nodes:
        assert np.array_equal(after.network.nodes[node].point, before.network.nodes[node].point)
    for patch in kept:
        assert after.network.patches[patch].choice == before.network.patches[patch].choice
    assert report_mesh(after, surface).euler == report_mesh(before, surface).euler
    none = fit(source, tuple(before.placed), still=len(lines))
    assert none is before


@given(st.integers(0, 2**32 - 1), st.floats(0.03, 0.5))
@settings(max_examples=30, deadline=None)
def test_no_point_of_a_surface_is_far_from_its_samples(seed: int, spacing: float) -> None:
    random = np.random.default_rng(seed)
    surface = Surface.from_arrays(random.normal(size=(12, 3)), np.arange(12).reshape(4, 3)).orient()
    samples = sample_surface(surface, spacing)
    corners = surface.vertices[surface.triangles]
    weights = random.dirichlet(np.ones(3), size=(4, 20))
    points = np.einsum("tke,tec->tkc", weights, corners).reshape(-1, 3)
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max()
    reach = max(spacing, longest / 30)
    away = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert away.max() <= reach
    assert np.linalg.norm(surface.nearest(samples).points - samples, axis=1).max() < 1e-9


def test_a_half_is_judged_with_its_image(source: PatternSource) -> None:
    editor = Retopology(horned(), source)
    outcome = do(editor, "draft")
    found = editor.fill()
    half = editor.half
    assert half is not None and outcome.changed
    judge = DraftJudge(half.surface, half)
    made = judge.report(found)
    mesh = editor.mesh(found)
    assert made.quads == len(mesh.quads) and made.open_edges == 0 and made.euler == 2
    assert not judge.is_lopsided(found, made)
    # Of a surface with a bump on the other side alone the image is off, and the half is not.
    at = half.whole.vertices.copy()
    beyond = half.plane.heights(at)
    at[:, 2] -= 0.4 * np.exp(-10.0 * ((at - at[beyond.argmin()]) ** 2).sum(axis=1))
    lopsided = Half(
        half.plane,
        half.surface,
        Surface.from_arrays(at, half.whole.triangles).orient(),
        half.on,
        half.near,
        0,
    )
    other = DraftJudge(half.surface, lopsided)
    worse = other.report(found)
    assert max(worse.to_surface, worse.from_surface) > 0.02 and other.is_lopsided(found, worse)
    assert any("% off at" in said for said in other.list_flaws(found, worse))


@pytest.mark.parametrize("bent", [0.0, 1.0])
def test_a_surface_with_horns_is_drafted_to_their_tips(bent: float, source: PatternSource) -> None:
    surface = horned(bent)
    editor = Retopology(surface, source)
    do(editor, "draft", symmetry=False)
    made = report_mesh(editor.fill(), surface)
    assert made.flipped == made.open_edges == made.tangled == 0 and made.euler == 2
    assert max(made.to_surface, made.from_surface) < 0.02


def test_a_plane_that_the_user_took_is_judged_by_both_sides(source: PatternSource) -> None:
    surface = horned()
    editor = Retopology(surface, source)
    do(editor, "symmetry", point=[0.0, 0.0, 0.0], normal=[1.0, 0.0, 0.0])
    outcome = do(editor, "draft")
    quads = len(editor.mesh(editor.fill()).quads)
    assert any(f" {quads} quads" in note for note in outcome.notes)
    assert cut_half(surface, Plane.of((0, 0, 0), (1, 0, 0))).whole is surface
    assert len(weld_patches(editor.fill()).quads) * 2 == quads


@pytest.mark.parametrize("symmetry", [True, False])
def test_counts_chosen_anew_are_fitted_again(symmetry: bool, source: PatternSource) -> None:
    surface = horned(0.0 if symmetry else 0.5)
    editor = drafted(0.0 if symmetry else 0.5, symmetry, source)
    edge = editor.sizes.edge
    assert all(chain.auto != chain.marked for chain in editor.network.chains.values())
    for times in (0.8, 1.0, 1.3):
        do(editor, "recount", edge=times * edge)
        network = editor.network
        found = editor.fill()
        # All that is chosen was chosen by the call: filling it changes nothing.
        assert found.network is network
        made, off = measure(found, editor.surface_now)
        assert made.flipped == made.tangled == 0 and off < 0.02
        assert report_mesh(found, surface, editor.mesh(found)).euler == 2
    do(editor, "undo")
    check_network(editor.network, patches=False)


def test_only_what_an_edit_fills_anew_is_fitted_again(source: PatternSource) -> None:
    editor = drafted(0.5, False, source)
    before, placed = editor.network, editor.fill().placed
    chain = max(before.chains.values(), key=lambda one: one.count)
    do(editor, "subdivide", at=chain.points[len(chain.points) // 2].tolist(), by=2, strip=True)
    after, now = editor.network, editor.fill().placed
    same = {p for p, patch in after.patches.items() if before.patches[p].choice == patch.choice}
    assert 0 < len(same) < len(now)
    for patch in same:
        assert np.array_equal(now[patch].vertices, placed[patch].vertices)
    owner = after.patch_of()
    for number, one in after.chains.items():
        if same & {owner[2 * number], owner[2 * number + 1]}:
            assert np.array_equal(one.points, before.chains[number].points)
    assert sum(len(one.flipped) for one in now.values()) == 0


def test_a_curve_that_the_user_moves_is_no_longer_moved_by_fitting(source: PatternSource) -> None:
    editor = drafted(0.5, False, source)
    chain = max(editor.network.chains.values(), key=lambda one: one.length)
    at = chain.points[len(chain.points) // 2]
    do(editor, "smooth", at=at.tolist())
    moved = editor.network.chains[chain.id]
    assert not np.array_equal(moved.points, chain.points) and not moved.auto
    do(editor, "recount", edge=1.2 * editor.sizes.edge)
    assert np.array_equal(editor.network.chains[chain.id].points, moved.points)
