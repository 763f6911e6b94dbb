"""What the pictures of the window of retopology show."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import weld_patches
from patterndb_sketch.retopo.filling.surface import FilledSurface
from query.engine import PatternSource
from tests.support.viewer.events import read
from tests.support.viewer.layers import count_marks, count_segments, find_layer
from tests.support.viewer.sheets import (
    ROOM,
    SQUARE,
    at,
    drag,
    hover,
    keys,
    opened,
    sheet,
    square,
    texts,
    tube,
)
from viewer import PictureFormatError, style
from viewer.retopo import RetopoState, draw
from viewer.retopo.marks import CORNER, CURVE, EDGE, FLOW, INK, MARKED, SIDES, SNAP, WRONG
from viewer.retopo.picture import RetopoPainter
from viewer.retopo.pointing import VIEW_SIDES, find_side
from viewer.stage import MATTE, Faces
from viewer.style import PAPER, parse_colour


def painted(state: RetopoState, colour: str) -> int:
    """How many marks of this colour the picture has."""
    return count_marks(RetopoPainter().compose(state, *ROOM), colour)


def banded(state: RetopoState, colour: str) -> int:
    """How many pieces of curves of this colour the picture has."""
    return count_segments(RetopoPainter().compose(state, *ROOM), colour)


def test_all_that_there_is_is_drawn(state: RetopoState) -> None:
    assert banded(state, MARKED) > 0, "the border of the sheet"
    assert banded(state, CURVE) == 0
    keys(state, "d")
    drag(state, (-3.0, 3.0), (3.0, 3.0))
    hover(state, (4.5, -4.5))
    assert painted(state, CORNER) == painted(state, PAPER) == 2, "two hollow ends"
    square(state, ((0.0, 2.0), (-1.9, 0.6), (-1.2, -1.6), (1.2, -1.6), (1.9, 0.6)))
    hover(state, (4.5, -4.5))
    assert painted(state, CORNER) == 2 + 5
    drag(state, (0.0, -3.5), (0.0, -1.6))
    hover(state, (4.5, -4.5))
    # One more open end, and a disc and a half disc.
    assert painted(state, CORNER) == 3 + 5 + 1 + 1
    body = state.shown.body
    for valence in (3, 5):
        colour = style.choose_valence_colour(valence)
        assert painted(state, colour) == int((body.valences == valence).sum())
    assert len(body.irregular) > 0
    assert painted(state, SNAP) == 0
    hover(state, (-3.0, 3.0))
    assert painted(state, SNAP) > 0
    keys(state, "w")
    drag(state, (-1.4, 0.0), (1.4, 0.0))
    assert banded(state, FLOW) > 0
    keys(state, "x")
    assert painted(state, style.choose_valence_colour(5)) == 0
    # From below, the sheet hides it all; and one can see through it.
    keys(state, "3")
    hover(state, (40.0, 40.0))
    assert banded(state, CURVE) == painted(state, CORNER) == 0
    keys(state, "m")
    assert banded(state, CURVE) > 0


def test_patches_have_the_colour_of_their_sides(state: RetopoState) -> None:
    square(state)
    hover(state, (4.5, -4.5))
    quads = find_layer(RetopoPainter().compose(state, *ROOM), "quads")
    assert isinstance(quads, Faces) and quads.sheets and quads.point_colours is not None
    assert len(quads.faces) == 2 * len(state.shown.body.mesh.quads)
    assert np.allclose(quads.point_colours, parse_colour(SIDES[4]))


def test_the_half_that_is_an_image_is_darker(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        whole = find_layer(RetopoPainter().compose(state, *ROOM), "surface")
        assert isinstance(whole, Faces) and whole.point_colours is None
        keys(state, "M")
        plane = state.shown.state.plane
        assert plane is not None
        drawn = find_layer(RetopoPainter().compose(state, *ROOM), "surface")
        assert isinstance(drawn, Faces) and drawn.point_colours is not None
        beyond = plane.heights(drawn.points) < 0.0
        ratio = drawn.point_colours / parse_colour(MATTE)
        assert np.allclose(ratio[beyond], 0.84) and np.allclose(ratio[~beyond], 1.0)
        assert beyond.any()
    finally:
        state.close()


def test_what_is_drawn_is_seen(state: RetopoState) -> None:
    places = [at(state, (-1.0, 0.0)), at(state, (1.0, 0.5))]
    state.move(*places[0])
    state.press(*places[0])
    state.move(*places[1])
    assert banded(state, INK) > 0
    state.release(*places[1])
    state.settle()
    assert banded(state, INK) == 0


def test_numbers_of_edges_are_written_in_the_mode_of_counts(state: RetopoState) -> None:
    square(state)
    keys(state, "t")

    def numbers() -> list[tuple[str, bool]]:
        texts = RetopoPainter().compose(state, *ROOM).scene.texts
        return sorted((t.text, t.bold) for t in texts if t.text.isdigit() and t.size == 11.0)

    counts = [c.count for c in state.network.chains.values() if not c.marked]
    assert numbers() == sorted((str(n), False) for n in counts)
    hover(state, (0.0, -1.5))
    state.wheel(1.0)
    state.settle()
    assert sum(bold for _, bold in numbers()) == 1
    keys(state, "3")
    assert numbers() == [], "hidden by the sheet"


def test_a_picture_of_several_sides_has_each_of_them(tmp_path: Path, source: PatternSource) -> None:
    editor = Retopology(sheet(), source)
    for k in range(4):
        line = [[*SQUARE[k - 1], 0.0], [*SQUARE[k], 0.0]]
        editor.do(Call("stroke", {"points": line}))
    (tmp_path / "sub").mkdir()
    for side in VIEW_SIDES:
        draw(editor, tmp_path / "sub" / f"{side}.png", sides=[side], size=(240, 160))
    draw(editor, tmp_path / "all.png", sides=VIEW_SIDES, size=(240, 160))
    whole = read(tmp_path / "all.png")
    # Seven tiles in three columns; two places stay blank.
    assert whole.shape == (480, 720, 3)
    seen: list[bytes] = []
    for k, side in enumerate(VIEW_SIDES):
        one = read(tmp_path / "sub" / f"{side}.png")
        top, left = k // 3 * 160, k % 3 * 240
        np.testing.assert_array_equal(whole[top : top + 160, left : left + 240], one)
        seen.append(one.tobytes())
    assert len(set(seen)) == len(VIEW_SIDES)
    assert (whole[320:, 240:] == whole[-1, -1]).all()
    # Without a name in the corner: what is drawn by itself is drawn from home.
    draw(editor, tmp_path / "home.png", size=(240, 160))
    assert (read(tmp_path / "home.png")[:120] == whole[:120, :240]).all()
    with pytest.raises(ValueError, match="no side 'below'; there are home, front"):
        draw(editor, tmp_path / "d.png", sides=["front", "below"])


@pytest.mark.parametrize("upright", ["x", "y", "z"])
def test_sides_are_at_right_angles_and_home_is_nearest_to_the_front(upright: str) -> None:
    ways = {side: np.array(find_side(upright, side)) for side in VIEW_SIDES}
    for one, other in (("front", "back"), ("left", "right"), ("top", "bottom")):
        assert (ways[one] == -ways[other]).all()
    # Seen from the front with the top up, the right side is on the right.
    assert (np.cross(ways["top"], ways["front"]) == ways["right"]).all()
    assert ways["top"]["xyz".index(upright)] == 1.0
    others = [way for side, way in ways.items() if side != "home"]
    assert ways["home"] @ ways["front"] == max(ways["home"] @ way for way in others)


def test_an_off_screen_picture_is_the_same_every_time(
    tmp_path: Path, source: PatternSource
) -> None:
    editor = Retopology(sheet(), source)
    for k in range(4):
        line = [[*SQUARE[k - 1], 0.0], [*SQUARE[k], 0.0]]
        editor.do(Call("stroke", {"points": line}))
    for name in "ab":
        draw(editor, tmp_path / f"{name}.png", toward=(0, 0, 1), size=(480, 320))
    image = read(tmp_path / "a.png")
    assert image.shape == (320, 480, 3)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    # The patch is warm, the sheet is grey.
    assert 1500 < (image[..., 0] - image[..., 2] > 0.05).sum() < 15000
    draw(editor, tmp_path / "c.png", size=(480, 320), keys="x m m")
    assert (read(tmp_path / "c.png").min(axis=2) > 0.9).mean() > 0.7
    with pytest.raises(ValueError, match="no key 'zz'"):
        draw(editor, tmp_path / "d.png", keys="zz")
    with pytest.raises(PictureFormatError):
        draw(editor, tmp_path / "d.jpg")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.png", "c.png"]


def test_curves_alone_and_quads_alone_are_drawn(state: RetopoState) -> None:
    square(state)
    hover(state, (4.5, -4.5))
    tinted = len(state.shown.body.mesh.quads) * 2
    edges = banded(state, EDGE)
    assert edges > 0 and banded(state, CURVE) > 0
    keys(state, "x")
    assert banded(state, EDGE) == 0 and banded(state, CURVE) > 0
    keys(state, "x")
    # The edges that lay under curves are seen now: all of every quad.
    assert banded(state, EDGE) > edges and banded(state, CURVE) == painted(state, CORNER) == 0
    body = state.shown.body
    quads = body.mesh.quads
    pairs = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    ends = body.mesh.vertices[np.unique(pairs, axis=0)]
    assert {tuple(sorted(map(tuple, one))) for one in body.edges.tolist()} == {
        tuple(sorted(map(tuple, one))) for one in ends.tolist()
    }
    assert len(body.edges) == len(ends) and body.rims.any() and not body.rims.all()
    assert tinted > 0 and banded(state, MARKED) == 0


def test_patches_without_quads_and_flipped_quads_are_red(state: RetopoState) -> None:
    square(state)
    hover(state, (4.5, -4.5))
    assert banded(state, WRONG) == 0 and state.editing.list_empty() == ()
    (patch,) = state.network.patches
    shown, placed = state.shown, state.shown.filled.placed[patch]
    wrong = replace(placed, flipped=np.array([0, 3], np.int32))
    found = replace(shown.filled, placed={patch: wrong})
    body = FilledSurface.from_filled(found, state.surface, shown.body.mesh)
    assert np.flatnonzero(body.flipped).tolist() == [0, 1, 6, 7]
    none = replace(shown.filled, placed={})
    empty = FilledSurface.from_filled(none, state.surface, weld_patches(none))
    for filled, made, told in (
        (found, body, "2 quads, in red"),
        (none, empty, "0, 1 patch without"),
    ):
        state.editing.shown = replace(shown, filled=filled, body=made)
        assert told in texts(state)
        drawn = RetopoPainter().compose(state, *ROOM)
        if filled is found:
            quads = find_layer(drawn, "quads")
            assert isinstance(quads, Faces) and quads.point_colours is not None
            red = (np.abs(quads.point_colours - parse_colour(WRONG)) < 1e-6).all(axis=1)
            assert red.sum() == 3 * 4
        assert (count_segments(drawn, WRONG) > 0) == (filled is none)
    assert state.editing.list_empty() == (patch,)
    state.editing.shown = shown


def test_density_is_seen_while_it_is_painted(state: RetopoState) -> None:
    def hues() -> np.ndarray:
        """How much more red than blue there is at every point of the surface and its quads."""
        drawn = RetopoPainter().compose(state, *ROOM)
        found = []
        for name in ("surface", "below quads", "quads"):
            layer = find_layer(drawn, name)
            assert isinstance(layer, Faces)
            colours = layer.point_colours
            if colours is None:
                colours = np.tile(parse_colour(MATTE), (len(layer.points), 1))
            found.append(colours[:, 0] - colours[:, 2])
        return np.concatenate(found)

    square(state)
    before = state.shown.body.mesh
    keys(state, "9")
    assert state.tool.mode.tool == "density" and state.density_shown
    hover(state, (40.0, 40.0))
    bare = hues()
    drag(state, (-1.0, 0.0), (1.0, 0.0))
    hover(state, (40.0, 40.0))
    assert len(state.network.density.strokes) == 1
    assert len(state.shown.body.mesh.quads) > len(before.quads)
    warm = hues()
    assert warm.max() > bare.max() + 0.1, "finer is warm"
    state.editing.do("undo")
    hover(state, (40.0, 40.0))
    assert not state.network.density.strokes
    assert hues() == pytest.approx(bare)
    state.tool.options["density", "how"] = "coarser"
    drag(state, (-1.0, 0.0), (1.0, 0.0))
    hover(state, (40.0, 40.0))
    assert hues().min() < bare.min() - 0.1, "coarser is cold"
    keys(state, "d")
    hover(state, (40.0, 40.0))
    assert not state.density_shown
