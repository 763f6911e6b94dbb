"""Sharp edges: which are found, as chains of a network, and what drafts make of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import scaled_jacobian
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft import proposing
from patterndb_sketch.retopo.draft.creases import (
    AUTOMATIC,
    SharpRule,
    add_creases,
    count_degrees,
    drop_open_chains,
    find_border,
    find_sharp_edges,
    list_chains,
)
from patterndb_sketch.retopo.draft.fitting import match_squares
from patterndb_sketch.retopo.draft.fixedcurves import FixedCurve
from patterndb_sketch.retopo.draft.joints import Constraints, InWedge
from patterndb_sketch.retopo.draft.judging import WRONG, Draft, DraftJudge
from patterndb_sketch.retopo.draft.proposing import propose_draft
from patterndb_sketch.retopo.draft.task import DraftGoal, DraftTask
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.filling import weld_patches
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.network import Network, add_borders, check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools import draft
from patterndb_sketch.retopo.wording import round_down, round_up
from query.engine import PatternSource


def box(subdivisions: int = 3, turn: int = 0, scale: float = 1.0) -> Surface:
    mesh = trimesh.creation.box((2.0, 3.0, 4.0))
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    turned = trimesh.transformations.random_rotation_matrix(np.random.default_rng(turn).random(3))
    points = scale * trimesh.transform_points(mesh.vertices, turned if turn else np.eye(4))
    return Surface.from_arrays(points, mesh.faces).orient()


def length_of(surface: Surface, edges: frozenset[tuple[int, int]]) -> float:
    ends = surface.vertices[np.array(sorted(edges)).reshape(-1, 2)]
    return float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum())


@settings(max_examples=20)
@given(st.integers(0, 50), st.sampled_from([1e-3, 1.0, 1e6]), st.integers(1, 2))
def test_the_sharp_edges_of_a_box_are_its_twelve(turn: int, scale: float, fine: int) -> None:
    surface = box(fine, turn, scale)
    edges = find_sharp_edges(surface, 0.3 * scale)
    assert length_of(surface, edges) == pytest.approx(36.0 * scale)
    corners = [v for v, n in count_degrees(edges).items() if n == 3]
    assert len(corners) == 8 and drop_open_chains(edges) == edges


def test_smooth_and_rough_surfaces_have_none_and_an_angle_takes_them_all() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    assert not find_sharp_edges(Surface.from_arrays(ball.vertices, ball.faces).orient(), 0.1)
    noise = 1.0 + 0.03 * np.random.default_rng(1).standard_normal((len(ball.vertices), 1))
    rough = Surface.from_arrays(noise * ball.vertices, ball.faces).orient()
    few, every = (find_sharp_edges(rough, 0.1, rule) for rule in (AUTOMATIC, SharpRule.above(40)))
    assert length_of(rough, few) < 0.05 * length_of(rough, every)


@pytest.mark.parametrize("gap", [0.02, 0.1, 0.5])
def test_narrow_steps_of_a_machined_body_are_no_roughness(gap: float) -> None:
    """Its long edges meet short sharp ones at their ends."""
    outline = [(0, 0), (4, 0), (4, 2), (2 + gap, 2), (2 + gap, 2 - gap), (2, 2 - gap), (2, 2)]
    outline += [(1, 2), (1, 2 + gap), (0, 2 + gap)]
    n = len(outline)
    points = np.array([(x, y, z) for z in (0.0, 3.0) for x, y in outline])
    walls = [(a, (a + 1) % n, (a + 1) % n + n, a + n) for a in range(n)]
    sides = [t for a, b, c, d in walls for t in ((a, b, c), (a, c, d))]
    caps = [(0, 1, 5), (1, 2, 3), (1, 3, 4), (1, 4, 5), (0, 5, 6), (0, 6, 7), (0, 7, 8), (0, 8, 9)]
    top = [(a + n, b + n, c + n) for a, b, c in caps]
    body = Surface.from_arrays(points, np.array([*sides, *(t[::-1] for t in caps), *top])).orient()
    around = float(np.linalg.norm(np.diff([*outline, outline[0]], axis=0), axis=1).sum())
    assert length_of(body, find_sharp_edges(body, 0.2)) == pytest.approx(2.0 * around + 3.0 * n)


def test_edges_with_the_same_ends_are_all_looked_at() -> None:
    # Two tetrahedra that share an edge.
    points = np.array([(0, 0, 0), (0, 0, 1), (1, 0, 0.5), (0.4, 0.8, 0.5), (-1, 0, 0.5)], float)
    points = np.concatenate([points, [(-0.4, -0.8, 0.5)]])
    one = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    two = [(0, 4, 1), (0, 1, 5), (0, 5, 4), (1, 4, 5)]
    edges = find_sharp_edges(Surface.from_arrays(points, np.array([*one, *two])).orient(), 0.1)
    assert len(edges) >= 10


def test_a_crease_continues_where_it_fades() -> None:
    # A wedge whose dihedral falls from 90 degrees to nothing along its ridge.
    x, s = np.meshgrid(np.linspace(0.0, 10.0, 41), np.linspace(-1.0, 1.0, 9), indexing="ij")
    z = -np.abs(s) * np.tan(np.radians(45.0 * np.clip(1.2 - 0.12 * x, 0.0, 1.0)))
    points = np.stack([x, s, z], axis=2).reshape(-1, 3)
    a = np.arange(len(points)).reshape(x.shape)
    quads = np.stack([a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]], axis=2).reshape(-1, 4)
    surface = Surface.from_arrays(
        points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    ).orient()
    edges = find_sharp_edges(surface, 0.3)
    on_ridge = np.flatnonzero(surface.vertices[:, 1] == 0.0)
    assert set(count_degrees(edges)) <= set(on_ridge.tolist())
    ends = surface.vertices[list(count_degrees(edges)), 0]
    assert ends.min() == 0.0 and 5.0 < ends.max() < 10.0


def test_a_crease_from_border_to_border_is_not_open() -> None:
    # A roof with a ridge of 2 units.
    x, s = np.meshgrid(np.linspace(0.0, 2.0, 21), np.linspace(-1.0, 1.0, 9), indexing="ij")
    a = np.arange(x.size).reshape(x.shape)
    quads = np.stack([a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]], axis=2).reshape(-1, 4)
    points = np.stack([x, s, -np.abs(s)], axis=2).reshape(-1, 3)
    roof = Surface.from_arrays(
        points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    ).orient()
    edges = find_sharp_edges(roof, 0.6)
    assert length_of(roof, edges) == pytest.approx(2.0)
    assert drop_open_chains(edges, find_border(roof)) == edges and not drop_open_chains(edges)
    # Shorter than one and a half edges of the quads it is noise.
    assert not find_sharp_edges(roof, 1.5)


@given(
    st.sets(st.tuples(st.integers(0, 9), st.integers(0, 9)).filter(lambda e: e[0] < e[1])),
    st.sets(st.integers(0, 9)),
)
def test_chains_pass_every_edge_once_and_end_where_they_must(
    edges: set[tuple[int, int]], stops: set[int]
) -> None:
    chains = list_chains(edges, stops)
    passed = [tuple(sorted(pair)) for chain in chains for pair in pairwise(chain)]
    assert sorted(passed) == sorted(edges)
    degree = count_degrees(edges)
    for chain in chains:
        assert all(degree[v] == 2 and v not in stops for v in chain[1:-1])
        ends = degree[chain[0]] != 2 or chain[0] in stops
        assert ends or chain[0] == chain[-1]


def test_creases_are_chains_of_a_sound_network_exactly_on_the_edges() -> None:
    mesh = trimesh.creation.cylinder(1.0, 3.0, sections=24).subdivide().subdivide()
    solid = Surface.from_arrays(mesh.vertices, mesh.faces).orient()
    above = mesh.triangles_center[:, 2] > -1.49
    cup = Surface.from_arrays(mesh.vertices, mesh.faces[above]).orient()
    for surface, chains in ((solid, 2), (cup, 1), (box(), 12)):
        sizes = Sizes.of(surface.diagonal)
        empty = Network(longest=2.0 * surface.diagonal, surface=surface)
        network = add_borders(empty, surface, sizes.sampling)
        made = add_creases(network, surface, sizes, AUTOMATIC)
        assert made is not None
        check_network(made.network, patches=False)
        own = [c for c in made.network.chains.values() if not c.marked]
        assert len(own) == chains
        for chain in own:
            assert np.abs(surface.nearest(chain.points).points - chain.points).max() < 1e-9
        vertices = {v for pair in made.half for v in pair}
        there = np.concatenate([chain.points for chain in own])
        for v in vertices:
            assert np.linalg.norm(there - surface.vertices[v], axis=1).min() == 0.0


def test_a_place_next_to_a_node_is_on_the_curve_that_runs_there() -> None:
    surface = box(2)
    sizes = Sizes.of(surface.diagonal)
    empty = Network(longest=2.0 * surface.diagonal, surface=surface)
    made = add_creases(empty, surface, sizes, AUTOMATIC)
    assert made is not None
    network = made.network
    walls = Constraints(network, 0.35 * sizes.edge)
    for half in (2 * chain + side for chain in network.chains for side in (0, 1)):
        line, _ = network.chains[half >> 1].directed(half)
        node = network.nodes[network.origin(half)]
        ahead = line[1] - line[0]
        # Nearer to the node, which is a sample of three curves, than to all other samples.
        point = line[0] + 0.2 * ahead
        forth = walls.find_place(point, ahead, point)
        assert isinstance(forth, InWedge) and (forth.node, forth.half) == (node.id, half)
        back = walls.find_place(point, -ahead, point)
        assert isinstance(back, InWedge) and back.node == node.id
        assert back.half == node.ends[node.wedge_before(half)] and back.order > forth.order


@given(st.integers(0, 1000), st.booleans())
def test_vertices_never_pass_each_other_on_a_fixed_curve(seed: int, closed: bool) -> None:
    rng = np.random.default_rng(seed)
    angle = np.linspace(0.0, 2.0 * np.pi if closed else 2.0, 60)
    line = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    place = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    along = np.r_[0.0, np.sort(rng.random(6)) * place[-1], place[-1]]
    names = np.r_[np.arange(7), 0 if closed else 7]
    curve = FixedCurve(names, along, line, np.tile([0.0, 0.0, 1.0], (60, 1)), place, closed, [])
    for _ in range(20):
        wanted = curve.propose(rng.standard_normal((8, 3)))
        assert (np.diff(wanted) > 0.0).all()
        if not closed:
            assert wanted[0] == 0.0 and wanted[-1] == place[-1]
        at = np.zeros((8, 3))
        at[curve.vertices] = curve.locate(wanted)[0]
        curve.settle(wanted, at)
        np.testing.assert_allclose(curve.along, wanted)


def grid(n: int) -> tuple[Points, np.ndarray]:
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    a = np.arange((n + 1) ** 2, dtype=np.int32).reshape(n + 1, n + 1)
    quads = np.stack([a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]], axis=2).reshape(-1, 4)
    return np.stack([x, y, 0.0 * x], axis=2).reshape(-1, 3), quads


@given(st.integers(0, 100), st.floats(1e-3, 1e3))
def test_shape_matching_keeps_squares_and_makes_others_squarer(seed: int, scale: float) -> None:
    points, quads = grid(4)
    turned = trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3))
    at = scale * trimesh.transform_points(points, turned)
    np.testing.assert_allclose(match_squares(at, quads, scale), at, atol=1e-9 * scale)
    noise = np.random.default_rng(seed).uniform(-0.25, 0.25, at.shape) * scale
    off = at + noise
    spread = [np.std(np.linalg.norm(p[quads] - np.roll(p[quads], -1, axis=1), axis=2)) for p in
              (off, match_squares(off, quads, scale))]  # fmt: skip
    assert spread[1] < spread[0]


@given(st.integers(0, 1000))
def test_scaled_jacobians_are_those_of_the_plain_definition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((8, 3))
    quads = np.array([rng.permutation(8)[:4] for _ in range(5)], np.int32)
    for quad, found in zip(quads, scaled_jacobian(quads, points), strict=True):
        p = points[quad]
        normal = np.cross(p[2] - p[0], p[3] - p[1])
        normal /= np.linalg.norm(normal)
        corners = []
        for k in range(4):
            a, b = p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]
            corners.append(np.cross(a, b) @ normal / np.linalg.norm(a) / np.linalg.norm(b))
        assert found == pytest.approx(min(corners))
    square = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], float)
    assert scaled_jacobian(np.array([[0, 1, 2, 3]]), square) == pytest.approx([1.0])


@pytest.mark.parametrize("symmetry", [False, True])
def test_a_box_keeps_its_edges_and_has_as_many_quads_as_asked(
    symmetry: bool, source: PatternSource
) -> None:
    surface = box()
    editor = Retopology(surface, source)
    outcome = editor.do(Call("draft", {"quads": 300, "symmetry": symmetry}))
    assert outcome.changed, outcome.refused
    assert (editor.state.plane is not None) == symmetry
    mesh = editor.mesh(editor.fill())
    assert 270 <= len(mesh.quads) <= 330
    tail, head = mesh.list_sides()
    at = mesh.vertices
    # Every point of an edge of the box is on an edge of a quad.
    share = np.linspace(0.0, 1.0, 9)[:, None]
    along = np.concatenate([(1 - s) * at[tail] + s * at[head] for s in share])
    for a, b in find_sharp_edges(surface, 0.3):
        middle = 0.5 * (surface.vertices[a] + surface.vertices[b])
        assert np.linalg.norm(along - middle, axis=1).min() < 0.08
    corners = [v for v, n in count_degrees(find_sharp_edges(surface, 0.3)).items() if n == 3]
    for v in corners:
        assert np.linalg.norm(at - surface.vertices[v], axis=1).min() < 1e-9
    assert scaled_jacobian(mesh.quads, at).min() > 0.9
    if symmetry:
        return
    # Without them, corners are rounded off.
    rounded = Retopology(surface, source)
    rounded.do(Call("draft", {"quads": 300, "symmetry": False, "sharp": "none"}))
    there = weld_patches(rounded.fill()).vertices
    off = [np.linalg.norm(there - surface.vertices[v], axis=1).min() for v in corners]
    assert max(off) > 1e-3


@pytest.mark.parametrize("refused", ["creases", "all"])
@pytest.mark.parametrize("strict", [True, False])
def test_what_of_a_part_cannot_be_drafted_costs_the_other_parts_nothing(
    refused: str, strict: bool, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = box()
    points = np.concatenate([one.vertices, one.vertices + np.array([9.0, 0.0, 0.0])])
    triangles = np.concatenate([one.triangles, one.triangles + len(one.vertices)])
    propose = proposing.propose_draft

    def refuse_first(task: DraftTask, *more: Any) -> Draft:
        first = task.surface.vertices[task.surface.triangles].mean() < 2.0
        if first and (refused == "all" or task.goal.sharp is not None):
            raise RefusedError("no draft: not at (1, 2, 3)")
        return propose(task, *more)

    monkeypatch.setattr(proposing, "propose_draft", refuse_first)
    editor = Retopology(Surface.from_arrays(points, triangles).orient(), source)
    outcome = editor.do(Call("draft", {"quads": 400, "symmetry": False, "strict": strict}))
    if refused == "all" and strict:
        assert outcome.refused == "no draft: not at (1, 2, 3)" and not editor.network.chains
        return
    wanted = "is left open" if refused == "all" else "sharp edges are not all kept"
    assert any(wanted in note and "not at (1, 2, 3)" in note for note in outcome.notes)
    at = editor.mesh(editor.fill()).vertices
    away = [
        [np.linalg.norm(at - corner, axis=1).min() for corner in surface_corners(one, x)]
        for x in (0.0, 9.0)
    ]
    assert max(away[1]) < 1e-9 < 1e-3 < max(away[0])
    assert (max(away[0]) < 1.0) == (refused == "creases")


def surface_corners(surface: Surface, x: float) -> Points:
    """(8, 3) the corners of a box, moved along x."""
    degrees = count_degrees(find_sharp_edges(surface, 0.3))
    return surface.vertices[[v for v, n in degrees.items() if n == 3]] + np.array([x, 0.0, 0.0])


@pytest.mark.parametrize("strict", [True, False])
@pytest.mark.parametrize("off", [0.01, 0.1])
def test_creases_are_worth_a_few_flaws_unless_all_is_to_be_sound(
    off: float, strict: bool, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    surface = box()
    propose = proposing.propose_draft

    def spoil(task: DraftTask, *more: Any) -> Draft:
        made = propose(task, *more)
        if task.goal.sharp is None:
            return made
        return replace(made, rank=(0, 0, 1, off, *made.rank[WRONG:]), flaws=("a flaw",))

    monkeypatch.setattr(proposing, "propose_draft", spoil)
    editor = Retopology(surface, source)
    outcome = editor.do(Call("draft", {"quads": 200, "symmetry": False, "strict": strict}))
    assert outcome.changed
    at = editor.mesh(editor.fill()).vertices
    away = [np.linalg.norm(at - corner, axis=1).min() for corner in surface_corners(surface, 0.0)]
    kept = off < 0.05 and not strict
    assert (max(away) < 1e-9) == kept and ("a flaw" in outcome.notes) == kept
    assert any("not all kept" in note for note in outcome.notes) != kept


@pytest.mark.parametrize("poor", ["half", "both", "none"])
def test_the_whole_is_drafted_where_a_half_has_poor_quads_and_is_taken_if_it_is_better(
    poor: str, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    propose = draft.propose_by_parts
    halves: list[bool] = []

    def spoil(task: DraftTask, *more: Any, **named: Any) -> Draft:
        one = propose(task, *more, **named)
        halves.append(task.half is not None)
        if poor == "none" or (poor == "half" and task.half is None):
            return one
        n = 50 if task.half is not None else 90
        return replace(one, poor=np.full((n, 3), 7.0))

    monkeypatch.setattr(draft, "propose_by_parts", spoil)
    editor = Retopology(box(), source)
    outcome = editor.do(Call("draft", {"quads": 200}))
    assert outcome.changed and halves == ([True] if poor == "none" else [True, False])
    assert (editor.state.plane is None) == (poor == "half")
    if poor == "half":
        said = (
            "not by halves, though the surface is symmetric: there would be 50 poor quads at (7, "
        )
        assert any(note.startswith(said) for note in outcome.notes)


def test_single_quads_between_corners_are_held_where_they_are(source: PatternSource) -> None:
    """Else they may be lost when the network is filled again: around handles, on thin parts."""
    surface = box()
    sizes = replace(Sizes.of(surface.diagonal), edge=1.0)
    goal = DraftGoal(quad=3.0, sharp=AUTOMATIC)
    found = propose_draft(
        DraftTask(Network(surface=surface), surface, sizes, source, goal=goal)
    ).found
    single = [p for p, placed in found.placed.items() if len(placed.quads) == 1]
    assert len(single) == 6
    for patch in single:
        which, at = filling_of(found.network.patches[patch]).moved_vertices
        assert which.tolist() == [0, 1, 2, 3]
        assert np.array_equal(at, found.placed[patch].vertices)


def test_what_is_open_or_tangled_is_a_flaw_with_its_place(source: PatternSource) -> None:
    surface = box()
    editor = Retopology(surface, source)
    editor.do(Call("draft", {"quads": 200, "symmetry": False}))
    found = editor.fill()
    judge = DraftJudge(surface, None)
    assert judge.list_flaws(found, judge.report(found)) == ()
    placed = dict(found.placed)
    gone = placed.pop(min(placed))
    holed = replace(found, placed=placed)
    (flaw,) = judge.list_flaws(holed, judge.report(holed))[:1]
    assert flaw.startswith("no quads in a patch at (")
    place = np.array([float(word) for word in flaw[flaw.index("(") + 1 : -1].split(", ")])
    assert np.linalg.norm(gone.vertices - place, axis=1).min() < 2.0
    made = Draft.of(holed, judge)
    assert not made.sound and Draft.of(found, judge).sound


@given(st.floats(1e-12, 1e12), st.integers(1, 6))
def test_limits_that_are_named_are_within_what_they_limit(number: float, digits: int) -> None:
    below, above = round_down(number, digits), round_up(number, digits)
    assert below <= number <= above
    assert above - below <= 1.01 * 10.0 ** (np.floor(np.log10(number)) + 1 - digits)
    assert float(f"{below:.{digits}g}") == below and float(f"{above:.{digits}g}") == above


@pytest.mark.parametrize("sharp", ["blunt", 0.0, 180.0, True, [1]])
def test_what_is_no_angle_is_refused(sharp: object, source: PatternSource) -> None:
    with pytest.raises(InvalidRetopoError, match='"auto", "none", or a number from 1'):
        Retopology(box(1), source).do(Call("draft", {"sharp": sharp}))


def test_a_thin_ring_keeps_its_creases_and_every_patch_has_quads(source: PatternSource) -> None:
    # A quarter of an edge thick: from one vertex to the next paths over the ring cross each other.
    mesh = trimesh.creation.annulus(0.05, 0.07, 0.005)
    surface = Surface.from_arrays(mesh.vertices, mesh.faces).orient()
    sizes = replace(Sizes.of(surface.diagonal), edge=0.0141)
    network = Network(longest=2.0 * surface.diagonal, surface=surface)
    task = DraftTask(network, surface, sizes, source, goal=DraftGoal(sharp=AUTOMATIC))
    made = propose_draft(task)
    assert made.sound and not len(made.poor) and made.report.euler == 0
    assert made.found.placed.keys() == made.network.patches.keys()
