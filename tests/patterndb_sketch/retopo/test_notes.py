"""What notes and refusals say: places that can be pointed at, and what would mend it."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.judging import DraftJudge
from patterndb_sketch.retopo.draft.refitting import claim_curves
from patterndb_sketch.retopo.editor import Call, Retopology, find_new_leaps
from patterndb_sketch.retopo.filling import FilledNetwork, find_open_edges
from patterndb_sketch.retopo.filling.mesh import find_doublets
from patterndb_sketch.retopo.script import line_of, play_script, script_of
from patterndb_sketch.retopo.wording import format_place, list_places
from query.engine import PatternSource
from tests.support.retopo.editors import SIZES, do, drawn_grid, line
from tests.support.retopo.networks import plane, sphere

PLACE = r"\((-?[\d.e-]+), (-?[\d.e-]+), (-?[\d.e-]+)\)"


def read_places(text: str) -> np.ndarray:
    return np.array([[float(x) for x in found] for found in re.findall(PLACE, text)])


def test_places_are_listed_all_of_a_few_and_the_first_of_many() -> None:
    points = np.arange(15.0).reshape(5, 3)
    assert format_place(points[0]) == "(0, 1, 2)"
    assert format_place([-0.0, 1.0 / 3.0, 1e-9]) == "(0, 0.3333, 1e-09)"
    assert list_places(points[:1]) == "at (0, 1, 2)"
    assert list_places(points[:2]) == "at (0, 1, 2) and (3, 4, 5)"
    assert list_places(points[:3]) == "at (0, 1, 2), (3, 4, 5) and (6, 7, 8)"
    assert list_places(points) == "at (0, 1, 2), (3, 4, 5), (6, 7, 8) and 2 more"


def test_flipped_quads_are_told_with_their_places(source: PatternSource) -> None:
    editor = drawn_grid(source, 1)
    editor.fill()
    # The vertex in the middle is dragged over its neighbours.
    do(editor, "brush", at=[0.5, 0.5, 0.0], to=[0.9, 0.5, 0.0], radius=0.2)
    found: FilledNetwork = editor.fill()
    (placed,) = found.placed.values()
    notes = [note for note in found.notes if "flipped" in note]
    assert len(placed.flipped) > 0 and len(notes) == 1
    middles = placed.find_flipped()
    assert len(middles) == len(placed.flipped)
    there = read_places(notes[0])
    np.testing.assert_allclose(there, middles[: len(there)], atol=1e-3)
    assert DraftJudge(editor.surface, None).find_furthest(found).shape == (3,)


def plates() -> Surface:
    """Two sheets, one 0.4 above the other."""
    n = 21
    x, y = np.meshgrid(np.linspace(-5, 5, n), np.linspace(-5, 5, n), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
    k = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [np.stack([k, k + n, k + n + 1], axis=1), np.stack([k, k + n + 1, k + 1], axis=1)]
    )
    return Surface.from_arrays(
        np.concatenate([points, points + np.array([0.0, 0.0, 0.4])]),
        np.concatenate([faces, faces + n * n]),
    ).orient()


def draw_bare_square(editor: Retopology, x: float, y: float) -> None:
    corners = [(x, y), (x + 1.5, y), (x + 1.5, y + 1.5), (x, y + 1.5)]
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        assert editor.do(Call("stroke", {"points": line(a, b)})).changed
    assert editor.do(Call("patch", {"at": [x + 0.7, y + 0.7, 0.0], "off": True})).changed


def test_a_patch_is_stopped_only_by_curves_near_that_leave_the_surface(
    source: PatternSource,
) -> None:
    editor = Retopology(plates(), source, SIZES)
    draw_bare_square(editor, 2.0, 2.0)
    draw_bare_square(editor, -4.0, -4.0)
    # From the lower sheet to the upper one, and far from the first square.
    jump = [[-3.7, -3.0, 0.0], [-3.2, -3.0, 0.0], [-3.1, -3.0, 0.4], [-2.9, -3.0, 0.4]]
    assert editor.do(Call("stroke", {"points": jump})).changed
    before = len(editor.network.patches)
    outcome = editor.do(Call("patch", {"at": [2.7, 2.7, 0.0]}))
    assert outcome.refused is None and len(editor.network.patches) == before + 1
    refused = editor.do(Call("patch", {"at": [-3.2, -3.4, 0.0]})).refused
    assert refused is not None and "leaves the surface at (" in refused, refused
    (place,) = read_places(refused)
    assert np.linalg.norm(place - [-3.15, -3.0, 0.2]) < 0.3


class TestSymmetry:
    def test_find_says_how_far_off_the_plane_is(self, source: PatternSource) -> None:
        outcome = do(Retopology(sphere(), source), "symmetry", find=True)
        (note,) = outcome.notes
        assert re.fullmatch(
            rf"symmetry is on: the plane through {PLACE} across {PLACE}, [\d.e-]+ % off", note
        )

    def test_find_refuses_what_is_no_plane_of_symmetry_and_offers_the_axes(
        self, source: PatternSource
    ) -> None:
        ball = sphere()
        x, y, z = ball.vertices.T
        bent = np.stack([1.6 * x + 0.5 * z * z * y, y + 0.5 * x * x + 0.2 * z, z + 0.4 * x * y], 1)
        editor = Retopology(Surface.from_arrays(bent, ball.triangles).orient(), source)
        before = editor.state
        refused = editor.do(Call("symmetry", {"find": True})).refused
        assert refused is not None and editor.state is before
        assert re.search(
            rf"symmetric in no plane, to 0.5 %.*nearest is the plane through {PLACE}.* % off.*"
            r"x [\d.]+ %, y [\d.]+ %, z [\d.]+ % off; give axis",
            refused,
        )
        # Asked for by its name it is taken, and how far off it is, is told.
        (note,) = do(editor, "symmetry", axis="z").notes
        assert "not symmetric in the plane through (0, 0, 0) across (0, 0, 1)" in note
        assert editor.state.plane is not None and editor.state.plane.normal == (0.0, 0.0, 1.0)

    def test_an_axis_goes_through_the_point_that_is_given(self, source: PatternSource) -> None:
        editor = Retopology(sphere(), source)
        assert do(editor, "symmetry", axis="y").notes == ()
        do(editor, "symmetry", on=False)
        do(editor, "symmetry", axis="x", point=[0.1, 0.0, 0.0])
        plane_now = editor.state.plane
        assert plane_now is not None
        assert (plane_now.point, plane_now.normal) == ((0.1, 0.0, 0.0), (1.0, 0.0, 0.0))

    @pytest.mark.parametrize(
        "arguments",
        [
            {"axis": "x", "normal": [1, 0, 0]},
            {"axis": "x", "find": True},
            {"axis": "w"},
            {"on": False, "axis": "x"},
        ],
    )
    def test_an_axis_is_given_once(
        self, arguments: dict[str, object], source: PatternSource
    ) -> None:
        with pytest.raises(ValueError, match=r"symmetry|axis"):
            Retopology(sphere(), source).do(Call("symmetry", arguments))


def test_open_ends_are_told_when_they_are_drawn_and_not_again(source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    (note,) = do(editor, "stroke", points=line((0, 0), (2, 0))).notes
    assert note.startswith("2 open ends at ") and "snap radius of 0.1" in note
    there = {tuple(place) for place in read_places(note)}
    assert there == {(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)}
    # From one open end to nowhere: only the new one is told.
    (note,) = do(editor, "stroke", points=line((2, 0), (2, 2))).notes
    assert note.startswith("an open end at ")
    np.testing.assert_allclose(read_places(note), [[2.0, 2.0, 0.0]], atol=1e-9)
    do(editor, "stroke", points=line((2, 2), (0, 2)))
    assert do(editor, "stroke", points=line((0, 2), (0, 0))).notes == ()


def find_mesh_doublets(editor: Retopology) -> np.ndarray:
    """(k, 3) inner vertices of the mesh with two quads, by counting."""
    mesh = editor.mesh(editor.fill())
    valence = np.bincount(mesh.quads.ravel(), minlength=len(mesh.vertices))
    inner = np.ones(len(valence), bool)
    inner[find_open_edges(mesh).ravel()] = False
    return mesh.vertices[inner & (valence == 2)]


def test_doublets_are_told_where_the_mesh_has_them(source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    square = [(0, 0), (3, 0), (3, 3), (0, 3)]
    for a, b in zip(square, square[1:] + square[:1], strict=True):
        do(editor, "stroke", points=line(a, b))
    # From corner to corner with a bend that nothing leads to: four corners on either side.
    do(editor, "stroke", points=line((0, 0), (1.5, 1.7)))
    do(editor, "stroke", points=line((1.5, 1.7), (3, 3)))
    expected = find_mesh_doublets(editor)
    found = editor.fill()
    told = [note for note in found.notes if "doublet" in note]
    assert len(told) == len(expected) == 1
    np.testing.assert_allclose(read_places(told[0]), expected, atol=1e-3)
    # A curve that leads there mends it.
    do(editor, "stroke", points=line((1.5, 1.7), (1.5, 3)))
    found = editor.fill()
    assert not any("doublet" in note for note in found.notes)
    assert len(find_mesh_doublets(editor)) == len(find_doublets(found.network, found.placed)) == 0


def test_a_script_tells_doublets_by_the_line_that_made_them(source: PatternSource) -> None:
    square = [(0, 0), (3, 0), (3, 3), (0, 3), (0, 0), (1.5, 1.7), (3, 3)]
    lines = ['{"tool": "open", "surface": "plane.obj"}']
    for a, b in pairwise(square):
        lines.append(line_of(Call("stroke", {"points": line(a, b)})))
    # What is drawn next elsewhere does not tell it again.
    lines.append(line_of(Call("stroke", {"points": line((-3, 0), (-1, 0))})))
    editor = Retopology(plane(), source, SIZES)
    script = script_of(lines)
    played = list(play_script(script, editor, lambda name, found: None))
    telling = [one.number for one, outcome in played if "doublet" in " ".join(outcome.notes)]
    assert telling == [7]


@pytest.mark.parametrize("symmetric", [True, False])
def test_doublets_are_those_of_the_mesh_whatever_is_drawn(
    symmetric: bool, source: PatternSource
) -> None:
    editor = Retopology(plane(), source, SIZES)
    if symmetric:
        do(editor, "symmetry")
    for a, b in (((0, 0), (2, 0)), ((2, 0), (2, 2)), ((2, 2), (0, 2)), ((0, 2), (0, 0))):
        editor.do(Call("stroke", {"points": line(a, b)}))
    # A lens, and a cut along its axis.
    arc = [(2 + 1.5 * t, 1 + 0.6 * s * np.sin(np.pi * t)) for s in (1, -1) for t in (0, 0.5, 1)]
    for k in (0, 3):
        editor.do(Call("stroke", {"points": line(*arc[k : k + 3])}))
    found = editor.fill()
    there = find_mesh_doublets(editor)
    points = find_doublets(found.network, found.placed)
    if symmetric:
        plane_now = editor.state.plane
        assert plane_now is not None
        images = plane_now.mirror(points)
        off = np.abs(points[:, 0]) > 1e-9
        points = np.concatenate([points, images[off]])
    assert same_set(points, there)


def same_set(one: np.ndarray, two: np.ndarray) -> bool:
    """Are two sets of points (n, 3) the same, in any order?"""
    rows = [sorted(map(tuple, np.round(points, 9).tolist())) for points in (one, two)]
    return rows[0] == rows[1]


def test_a_curve_that_jumps_to_another_part_is_told_with_its_place(source: PatternSource) -> None:
    editor = Retopology(plates(), source, SIZES)
    jump = [[-3.7, -3.0, 0.0], [-3.2, -3.0, 0.0], [-3.1, -3.0, 0.4], [-2.9, -3.0, 0.4]]
    notes = editor.do(Call("stroke", {"points": jump})).notes
    told = [note for note in notes if "leaves the surface" in note]
    assert len(told) == 1 and "points nearer" in told[0]
    assert np.linalg.norm(read_places(told[0])[0] - [-3.15, -3.0, 0.2]) < 0.3
    # What crosses it cuts it in two: that it jumps is not told again.
    notes = editor.do(Call("stroke", {"points": [[-3.5, -4, 0], [-3.5, -2, 0]]})).notes
    assert len(editor.network.chains) == 6
    assert not any("leaves the surface" in note for note in notes)


def test_of_a_draft_s_own_curves_it_is_not_told_that_they_leave_the_surface(
    source: PatternSource,
) -> None:
    editor = Retopology(plates(), source, SIZES)
    jump = [[-3.7, -3.0, 0.0], [-3.2, -3.0, 0.0], [-3.1, -3.0, 0.4], [-2.9, -3.0, 0.4]]
    before = editor.network
    do(editor, "stroke", points=jump)
    after = editor.network
    laid = {c: replace(chain, auto=c not in before.chains) for c, chain in after.chains.items()}
    drafted = replace(after, chains=laid)
    assert len(find_new_leaps(before, after, editor.surface)) == 1
    assert not len(find_new_leaps(before, drafted, editor.surface))
    # Drawn anew it is the user's, and told.
    moved = {c: replace(chain, points=chain.points + 1e-6) for c, chain in laid.items()}
    claimed = claim_curves(drafted, replace(after, chains=moved))
    assert len(find_new_leaps(drafted, claimed, editor.surface)) == 1
    # Nor is a curve over an edge of the triangles, or around a ball.
    ball = Retopology(sphere(), source)
    assert do(ball, "loop", at=[0.95, 0.0, 0.3], normal=[0.1, 0.2, 1.0]).notes == ()
