"""The viewer of shape models: its pictures without a window, and its window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb_sketch.features.errors import InvalidFeatureError
from tests.support.viewer.events import read
from tests.support.viewer.layers import count_marks, count_segments
from tests.support.viewer.sayings import read_sheet
from tests.support.viewer.shapes import car_shapes, car_template
from viewer import PictureFormatError
from viewer.facts import FactSheet
from viewer.keymap import Effect
from viewer.shapes import ShapesState, draw
from viewer.shapes.commands import KEYS
from viewer.shapes.picture import EDGE, GHOST, GRABBED, HELD, PARTS, compose_shape, describe_shape
from viewer.shapes.window import ShapesSaver
from viewer.style import parse_colour


def share(image: np.ndarray, colour: str) -> float:
    """The part of an image that has a colour's hue and strength, whatever its shade."""
    pixels = image.reshape(-1, 3)
    wanted = parse_colour(colour) - parse_colour(colour).mean()
    tint = pixels - pixels.mean(axis=1, keepdims=True)
    size = np.linalg.norm(tint, axis=1)
    along = tint @ wanted / np.maximum(size * np.linalg.norm(wanted), 1e-9)
    return float(((along > 0.985) & (size > 0.5 * np.linalg.norm(wanted))).mean())


def count_coloured(state: ShapesState, colour: str) -> int:
    """How many pieces of curves and marks have a colour."""
    drawn = compose_shape(state, 1040.0, 860.0)
    return count_segments(drawn, colour) + count_marks(drawn, colour)


def opened() -> ShapesState:
    state = ShapesState(car_shapes(), car_template())
    compose_shape(state, 1040.0, 860.0)
    return state


def test_a_picture_shows_curves_in_the_colours_of_their_parts(tmp_path: Path) -> None:
    path = tmp_path / "car.png"
    draw(car_shapes(), car_template(), path, size=(480, 320))
    image = read(path)
    assert image.shape == (320, 480, 3)
    assert 0.15 < (image.min(axis=2) < 0.97).mean() < 0.7
    with_curves = [share(image, colour) for colour in PARTS[:3]]
    assert min(with_curves) > 0.0005
    draw(car_shapes(), car_template(), path, size=(480, 320), keys="w")
    bare = read(path)
    assert all(share(bare, colour) < 0.0001 for colour in PARTS[:3])
    assert share(bare, GHOST) == 0.0
    draw(car_shapes(), car_template(), path, size=(480, 320), keys="w n g")
    assert share(read(path), GHOST) > 0.001


def test_a_picture_of_coefficients_is_that_of_their_shape(tmp_path: Path) -> None:
    """A training shape by its coefficients and by the key that steps to it; the same bytes."""
    names = [tmp_path / f"{k}.png" for k in range(3)]
    options = {"size": (320, 220), "caption": "a car"}
    coefficients = car_shapes().coefficients
    draw(car_shapes(), car_template(), names[0], coefficients=coefficients[1], **options)
    draw(car_shapes(), car_template(), names[1], keys="n n", **options)
    draw(car_shapes(), car_template(), names[2], coefficients=coefficients[2], **options)
    first, second, other = (name.read_bytes() for name in names)
    assert first == second != other


def test_wrong_wishes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no key 'zz'"):
        draw(car_shapes(), car_template(), tmp_path / "a.png", keys="zz")
    with pytest.raises(PictureFormatError):
        draw(car_shapes(), car_template(), tmp_path / "a.jpg")
    with pytest.raises(InvalidFeatureError, match="finite numbers"):
        draw(car_shapes(), car_template(), tmp_path / "a.png", coefficients=[0.0])
    assert list(tmp_path.iterdir()) == []


def test_switches_change_what_is_drawn() -> None:
    """Held curves, the pulled one, edges of faces, and the ghost."""
    state = opened()
    assert count_coloured(state, EDGE) == 0
    assert count_coloured(state, HELD) == 0
    state.shaping.toggle_held("shoulder")
    assert count_coloured(state, HELD) > 0
    KEYS.press(state, "e")
    assert count_coloured(state, EDGE) == len(state.skin.edges)
    line = next(i for i, one in enumerate(state.skin.lines) if one.name == "roof_rail")
    at = state.sight.lines[line][2, :2]
    assert count_coloured(state, GRABBED) == 0
    state.press(*at)
    state.move(at[0], at[1] + 30.0)
    # The curve where it should be is dashed and flat.
    assert count_coloured(state, GRABBED) > 0


def test_the_window_says_what_is_known() -> None:
    state = opened()
    state.shaping.toggle_held("shoulder")
    for key in ["n", "g", "m", "z"]:
        KEYS.press(state, key)
    line = next(i for i, one in enumerate(state.skin.lines) if one.name == "roof_rail")
    state.move(*state.sight.lines[line][2, :2])
    drawn = compose_shape(state, 1040.0, 860.0)
    sheet = FactSheet()
    describe_shape(sheet, state)
    texts = [*(t.text for t in drawn.scene.texts), *read_sheet(sheet)]
    for wanted in ("car 0", "6 shapes, 5 modes", "one vertex, along z", "shoulder", "roof rail"):
        assert wanted in texts


def test_saving(tmp_path: Path) -> None:
    """The OBJ file has the shape that is shown, number for number, and the model's quads."""
    state = opened()
    target = tmp_path / "new.obj"
    saver = ShapesSaver(state, target, (480, 300))
    assert saver.play(["r", "o", "p", "p"]) is Effect.NOTHING
    assert "saved" in state.message
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["new-1.png", "new-2.png", "new.obj"]
    mesh = read_mesh(target)
    assert np.array_equal(mesh.points, state.shaping.points)
    assert np.array_equal(mesh.quads()[0], state.skin.quads) and mesh.n_faces == len(
        state.skin.quads
    )
    saver.play(["r", "o"])
    assert np.array_equal(read_mesh(target).points, state.shaping.points)
    ShapesSaver(state, tmp_path / "no" / "new.obj", (480, 300)).obey("o")
    assert "not saved" in state.message
    assert saver.play(["q", "w"]) is Effect.QUIT and state.curves_shown


def test_without_a_file_new_ones_are_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ShapesSaver(opened(), None, (480, 300)).play(["o", "o", "p"])
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["shape-1.obj", "shape-1.png", "shape-2.obj"]
