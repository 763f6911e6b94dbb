"""First drafts: indices, invariants of networks and meshes, and what is refused, with its place."""

from __future__ import annotations

import ctypes
import re
import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.counts import choosing
from patterndb_sketch.retopo.draft import layout, manifold, parts, proposing
from patterndb_sketch.retopo.draft.crossfield import CrossField, FieldSolver
from patterndb_sketch.retopo.draft.fieldmesh import remesh_evenly
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.judging import Draft, DraftJudge
from patterndb_sketch.retopo.draft.manifold import (
    HandleLoop,
    check_surface,
    find_shortest_handle,
    part_touching,
)
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.draft.task import DraftBudget, DraftRequest, DraftTask
from patterndb_sketch.retopo.draft.tracing import (
    AT_BORDER,
    AT_LINE,
    LineSegments,
    start_at_vertices,
    trace_lines,
)
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import FilledNetwork
from patterndb_sketch.retopo.filling.report import Report, report_mesh
from patterndb_sketch.retopo.network import (
    BORDER,
    Network,
    add_borders,
    are_equal,
    check_network,
    count_genus,
)
from patterndb_sketch.retopo.network.faces import SurfaceParts
from patterndb_sketch.retopo.network.structure import SYMMETRY
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Plane, cut_half
from patterndb_sketch.retopo.tool import ToolWork
from patterndb_sketch.retopo.tools import draft
from patterndb_sketch.retopo.wording import format_place
from query.engine import PatternSource
from tests.support.retopo.editors import do
from tests.support.retopo.networks import sphere


@cache
def torus() -> Surface:
    mesh = trimesh.creation.torus(1.0, 0.4, major_sections=64, minor_sections=32)
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


@cache
def box() -> Surface:
    mesh = trimesh.creation.box((2.0, 1.2, 1.0)).subdivide().subdivide().subdivide()
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


