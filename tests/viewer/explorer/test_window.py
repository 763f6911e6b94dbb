"""The window of the fill explorer: keys, facts, pictures, files, and simulated events."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from patterndb.errors import NotFoundError
from query.contour import make_flat_boundary
from tests.support.viewer.domed import SOURCE, opened
from tests.support.viewer.sayings import read_sheet
from viewer import PictureFormatError
from viewer.explore import ExplorerSaver, explore
from viewer.explorer_commands import KEYS
from viewer.explorer_picture import compose_explorer, describe_explorer
from viewer.explorer_state import ExplorerState
from viewer.facts import FactSheet
from viewer.keymap import Effect


def test_keys_are_known() -> None:
    assert KEYS.check("o Right bracketleft S") == ["o", "Right", "bracketleft", "S"]
    with pytest.raises(ValueError, match="no key 'zz'"):
        KEYS.check("o zz")
    state = opened()
    try:
        effects = KEYS.effects
        assert [KEYS.press(state, k) for k in effects] == list(effects.values())
        assert KEYS.press(state, "F13") is Effect.NOTHING
        assert KEYS.press(state, "Escape") is Effect.REDRAW
    finally:
        state.close()


def test_the_window_says_what_is_known(state: ExplorerState) -> None:
    state.settle(1)
    state.settle()
    sheet = FactSheet()
    describe_explorer(sheet, state)
    texts = [t.text for t in compose_explorer(state, 1040.0, 860.0).scene.texts]
    texts += read_sheet(sheet)
    fill = state.finder.fill
    assert fill is not None and fill.pattern.name in texts
    assert f"fill 2 of {len(state.finder.fills)}" in texts and "4 3 4 3" in texts
    for length in ("4", "3"):
        assert texts.count(length) >= 2, "every side has its number"


def test_a_picture_is_the_same_everywhere(tmp_path: Path) -> None:
    boundary = make_flat_boundary((2, 2, 2, 2))
    pictures = [tmp_path / f"{k}.png" for k in range(2)]
    for picture in pictures:
        state = explore(
            SOURCE, boundary, off_screen=picture, keys="r Right", window_size=(480, 300)
        )
        assert state.finder.strict
    assert pictures[0].read_bytes() == pictures[1].read_bytes()
    from matplotlib.image import imread

    image = np.asarray(imread(pictures[0]))
    assert image.shape[:2] == (300, 480)
    assert len(np.unique((image.reshape(-1, image.shape[2]) * 255).astype(int), axis=0)) > 50


def test_wrong_wishes_are_refused(tmp_path: Path) -> None:
    boundary = make_flat_boundary((2, 2, 2, 2))
    with pytest.raises(ValueError, match="no key 'zz'"):
        explore(SOURCE, boundary, off_screen=tmp_path / "a.png", keys="zz")
    with pytest.raises(PictureFormatError):
        explore(SOURCE, boundary, off_screen=tmp_path / "a.jpg")
    with pytest.raises(NotFoundError):
        explore(SOURCE, off_screen=tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_saving(state: ExplorerState, tmp_path: Path) -> None:
    written: list[tuple[Path, int]] = []
    saver = ExplorerSaver(state, tmp_path, lambda p, f, v: written.append((p, len(v))), (480, 300))
    assert saver.play(["p", "w"]) is Effect.NOTHING
    fill = state.finder.fill
    assert fill is not None and f"saved {tmp_path}" in state.message
    assert [p.name for p in tmp_path.iterdir()] == [f"fill-{fill.pattern.name}-1.png"]
    assert written == [(tmp_path / f"fill-{fill.pattern.name}-1.obj", fill.n_vertices)]
    ExplorerSaver(state, tmp_path / "no", None, (480, 300)).obey("p")
    assert "not saved" in state.message
    ExplorerSaver(state, tmp_path, None, (480, 300)).obey("w")
    assert "cannot be saved" in state.message
    assert saver.play(["q", "n"]) is Effect.QUIT and not state.hiding
