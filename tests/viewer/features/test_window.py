"""The viewer of feature curves: its pictures without a window, its files, and its window."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bodies import body, degrade, stroke

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.curvefiles import FeatureFiles, format_obj_lines
from patterndb_sketch.features.files.networkjson import read_network
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from tests.support.viewer.events import read
from tests.support.viewer.layers import count_marks, count_segments
from tests.support.viewer.tents import drawn, keys, opened, picked, tent
from viewer import PictureFormatError
from viewer.features import FeatureState, draw
from viewer.features.picture import FAILED, MENDED, RIB_COLOUR, FeaturePainter
from viewer.features.window import FeatureSaver
from viewer.keymap import Effect

SIZE = (720, 450)


def colours(state: FeatureState) -> dict[str, int]:
    """How many pieces of ribs, and marks where there is none, are drawn."""
    drawn = FeaturePainter().compose(state, 1040.0, 860.0)
    return {
        "plain": count_segments(drawn, RIB_COLOUR),
        "mended": count_segments(drawn, MENDED),
        "failed": count_marks(drawn, FAILED),
    }


def saver_of(state: FeatureState, folder: Path, path: Path | None = None) -> FeatureSaver:
    files = FeatureFiles(folder, path)
    state.editing.files = files
    return FeatureSaver(state, files, SIZE)


def test_an_off_screen_picture_shows_the_model_and_its_curves(tmp_path: Path) -> None:
    state = opened()
    picked(state)
    session = state.editing.session()
    state.close()
    path = tmp_path / "a.png"
    closed = draw(tent(), path, session=session, size=(480, 320), keys="3")
    assert [curve.name for curve in closed.editing.edits.curves] == ["curve 1"]
    image = read(path)
    assert image.shape == (320, 480, 3)
    # The curve's blue is on the roof, not only in the list beside it.
    blue = (image[..., 2] - image[..., 0] > 0.12)[:, :340]
    assert 150 < blue.sum() < 3000
    draw(tent(), tmp_path / "b.png", session=session, size=(480, 320), keys="3")
    assert path.read_bytes() == (tmp_path / "b.png").read_bytes()
    draw(tent(), tmp_path / "c.png", session=session, size=(480, 320), keys="3 m m")
    bare = read(tmp_path / "c.png")
    assert (bare.min(axis=2) > 0.99).mean() > 0.9


def test_wrong_wishes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no key 'zz'"):
        draw(tent(), tmp_path / "a.png", session=FeatureSession(), keys="zz")
    with pytest.raises(PictureFormatError):
        draw(tent(), tmp_path / "a.jpg", session=FeatureSession())
    assert list(tmp_path.iterdir()) == []


def test_mended_and_failed_ribs_are_marked() -> None:
    clean = body("city car", 0.4)
    mess = degrade(clean, 3, uneven=True, gaps=0.004, crossings=0.004)
    state = FeatureState(Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles)))
    try:
        FeaturePainter().compose(state, 1040.0, 860.0)
        keys(state, "c")
        for point in stroke(clean, "a_pillar", 0.01, 2):
            state.editing.click(point)
        keys(state, "Enter")
        curve = state.editing.curve
        assert curve is not None
        snap = state.editing.snap_of(curve)
        assert snap is not None
        found = snap.curve
        assert colours(state) == {"plain": 0, "mended": 0, "failed": 0}
        keys(state, "r")
        seen = colours(state)
        assert (seen["plain"] > 0) == (len(found.repaired) + len(found.failed) < len(snap.ribs))
        assert found.repaired and seen["mended"] > 0
        assert (seen["failed"] > 0) == bool(found.failed)
        assert f"{len(snap.ribs)}, {len(found.repaired)} mended" in " ".join(drawn(state))
        # As if some had failed.
        failed = replace(snap, curve=replace(found, failed=(3, 4)))
        state.editing._snaps[curve] = failed
        assert colours(state)["failed"] > 0 and any("2 failed" in text for text in drawn(state))
    finally:
        state.close()


def test_everything_is_saved(tmp_path: Path) -> None:
    state = opened()
    picked(state)
    try:
        saver = saver_of(state, tmp_path)
        assert state.editing.unsaved
        assert saver.play(["s", "p", "o", "n", "s"]) is Effect.NOTHING
        assert (
            state.message == f"saved {tmp_path / 'features-1.session'}"
            and not state.editing.unsaved
        )
        names = sorted(path.name for path in tmp_path.iterdir())
        assert names == ["curves-1.json", "curves-1.obj", "features-1.png", "features-1.session"]
        (curve,) = FEATURE_SESSION.read(tmp_path / "features-1.session").curves
        look = state.editing.look(state.editing.edits.curves[0])
        assert look is not None and (curve.samples == look.samples).all()
        network = read_network(tmp_path / "curves-1.json")
        assert (network.curves["curve 1"].control == look.spline.control).all()
        lines = (tmp_path / "curves-1.obj").read_text().splitlines()
        assert lines[0] == "o curve_1"
        points = np.array([line.split()[1:] for line in lines if line[0] == "v"], float)
        assert (points == look.line).all()
        assert [int(n) for n in lines[-1].split()[1:]] == list(range(1, len(points) + 1))
        assert read(tmp_path / "features-1.png").shape[:2] == (SIZE[1], SIZE[0])
        lost = saver_of(state, tmp_path / "no")
        for key in "spon":
            state.message = ""
            lost.obey(key)
            assert state.message.startswith("not saved: "), key
    finally:
        state.close()
    empty = opened()
    try:
        saver_of(empty, tmp_path).play(["o", "n"])
        assert empty.message == "there is no curve to save"
    finally:
        empty.close()


def test_a_session_goes_back_into_its_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.zip"
    path.write_bytes(b"older")
    state = opened()
    picked(state)
    try:
        saver_of(state, tmp_path, path).obey("s")
        assert len(FEATURE_SESSION.read(path).curves) == 1 and list(tmp_path.iterdir()) == [path]
    finally:
        state.close()


def test_lines_of_several_curves_are_numbered_on() -> None:
    text = format_obj_lines({"a b": np.zeros((2, 3)), "c": np.ones((3, 3))})
    assert [line for line in text.splitlines() if line[0] in "ol"] == [
        "o a_b", "l 1 2", "o c", "l 3 4 5",
    ]  # fmt: skip


def left(folder: Path, mesh: str = "roof.obj") -> Path:
    """What a window left that was killed after a curve was drawn."""
    state = opened(session=FeatureSession(mesh))
    picked(state)
    path = folder / "unnamed-features.999999999-abc.recovery"
    FEATURE_SESSION.write(path, state.editing.session())
    state.close()
    return path


def test_what_is_drawn_is_kept_in_case_of_a_crash(tmp_path: Path) -> None:
    files = FeatureFiles(tmp_path, None)
    state = opened(session=FeatureSession("roof.obj"), files=files)
    try:
        assert (
            files.watch(state.editing.edits, state.editing.session, "roof.obj") == ""
            and files.autosave is not None
        )
        now = [0.0]
        files.autosave._clock, files.autosave._at = lambda: now[0], 0.0
        picked(state)
        state.poll()
        assert not list(tmp_path.iterdir())
        now[0] = 31.0
        state.poll()
        (kept,) = tmp_path.iterdir()
        assert kept.name.startswith("unnamed-features.")
        assert [one.name for one in FEATURE_SESSION.read(kept).curves] == ["curve 1"]
        assert state.editing.save_session()
        assert [one.name for one in tmp_path.iterdir()] == ["features-1.session"]
        state.editing.delete()
        now[0] = 62.0
        state.poll()
        assert len(list(tmp_path.iterdir())) == 2
        # Whoever closes the window has said what becomes of it; Ctrl-C has not.
        autosave = files.autosave
        kept = files.end(state.editing.edits)
        assert kept is not None and FEATURE_SESSION.read(kept).curves == ()
        files.autosave = autosave
        assert files.end(None) is None
        assert [one.name for one in tmp_path.iterdir()] == ["features-1.session"]
    finally:
        state.close()


def test_what_a_crash_left_is_one_step_and_goes_when_it_is_saved(tmp_path: Path) -> None:
    left(tmp_path)
    files = FeatureFiles(tmp_path, None)
    state = opened(session=FeatureSession("roof.obj"), files=files)
    try:
        keys(state, "R")
        assert state.message == "there is nothing that a crash left"
        assert files.watch(state.editing.edits, state.editing.session, "roof.obj").endswith(
            "R opens it in place of what is here"
        )
        assert FeatureSaver(state, files, SIZE).find_lost_work() is not None
        picked(state)
        mine = state.editing.edits
        keys(state, "R")
        (curve,) = state.editing.edits.curves
        assert curve.key not in {one.key for one in mine.curves} and state.editing.unsaved
        assert [one.name for one in state.editing.session().curves] == ["curve 1"]
        keys(state, "u")
        assert state.editing.edits is mine, "nothing is lost by taking it"
        keys(state, "U s")
        assert [one.name for one in tmp_path.iterdir()] == ["features-1.session"]
        kept = FEATURE_SESSION.read(tmp_path / "features-1.session")
        assert kept.mesh == "roof.obj" and len(kept.curves) == 1
    finally:
        state.close()


def test_what_a_crash_left_of_another_model_is_told_and_stays(tmp_path: Path) -> None:
    path = left(tmp_path, "hull.obj")
    state = opened()
    try:
        files = FeatureFiles(tmp_path, None)
        assert "of another model, hull.obj; rename it" in files.watch(
            state.editing.edits, state.editing.session, "roof.obj"
        )
        assert files.lost is None
        path.write_bytes(b"nothing")
        assert (
            "which cannot be read"
            in files.watch(state.editing.edits, state.editing.session, "roof.obj")
            and path.exists()
        )
    finally:
        state.close()