@cache
def bean() -> Surface:
    """A ball that is bent and drawn out, so that it has no plane of symmetry of its own."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    x, y, z = mesh.vertices.T
    points = np.stack([1.6 * x + 0.3 * z * z, y + 0.25 * x * x + 0.1 * z, 0.8 * z + 0.2 * x * y], 1)
    return Surface.from_arrays(points, mesh.faces).orient()


@cache
def dish() -> Surface:
    """Two thirds of a ball, open."""
    return cut_half(sphere(), Plane.of((0.0, 0.0, -0.3), (0.0, 0.0, 1.0))).surface


@cache
def field_of(make: Callable[[], Surface], merging: float = 0.0) -> CrossField:
    surface = make()
    vertices, triangles = remesh_evenly(surface, 0.03 * surface.diagonal)
    mesh = TangentFrames.of(Surface.from_arrays(vertices, triangles).orient())
    return FieldSolver(mesh, 0.003).solve(merging * surface.diagonal)


@pytest.mark.parametrize("make", [sphere, torus, box, bean, dish])
def test_remeshing_keeps_handles_and_borders_and_makes_edges_alike(
    make: Callable[[], Surface],
) -> None:
    surface = make()
    wanted = 0.03 * surface.diagonal
    vertices, triangles = remesh_evenly(surface, wanted)
    mesh = TangentFrames.of(Surface.from_arrays(vertices, triangles).orient())
    assert mesh.euler == TangentFrames.of(surface).euler
    assert np.diff(mesh.surface.adjacency.side_start).max() == 2
    ends = mesh.surface.adjacency.ends
    lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    assert np.quantile(lengths, 0.05) > 0.5 * wanted and np.quantile(lengths, 0.95) < 1.5 * wanted
    off = np.linalg.norm(surface.nearest(vertices).points - vertices, axis=1)
    assert off.max() < 1e-9 * surface.diagonal
    corner = vertices[triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    facing = np.einsum("tc,tc->t", across, surface.nearest(corner.mean(axis=1)).normals)
    assert (facing > 0.0).all()
    again = remesh_evenly(surface, wanted)
    assert (again[0] == vertices).all() and (again[1] == triangles).all()


def test_a_flat_sheet_is_remeshed_flat_with_its_outline() -> None:
    # Two triangles of 10 units: all that is there afterwards is made by halving.
    sheet = Surface.from_arrays(
        [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], [[0, 1, 2], [0, 2, 3]]
    ).orient()
    vertices, triangles = remesh_evenly(sheet, 0.5)
    surface = Surface.from_arrays(vertices, triangles).orient()
    assert surface.areas.sum() == pytest.approx(100.0)
    assert len(triangles) == pytest.approx(100.0 / (0.433 * 0.25), rel=0.25)
    border = vertices[surface.triangles.ravel()[surface.adjacency.border]]
    assert (np.isin(border[:, 0], (0.0, 10.0)) | np.isin(border[:, 1], (0.0, 10.0))).all()


@pytest.mark.parametrize("make", [sphere, torus, box, bean, dish])
@pytest.mark.parametrize("merging", [0.0, 0.15])
def test_indices_sum_to_four_times_the_euler_number(
    make: Callable[[], Surface], merging: float
) -> None:
    field = field_of(make, merging)
    assert field.index.sum() == 4 * field.mesh.euler
    sides = field.mesh.inner
    other = field.mesh.across[sides]
    gap = field.angle[other // 3] - field.angle[sides // 3] - field.mesh.turn[sides]
    gap -= 0.5 * np.pi * field.quarters[sides]
    # What a side says, its opposite says, too: the matchings are those of one field.
    back = np.empty(3 * len(field.angle))
    back[sides] = gap
    np.testing.assert_allclose(back[sides], -back[other], atol=1e-9)


def test_a_ball_has_eight_singularities_a_box_one_a_corner_and_a_torus_none() -> None:
    ball = field_of(sphere, 0.2)
    assert np.bincount(ball.index, minlength=2).tolist() == [len(ball.index) - 8, 8]
    corners = field_of(box, 0.1)
    assert (corners.index >= 0).all() and corners.index.sum() == 8
    points = corners.mesh.vertices[corners.singular]
    assert len({tuple(np.sign(p).tolist()) for p in points}) == 8
    assert not field_of(torus, 0.3).index.any()


@pytest.mark.parametrize("make", [sphere, box, bean, dish])
def test_cancelling_only_takes_away(make: Callable[[], Surface]) -> None:
    before, after = field_of(make), field_of(make, 0.15)
    assert np.abs(after.index).sum() <= np.abs(before.index).sum()
    changed = np.flatnonzero(before.index != after.index)
    assert (np.abs(after.index[changed]) < np.abs(before.index[changed])).all()


@pytest.mark.parametrize("make", [box, bean, dish])
def test_every_singularity_has_its_directions_and_every_trace_ends(
    make: Callable[[], Surface],
) -> None:
    field = field_of(make, 0.05)
    starts = start_at_vertices(field, field.singular.tolist())
    counts = np.bincount(starts.vertex, minlength=len(field.index))
    border = field.mesh.on_border
    wanted = np.where(border, 1 - field.index, 4 - field.index)
    assert (counts[field.singular] == wanted[field.singular]).all()
    traced = trace_lines(field, starts, LineSegments.none(), 0, 20.0 * field.mesh.surface.diagonal)
    assert np.isin(traced.ended, (AT_LINE, AT_BORDER)).all()
    # Each trace's pieces follow each other, and where it met another is on that.
    segments = traced.segments
    ends = segments.lift(field.mesh, segments.end)
    begins = segments.lift(field.mesh, segments.begin)
    for i in range(len(starts)):
        mine = np.flatnonzero(segments.line == i)
        np.testing.assert_allclose(ends[mine[:-1]], begins[mine[1:]], atol=1e-9)
        if traced.ended[i] == AT_LINE:
            other = np.flatnonzero(segments.line == traced.other[i])
            k = other[np.searchsorted(segments.along[other], traced.there[i], side="right") - 1]
            share = (traced.there[i] - segments.along[k]) / max(segments.reach[k], 1e-30)
            there = begins[k] + share * (ends[k] - begins[k])
            np.testing.assert_allclose(ends[mine[-1]], there, atol=1e-6)


def drafted(
    surface: Surface, source: PatternSource, **arguments: object
) -> tuple[Retopology, Report]:
    editor = Retopology(surface, source)
    outcome = do(editor, "draft", **arguments)
    assert outcome.changed and outcome.notes
    found = editor.fill()
    return editor, report_mesh(found, surface, editor.mesh(found))


@pytest.mark.parametrize(
    ("make", "handles", "symmetry"),
    [(sphere, 0, True), (box, 0, True), (bean, 0, True), (torus, 1, False)],
)
def test_a_draft_is_a_closed_mesh_of_quads_near_the_surface(
    make: Callable[[], Surface], handles: int, symmetry: bool, source: PatternSource
) -> None:
    surface = make()
    edge = 0.05 * surface.diagonal
    editor, made = drafted(surface, source, edge=edge, symmetry=symmetry)
    assert made.open_edges == made.tangled == made.unfilled == 0
    assert made.flipped <= 0.01 * made.quads
    assert made.euler == 2 - 2 * handles
    assert max(made.to_surface, made.from_surface) < 0.05
    check_network(editor.network, patches=False)
    sides = [half for patch in editor.network.patches.values() for half in patch.loop]
    assert len(sides) == len(set(sides))
    # Every side of every curve is a patch's, but those beyond the seam.
    marked = sum(mark != "" for chain in editor.network.chains.values() for mark in chain.marks)
    assert len(sides) + marked == 2 * len(editor.network.chains)
    assert (editor.state.plane is not None) == (symmetry and make is not bean)
    if not symmetry:
        assert count_genus(editor.network.nodes, editor.network.chains) == handles


def test_an_open_surface_gets_quads_up_to_its_border(source: PatternSource) -> None:
    editor, made = drafted(dish(), source, edge=0.15, symmetry=False)
    assert made.tangled == made.unfilled == made.flipped == 0
    assert made.euler == 1 and made.open_edges > 0
    assert any(BORDER in chain.marks for chain in editor.network.chains.values())


def test_the_same_surface_gives_the_same_draft_and_one_step_takes_it_back(
    source: PatternSource,
) -> None:
    one, _ = drafted(bean(), source, edge=0.3)
    two, _ = drafted(bean(), source, edge=0.3)
    assert are_equal(one.network, two.network)
    do(one, "undo")
    assert not one.network.chains


def test_a_finer_edge_makes_more_quads(source: PatternSource) -> None:
    coarse, fine = (drafted(sphere(), source, edge=edge)[1].quads for edge in (0.4, 0.2))
    assert 1.5 * coarse < fine < 6.0 * coarse


def test_what_no_field_lies_on_is_refused_with_its_place(source: PatternSource) -> None:
    def refused(surface: Surface, **arguments: object) -> str:
        editor = Retopology(surface, source)
        before = editor.state
        outcome = editor.do(Call("draft", arguments))
        assert outcome.refused is not None and editor.state is before
        return outcome.refused

    said = refused(sphere(), edge=3.0)
    assert "out of proportion" in said
    # An edge of the lengths that it names is not.
    low, high = re.findall(r"from (\S+) to (\S+)$", said)[0]
    surface = sphere()
    work = Retopology(surface, source)
    for edge in (float(low), float(high)):
        draft._read_goal(work, DraftRequest(edge=edge, sharp="none"))  # type: ignore[arg-type]


def touching_balls(pinch: int) -> Surface:
    """Two balls that touch in a vertex, and in as many vertices of the first it touches itself."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    first = np.array(ball.vertices)
    # A ball that is pressed in until two opposite vertices are one.
    if pinch:
        top, bottom = first[:, 2].argmax(), first[:, 2].argmin()
        first[:, 2] *= 1.0 - 0.8 * np.exp(-8.0 * (first[:, :2] ** 2).sum(axis=1))
        first[[top, bottom], 2] = 0.0
    both = np.concatenate([first, ball.vertices + np.array([2.0, 0.0, 0.0])])
    east, west = ball.vertices[:, 0].argmax(), ball.vertices[:, 0].argmin()
    both[len(first) + west] = both[east]
    return Surface.from_arrays(both, np.concatenate([ball.faces, ball.faces + len(first)])).orient()


