"""The viewer of surfaces: its pictures without a window, and its window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.surfacing.methods import SurfaceRequest
from patterndb_sketch.surfacing.patch import Surfacing
from tests.support.viewer.domes import FROM_ABOVE, dome, said
from tests.support.viewer.events import read
from viewer import PictureFormatError
from viewer.keymap import Effect
from viewer.style import TINTS, parse_colour
from viewer.surfacing import SurfacingState, draw
from viewer.surfacing.window import SurfacingSaver


def hues(image: np.ndarray) -> set[int]:
    """Which tints an image shows, whatever their shade."""
    pixels = image.reshape(-1, 3)
    spread = np.ptp(pixels, axis=1) > 0.08
    pixels = pixels[spread]
    units = pixels / np.linalg.norm(pixels, axis=1, keepdims=True)
    tints = np.stack([parse_colour(tint) for tint in TINTS])
    tints /= np.linalg.norm(tints, axis=1, keepdims=True)
    nearest, off = (units @ tints.T).argmax(axis=1), (units @ tints.T).max(axis=1)
    counts = np.bincount(nearest[off > 0.9999], minlength=len(TINTS))
    return set(np.flatnonzero(counts > 0.004 * len(image.reshape(-1, 3))).tolist())


def test_an_off_screen_picture_shows_every_patch_in_its_colour(tmp_path: Path) -> None:
    path = tmp_path / "dome.png"
    state = draw(SurfacingState(dome(), **FROM_ABOVE), path, (480, 400), keys="- - - -")
    image = read(path)
    assert image.shape == (400, 480, 3)
    assert 0.3 < (image.min(axis=2) < 0.98).mean() < 0.9
    body = state.surfaces.body
    assert body is not None
    wanted = {tint for tints in body.tint_of for tint in tints}
    assert len(wanted) > 4 and len({tints[0] for tints in body.tint_of}) == 4
    assert len(hues(image) & wanted) >= 4
    # The same picture without the surface is lines alone.
    draw(SurfacingState(dome(), **FROM_ABOVE), path, (480, 400), keys="w e")
    assert hues(read(path)) == set()


def test_a_picture_is_the_same_everywhere(tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.png" for k in range(2)]
    for path in paths:
        state = SurfacingState(dome(), **FROM_ABOVE)
        draw(state, path, (320, 200), keys="m x", caption="a dome")
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_wrong_wishes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no key 'zz'"):
        draw(SurfacingState(dome()), tmp_path / "a.png", keys="zz")
    with pytest.raises(PictureFormatError):
        draw(SurfacingState(dome()), tmp_path / "a.jpg")
    assert list(tmp_path.iterdir()) == []


def test_the_window_says_what_is_known() -> None:
    state = SurfacingState(dome(), settings=SurfaceRequest(method="chords"), **FROM_ABOVE)
    try:
        state.settle()
        texts = said(state)
        assert "4 patches" in texts and "8, 5 nodes" in texts
        assert state.surfaces.edits.method in texts
        x, y, _ = state.camera.view.seen(np.array([0.4, 0.4, 0.8]))
        state.move(x, y)
        texts = said(state)
        result = state.surfaces.patches[0].surface
        assert result is not None
        assert "Patch at the pointer" in texts and "0-1, 1-4, 0-4" in texts
        assert f"{result.area:.4g}" in texts
        assert f"{len(result.chords)} of {result.candidates} candidates" in texts
    finally:
        state.close()


def test_saving(tmp_path: Path) -> None:
    state = SurfacingState(dome(), **FROM_ABOVE)
    written: list[tuple[Path, Surfacing]] = []
    try:
        saver = SurfacingSaver(state, tmp_path, lambda p, s: written.append((p, s)), (480, 300))
        assert saver.play(["s", "s", "o"]) is Effect.NOTHING
        assert "saved" in state.message
        names = sorted(path.name for path in tmp_path.iterdir())
        assert names == ["surface-1.png", "surface-2.png"]
        assert written[0][0].name == "surface-1.obj" and len(written[0][1].patches) == 4
        SurfacingSaver(state, tmp_path / "no", None, (480, 300)).obey("s")
        assert "not saved" in state.message
        SurfacingSaver(state, tmp_path, None, (480, 300)).obey("o")
        assert "cannot be saved" in state.message
        assert saver.play(["q", "w"]) is Effect.QUIT and state.surface_shown
    finally:
        state.close()