@pytest.mark.parametrize("pinch", [0, 1])
def test_where_parts_touch_in_a_vertex_each_has_one_of_its_own(pinch: int) -> None:
    surface = touching_balls(pinch)
    parted = part_touching(surface)
    assert len(parted.touching) == 1 + pinch
    now = parted.surface
    assert len(now.vertices) == len(np.unique(surface.triangles)) + 1 + pinch
    # The same triangles, nowhere further off than a part of an edge.
    moved = np.linalg.norm(
        now.vertices[now.triangles] - surface.vertices[surface.triangles], axis=2
    )
    assert moved.max() < 0.02 * surface.diagonal and (moved > 0.0).any(axis=1).sum() < 40
    assert trimesh.Trimesh(now.vertices, now.triangles, process=False).euler_number == 4
    again = part_touching(now)
    assert again.surface is now and not len(again.touching)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_fans_are_told_apart_however_triangles_are_turned(seed: int) -> None:
    surface = touching_balls(1)
    random = np.random.default_rng(seed)
    order = random.permutation(len(surface.triangles))
    turns = random.integers(0, 3, len(order))
    triangles = surface.triangles[order]
    triangles = np.take_along_axis(triangles, (np.arange(3) + turns[:, None]) % 3, axis=1)

    def places(one: Surface) -> set[tuple[float, ...]]:
        return {tuple(at) for at in one.vertices[part_touching(one).touching].tolist()}

    assert places(Surface.from_arrays(surface.vertices, triangles).orient()) == places(surface)


def test_a_surface_that_touches_itself_is_drafted_and_it_is_told(source: PatternSource) -> None:
    editor = Retopology(touching_balls(0), source)
    outcome = do(editor, "draft", edge=0.4)
    assert any("touch in a vertex at (1, " in note for note in outcome.notes)
    found = editor.fill()
    made = report_mesh(found, editor.surface, editor.mesh(found))
    assert made.open_edges == 0 and made.flipped == 0 and made.euler == 4


def test_halves_that_are_unsound_where_parts_touch_give_way_to_the_whole(
    source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill = draft._fill_touching
    asked: list[bool] = []

    def refuse_halves(work: ToolWork, made: draft._MadeDraft) -> draft._MadeDraft:
        asked.append(made.state.plane is not None)
        if asked[-1]:
            raise RefusedError("no draft: there would be a flipped quad at (1, 0, 0)")
        return fill(work, made)

    monkeypatch.setattr(draft, "_fill_touching", refuse_halves)
    editor = Retopology(touching_balls(0), source)
    outcome = do(editor, "draft", edge=0.4)
    assert asked == [True, False] and editor.state.plane is None
    assert any("not by halves" in note and "(1, 0, 0)" in note for note in outcome.notes)
    found = editor.fill()
    made = report_mesh(found, editor.surface, editor.mesh(found))
    assert made.open_edges == 0 and made.flipped == 0 and made.euler == 4


def test_a_drafted_half_with_a_handle_becomes_a_whole(source: PatternSource) -> None:
    editor, _ = drafted(torus(), source, quads=150)
    assert editor.state.plane is not None
    patches = len(editor.network.patches)
    # The half is a bent tube without a handle, and the whole has one; do() checks the network.
    do(editor, "symmetry", on=False)
    assert editor.network.surface is editor.surface
    assert len(editor.network.patches) == 2 * patches


@pytest.mark.parametrize("symmetry", [True, False])
def test_a_surface_of_several_parts_is_drafted_whole(symmetry: bool, source: PatternSource) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    tube = trimesh.creation.torus(1.0, 0.4, major_sections=48, minor_sections=24)
    away = np.array([2.0, 0.3, 0.0]), np.array([0.0, 0.0, 3.0])
    parts = [ball.vertices, 0.5 * ball.vertices + away[0], tube.vertices + away[1]]
    starts = np.cumsum([0, len(ball.vertices), len(ball.vertices)])
    faces = [f + k for f, k in zip([ball.faces, ball.faces, tube.faces], starts, strict=True)]
    surface = Surface.from_arrays(np.concatenate(parts), np.concatenate(faces)).orient()
    _, made = drafted(surface, source, edge=0.35, symmetry=symmetry)
    assert made.open_edges == 0 and made.euler == 4 and made.flipped == 0
    assert max(made.to_surface, made.from_surface) < 0.02


def ring(radius: float, tube: float) -> Surface:
    mesh = trimesh.creation.torus(radius, tube, major_sections=96, minor_sections=24)
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


def find_handle(surface: Surface, edge: float) -> HandleLoop | None:
    return find_shortest_handle(
        TangentFrames.of(Surface.from_arrays(*remesh_evenly(surface, edge)).orient())
    )


@pytest.mark.parametrize(("radius", "tube"), [(1.0, 0.15), (1.0, 0.4), (1.0, 0.8)])
def test_the_shortest_handle_is_the_tube_or_the_hole(radius: float, tube: float) -> None:
    found = find_handle(ring(radius, tube), 0.08)
    assert found is not None
    # Around the tube, or through the hole, whichever is shorter; along edges it is a little longer.
    shortest = 2.0 * np.pi * min(tube, radius - tube)
    assert 0.97 * shortest < found.length < 1.2 * shortest
    away = np.hypot(*found.middle[:2])
    assert abs(away - (radius if tube < radius - tube else 0.0)) < 0.15


@pytest.mark.parametrize("make", [sphere, dish, bean])
def test_what_has_no_handle_has_no_shortest_one(make: Callable[[], Surface]) -> None:
    assert find_handle(make(), 0.15) is None


def test_the_shortest_of_several_handles_in_several_parts_is_found() -> None:
    parts = [ring(1.0, 0.4), ring(1.0, 0.2), sphere()]
    vertices = [part.vertices + 4.0 * k for k, part in enumerate(parts)]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    found = find_handle(
        Surface.from_arrays(np.concatenate(vertices), np.concatenate(faces)).orient(), 0.1
    )
    assert found is not None
    assert found.length == pytest.approx(2.0 * np.pi * 0.2, rel=0.2)
    assert abs(np.hypot(*(found.middle[:2] - 4.0)) - 1.0) < 0.15


def test_laces_are_refused_with_their_place_before_anything_is_filled(
    source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("it was filled")

    monkeypatch.setattr(proposing, "fill_network", fail)
    lace = ring(1.0, 0.04)
    wish = {"edge": 0.15, "symmetry": False, "strict": True}
    outcome = Retopology(lace, source).do(Call("draft", wish))
    assert outcome.refused is not None
    wanted = r"a handle .* is ([\d.]+) around at \((.*?)\), .*an edge of ([\d.]+)"
    found = re.search(wanted, outcome.refused)
    assert found is not None, outcome.refused
    assert float(found[1]) == pytest.approx(2.0 * np.pi * 0.04, rel=0.2)
    x, y, z = (float(part) for part in found[2].split(","))
    assert np.hypot(x, y) == pytest.approx(1.0, abs=0.05) and abs(z) < 0.05
    # With the edge that it names it is not refused so any more.
    with pytest.raises(AssertionError, match="it was filled"):
        Retopology(lace, source).do(Call("draft", {"edge": float(found[3]), "symmetry": False}))


def boxes_at_an_edge(apart: bool) -> Surface:
    """Two boxes that have an edge in common, of four triangles; or one with a fin, of three."""
    one = trimesh.creation.box().subdivide().subdivide()
    vertices, faces = np.array(one.vertices), np.array(one.faces)
    if not apart:
        rim = np.flatnonzero((vertices[:, 0] > 0.49) & (vertices[:, 1] > 0.49))
        a, b = rim[np.argsort(vertices[rim, 2])][1:3]
        vertices = np.concatenate([vertices, [[0.8, 0.8, 0.0]]])
        return Surface.from_arrays(
            vertices, np.concatenate([faces, [[a, b, len(vertices) - 1]]])
        ).orient()
    other = vertices + np.array([1.0, 1.0, 0.0])
    both = np.concatenate([vertices, other])
    name = np.arange(len(both))
    for k in range(len(vertices)):
        same = np.flatnonzero(np.linalg.norm(vertices - other[k], axis=1) < 1e-9)
        if len(same):
            name[len(vertices) + k] = same[0]
    return Surface.from_arrays(both, name[np.concatenate([faces, faces + len(vertices)])]).orient()


@pytest.mark.parametrize("apart", [True, False])
def test_sheets_that_share_an_edge_are_parted_there(apart: bool) -> None:
    surface = boxes_at_an_edge(apart)
    assert (np.diff(surface.adjacency.side_start) > 2).any()
    parted = part_touching(surface)
    now = parted.surface
    assert (np.diff(now.adjacency.side_start) <= 2).all() and len(parted.touching)
    check_surface(now)
    # Nothing is lost, and all is near to what was there. The fin has its divided side free.
    assert now.areas.sum() == pytest.approx(surface.areas.sum(), rel=0.05)
    off = np.linalg.norm(surface.nearest(now.vertices).points - now.vertices, axis=1)
    assert off.max() < 0.01 * surface.diagonal
    assert len(now.adjacency.border) == (0 if apart else 4)


def test_boxes_that_share_an_edge_are_drafted_closed(source: PatternSource) -> None:
    editor = Retopology(boxes_at_an_edge(apart=True), source)
    outcome = do(editor, "draft", edge=0.25)
    assert any("touch in" in note for note in outcome.notes)
    found = editor.fill()
    made = report_mesh(found, editor.surface, editor.mesh(found))
    assert made.open_edges == 0 and made.flipped == 0 and made.quads > 100


def test_a_vertex_where_fewer_than_two_lines_end_is_refused_with_its_place() -> None:
    surface = sphere()
    sizes = Sizes.of(surface.diagonal)
    field = FieldSolver(TangentFrames.of(surface), 0.0).solve(0.0)
    index = field.index.copy()
    one, two = field.singular[:2].tolist()
    index[[one, two]] = 3, -1
    empty = Network(longest=2.0 * surface.diagonal, surface=surface)
    needle = CrossField(field.mesh, field.angle, field.quarters, index)
    with pytest.raises(RefusedError, match="fewer than two lines") as refused:
        layout.lay_out(empty, surface, sizes, SETTINGS.fields[0], needle)
    assert format_place(field.mesh.vertices[one]) in str(refused.value)


#: Drafts of the ball by their edges, which the cases of a test have in common.
PROPOSED: dict[float, Draft] = {}


@pytest.mark.parametrize("first", ["flipped", "refused"])
@pytest.mark.parametrize(("mended", "strict"), [(True, True), (False, True), (False, False)])
def test_where_an_edge_will_not_do_others_are_taken_or_the_place_is_named(
    first: str,
    mended: bool,
    strict: bool,
    source: PatternSource,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried: list[float] = []
    propose = proposing.propose_draft

    def spoil(task: DraftTask, *more: Any) -> Draft:
        if task.sizes.edge not in PROPOSED:
            PROPOSED[task.sizes.edge] = propose(task, *more)
        made = PROPOSED[task.sizes.edge]
        tried.append(task.sizes.edge)
        if mended and len(tried) == 3:
            return made
        if first == "refused" and len(tried) == 1:
            raise RefusedError("no draft: not at (4, 5, 6)")
        rank = (*made.rank[:2], 2.0, *made.rank[3:])
        return replace(made, flaws=("a flipped quad at (1, 2, 3)",), rank=rank)

    monkeypatch.setattr(proposing, "propose_draft", spoil)
    editor = Retopology(sphere(), source)
    outcome = editor.do(Call("draft", {"edge": 0.3, "symmetry": False, "strict": strict}))
    np.testing.assert_allclose(tried, [0.3, 0.225, 0.39])
    if mended:
        assert outcome.changed and editor.sizes.edge == 0.3
        assert any(
            "1.3 times" in note and "a flipped quad at (1, 2, 3)" in note for note in outcome.notes
        )
    elif not strict:
        assert outcome.changed and "a flipped quad at (1, 2, 3)" in outcome.notes
    else:
        assert outcome.refused is not None and not editor.network.chains
        assert "a flipped quad at (1, 2, 3), by all that was tried" in outcome.refused


def count_tries(monkeypatch: pytest.MonkeyPatch, spoilt: int) -> list[int]:
    """Have the first drafts of settings be off by a flipped quad; returns the quads of all."""
    tried: list[int] = []
    of = Draft.of

    def spoil(found: FilledNetwork, judge: DraftJudge, notes: tuple[str, ...] = ()) -> Draft:
        made = of(found, judge, notes)
        tried.append(made.report.quads)
        if len(tried) > spoilt:
            return made
        rank = (*made.rank[:2], 2.0, *made.rank[3:])
        return replace(made, flaws=("a flipped quad at (1, 2, 3)",), rank=rank)

    monkeypatch.setattr(Draft, "of", spoil)
    return tried


@pytest.mark.parametrize("most", [0.0, 1e9])
def test_when_many_quads_were_made_in_vain_nothing_else_is_tried(
    most: float, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = count_tries(monkeypatch, 1000)
    surface = bean()
    network = Network(longest=2.0 * surface.diagonal, surface=surface)
    sizes = replace(Sizes.of(surface.diagonal), edge=0.08 * surface.diagonal)
    task = DraftTask(network, surface, sizes, source, budget=DraftBudget(most))
    made = parts.propose_by_parts(task, SETTINGS.edges)
    assert not made.sound
    # Of one edge there are settings whose fields differ, and there are three edges.
    assert (len(tried) == 1) == (most == 0.0)
    assert most == 0.0 or len(tried) > len(SETTINGS.edges)


def test_an_unsound_part_ends_the_draft_of_all(
    source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    away = np.array([5.0, 0.0, 0.0])
    points = np.concatenate([ball.vertices + k * away for k in range(3)])
    faces = np.concatenate([ball.faces + k * len(ball.vertices) for k in range(3)])
    surface = Surface.from_arrays(points, faces).orient()
    parts: list[int] = []
    propose = proposing.propose_draft

    def spoil(task: DraftTask, *more: Any) -> Draft:
        made = propose(task, *more)
        parts.append(len(task.surface.triangles))
        rank = (*made.rank[:2], 2.0, *made.rank[3:])
        return replace(made, flaws=("a flipped quad at (1, 2, 3)",), rank=rank)

    monkeypatch.setattr(proposing, "propose_draft", spoil)
    editor = Retopology(surface, source)
    outcome = editor.do(Call("draft", {"edge": 0.6, "symmetry": False, "strict": True}))
    assert outcome.refused is not None and "a flipped quad at (1, 2, 3)" in outcome.refused
    # The first part, by its three edges; the others never.
    assert len(parts) == len(SETTINGS.edges)


def test_patches_hold_the_places_that_they_had_on_another_surface(source: PatternSource) -> None:
    editor, _ = drafted(sphere(), source, edge=0.5, symmetry=False)
    found = editor.fill()
    moved = {
        patch: replace(one, vertices=one.vertices + 1e-3 * one.normals)
        for patch, one in sorted(found.placed.items())[::2]
    }
    held = parts.fill_as_placed(found.network, editor.surface, source, 0.5, found.placed | moved)
    for patch, one in held.placed.items():
        wanted = moved.get(patch, found.placed[patch]).vertices
        np.testing.assert_array_equal(one.vertices, wanted)
    same = parts.fill_as_placed(found.network, editor.surface, source, 0.5, found.placed)
    assert same.network is found.network


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=60))
def test_a_spanning_tree_takes_each_pair_that_joins_what_those_before_it_do_not(
    pairs: list[tuple[int, int]],
) -> None:
    group = {k: {k} for k in range(10)}
    wanted: list[bool] = []
    for a, b in pairs:
        wanted.append(group[a] is not group[b])
        if wanted[-1]:
            whole = group[a] | group[b]
            group |= dict.fromkeys(whole, whole)
    assert manifold._span_tree(np.array(pairs, np.int32)).tolist() == wanted


def test_halves_of_parts_whose_seams_have_corners_are_drafted_part_by_part(
    source: PatternSource,
) -> None:
    # The seam around a box has four corners, and is a patch of its own where one draws by hand.
    box = trimesh.creation.box().subdivide().subdivide().subdivide()
    points = np.concatenate([box.vertices, box.vertices + np.array([0.0, 3.0, 0.0])])
    surface = Surface.from_arrays(
        points, np.concatenate([box.faces, box.faces + len(box.vertices)])
    ).orient()
    editor, made = drafted(surface, source, edge=0.25, symmetry=True)
    assert editor.state.plane is not None
    assert made.open_edges == made.flipped == 0 and made.euler == 4
    assert max(made.to_surface, made.from_surface) < 0.02
    chains = editor.network.chains
    for patch in editor.network.patches.values():
        assert not all(SYMMETRY in chains[half >> 1].marks for half in patch.loop)


def eyes() -> Surface:
    """A ball; smaller than an edge an eye before it and a ring around that, and on the ball's skin
    a sheet, which lies on it everywhere."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    eye = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    eye.apply_translation([1.0, 0.0, 0.0])
    ring = trimesh.creation.annulus(0.05, 0.07, 0.005)
    ring.apply_translation([0.0, 0.0, 1.1])
    high = np.array(ball.vertices)[:, 2] > 0.6
    sheet = ball.faces[high[ball.faces].all(axis=1)]
    parts = [ball.vertices, eye.vertices, ring.vertices, 1.0005 * np.array(ball.vertices)]
    starts = np.cumsum([0, *(len(part) for part in parts)])
    faces = [ball.faces, eye.faces, ring.faces, sheet]
    return Surface.from_arrays(
        np.concatenate(parts), np.concatenate([f + k for f, k in zip(faces, starts, strict=False)])
    ).orient()


@pytest.mark.parametrize("symmetry", [True, False])
def test_parts_smaller_than_an_edge_and_on_others_are_drafted(
    symmetry: bool, source: PatternSource
) -> None:
    editor, made = drafted(eyes(), source, edge=0.25, symmetry=symmetry)
    assert made.unfilled == made.tangled == made.flipped == 0
    # Two balls, a ring with a hole and a disk.
    assert made.euler == 2 + 2 + 0 + 1 and made.open_edges > 0
    assert max(made.to_surface, made.from_surface) < 0.02
    check_network(editor.network, patches=False)


def test_chains_of_borders_are_shared_out_by_their_sides() -> None:
    # Two squares that lie on each other, turned against each other, and one beside them.
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    points = np.concatenate(
        [square, square + np.array([0, 0, 1e-6]), square + np.array([1.0, 1e-6, 0])]
    )
    faces = np.array([[0, 1, 2], [0, 2, 3], [6, 5, 4], [7, 6, 4], [8, 9, 10], [8, 10, 11]])
    surface = Surface.from_arrays(points, faces).orient()
    squares = SurfaceParts.of(surface)
    assert squares.parts == 3
    network = add_borders(Network(longest=9.0), surface, 0.05)
    shared = parts.share_chains(network, surface, squares, 0.05)
    assert sorted(shared.values()) == [0, 1, 2]
    for number, part in shared.items():
        middle = network.chains[number].points.mean(axis=0)
        own = surface.vertices[surface.triangles[squares.part == part]].reshape(-1, 3).mean(axis=0)
        np.testing.assert_allclose(middle, own, atol=0.3)
        up = surface.normals[surface.triangles[squares.part == part][0, 0]]
        assert network.chains[number].normals[0] @ up > 0.9


def test_a_tetrahedron_is_not_collapsed_and_what_is_left_over_is_no_seed() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    points, triangles = remesh_evenly(Surface.from_arrays(corners, faces).orient(), 5.0)
    assert len(points) == 4 and len(triangles) == 4
    ball = trimesh.creation.icosphere(subdivisions=2)
    spare = TangentFrames.of(
        Surface.from_arrays(np.r_[ball.vertices, [[5.0, 5.0, 5.0]]], ball.faces).orient()
    )
    assert spare.list_ring(len(spare.vertices) - 1) == []


def test_what_lies_in_the_plane_of_symmetry_is_not_lost(source: PatternSource) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    # A fin above it, in the plane, which no half has.
    fin = np.array([[0.0, -0.4, 1.2], [0.0, 0.4, 1.2], [0.0, 0.4, 1.8], [0.0, -0.4, 1.8]])
    n = len(ball.vertices)
    faces = np.concatenate([ball.faces, [[n, n + 1, n + 2], [n, n + 2, n + 3]]])
    editor = Retopology(
        Surface.from_arrays(np.concatenate([ball.vertices, fin]), faces).orient(), source
    )
    notes = do(editor, "draft", edge=0.3).notes
    assert any("2 triangles lie in the plane, one at (0, " in note for note in notes), notes
    found = editor.fill()
    made = report_mesh(found, editor.surface, editor.mesh(found))
    assert made.euler == 3 and made.open_edges > 0 and made.from_surface < 0.02


def test_a_tube_that_is_open_at_both_ends_is_drafted(source: PatternSource) -> None:
    turn, height = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False), np.linspace(0.0, 3.0, 20), indexing="ij"
    )
    points = np.stack([np.cos(turn), np.sin(turn), height], axis=-1).reshape(-1, 3)
    k = np.arange(40)[:, None] * 20 + np.arange(19)
    a, b = k.ravel(), ((k + 20) % 800).ravel()
    faces = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)])
    _, made = drafted(Surface.from_arrays(points, faces).orient(), source, edge=0.4, symmetry=False)
    assert made.unfilled == made.flipped == made.tangled == 0
    assert made.euler == 0 and max(made.to_surface, made.from_surface) < 0.02


@pytest.mark.skipif(sys.platform == "win32", reason="signal(2) of the C library")
def test_choosing_counts_leaves_ctrl_c_to_python(
    source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    # OR-Tools puts the system's default in the place of whatever handled it.
    library = ctypes.CDLL(None)
    library.signal.restype, library.signal.argtypes = (
        ctypes.c_void_p,
        (ctypes.c_int, ctypes.c_void_p),
    )

    def find_handler() -> int | None:
        now = library.signal(signal.SIGINT, None)
        library.signal(signal.SIGINT, now)
        return now

    solved: list[int] = []
    solve = choosing.solve_neighbourhood

    def count(*given: Any) -> Any:
        solved.append(1)
        return solve(*given)

    monkeypatch.setattr(choosing, "solve_neighbourhood", count)
    before = find_handler()
    drafted(bean(), source, edge=0.3)
    assert solved and find_handler() == before
