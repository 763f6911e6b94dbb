"""Two windows on one file: the later save is refused, whatever is saved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from patterndb.system.knownfiles import FileChangedError
from patterndb_sketch.retopo.network import are_equal
from patterndb_sketch.retopo.session import RETOPO_SESSION
from query.engine import PatternSource
from tests.viewer.test_recovery import draw_boundary, explorer, pull, shapes, surfacing, write
from viewer.saver import Saver

SIZE = (720, 450)


def open_retopo(folder: Path, source: PatternSource) -> Any:
    """A window on the folder's session, as the command line opens one."""

    from patterndb_sketch.retopo.editor import Retopology
    from patterndb_sketch.retopo.files import RetopoFiles
    from patterndb_sketch.retopo.script import Script
    from patterndb_sketch.retopo.session import RetopoSession, autosave_session
    from tests.support.viewer.sheets import sheet
    from viewer.retopo import RetopoState
    from viewer.retopo.window import RetopoSaver

    path = folder / "sheet.retopo"
    editor = Retopology(sheet(), source)
    files = RetopoFiles(folder, path, folder / "sheet.jsonl", Script("sheet.obj", ()), write)
    if path.exists():
        editor.restore(RETOPO_SESSION.read(path).state)
    files.autosave = autosave_session(
        RetopoSession(editor.surface, editor.state), session=path, base=files.known.digest(path)
    )
    state = RetopoState(editor, files=files)
    state.message = files.find_lost(editor.surface)
    return RetopoSaver(state, files, SIZE)


def stroke(saver: Any, y: float) -> None:
    saver.state.editing.do("stroke", points=[[-2.0, y, 0.0], [2.0, y, 0.0]])
    saver.state.settle()
    assert saver.state.editing.unsaved


def close(*savers: Any) -> None:
    for saver in savers:
        saver.files._ends_with_script = False
        saver.end(discarded=True)


@pytest.fixture
def two(tmp_path: Path, source: PatternSource) -> Any:
    savers = [open_retopo(tmp_path, source) for _ in range(2)]
    yield savers
    close(*savers)


def test_the_second_save_of_a_session_is_refused(tmp_path: Path, two: Any) -> None:
    one, other = two
    stroke(one, 1.0)
    stroke(other, -1.0)
    one.obey("s")
    kept = (tmp_path / "sheet.retopo").read_bytes()
    assert one.state.message.startswith("saved") and not one.would_lose()
    other.obey("s")
    assert other.state.message.startswith("not saved:")
    for way in ("reload it", "save to another file", "overwrite it"):
        assert way in other.state.message
    assert (tmp_path / "sheet.retopo").read_bytes() == kept and other.would_lose()
    assert other.known.refused.path == tmp_path / "sheet.retopo"
    # Whoever saved may go on.
    stroke(one, 2.0)
    one.obey("s")
    assert one.state.message.startswith("saved")


def test_a_session_is_reloaded_saved_elsewhere_or_overwritten(tmp_path: Path, two: Any) -> None:

    one, other = two
    path = tmp_path / "sheet.retopo"
    stroke(one, 1.0)
    stroke(other, -1.0)
    one.obey("s")
    other.obey("s")
    mine = other.state.network
    (way,) = other.save_ways()
    assert way.write(tmp_path / "mine.retopo").startswith("saved")
    assert are_equal(RETOPO_SESSION.read(tmp_path / "mine.retopo").state.network, mine)
    other.files.session_path = path
    other.reload(path)()
    other.ready()
    other.state.poll()
    assert are_equal(other.state.network, one.state.network) and not other.would_lose()
    stroke(other, -2.0)
    other.obey("s")
    assert other.state.message.startswith("saved")
    one.obey("s")
    assert one.state.message.startswith("not saved")
    one.known.note(path)
    one.obey("s")
    assert are_equal(RETOPO_SESSION.read(path).state.network, one.state.network)


def test_the_second_save_of_a_script_is_refused(tmp_path: Path, two: Any) -> None:
    one, other = two
    stroke(one, 1.0)
    stroke(other, -1.0)
    one.obey("S")
    kept = (tmp_path / "sheet.jsonl").read_text()
    other.obey("S")
    assert "overwrite it" in other.state.message
    assert (tmp_path / "sheet.jsonl").read_text() == kept
    # At the end nobody can be asked: both are kept.
    with pytest.raises(Exception, match=r"sheet-1\.jsonl"):
        other.end(discarded=True)
    assert (tmp_path / "sheet.jsonl").read_text() == kept
    assert "-1.0" in (tmp_path / "sheet-1.jsonl").read_text()


def test_what_a_crash_left_of_an_older_session_does_not_replace_it(
    tmp_path: Path, source: PatternSource
) -> None:
    path = tmp_path / "sheet.retopo"
    first = open_retopo(tmp_path, source)
    stroke(first, 1.0)
    first.obey("s")
    stroke(first, 2.0)
    first.files.autosave._at = -1e9
    first.files.tick(first.kept_work())
    (left,) = tmp_path.glob("*.recovery")
    first.files.autosave = None
    close(first)
    end = left.name.partition("-")[2]
    left.rename(left.with_name(f"sheet.retopo.999999999-{end}"))
    second = open_retopo(tmp_path, source)
    stroke(second, 3.0)
    second.obey("s")
    kept = path.read_bytes()
    close(second)
    third = open_retopo(tmp_path, source)
    third.find_lost_work().open()
    third.ready()
    third.state.poll()
    third.obey("s")
    assert third.state.message.startswith("not saved") and path.read_bytes() == kept
    third.known.note(path)
    third.obey("s")
    assert third.state.message.startswith("saved") and path.read_bytes() != kept
    assert not list(tmp_path.glob("*.recovery"))
    close(third)


def open_features(folder: Path) -> Any:
    from patterndb_sketch.features.files.curvefiles import FeatureFiles
    from patterndb_sketch.features.session import FEATURE_SESSION
    from tests.support.viewer.tents import opened
    from viewer.features.window import FeatureSaver

    path = folder / "tent.session"
    state = opened(FEATURE_SESSION.read(path)) if path.exists() else opened()
    files = FeatureFiles(folder, path)
    state.editing.files = files
    state.editing.watch("tent.obj")
    return FeatureSaver(state, files, SIZE)


def test_the_second_save_of_feature_curves_is_refused(tmp_path: Path) -> None:
    from tests.support.viewer.tents import picked

    one, other = open_features(tmp_path), open_features(tmp_path)
    for saver in (one, other):
        picked(saver.state)
        saver.state.settle()
    one.obey("s")
    kept = (tmp_path / "tent.session").read_bytes()
    other.state.editing.rename("another")
    other.obey("s")
    assert "overwrite it" in other.state.message and other.would_lose()
    assert (tmp_path / "tent.session").read_bytes() == kept
    other.reload(tmp_path / "tent.session")()
    other.ready()
    names = [[curve.name for curve in saver.state.editing.edits.curves] for saver in (one, other)]
    assert names[0] == names[1] and not other.would_lose()
    other.obey("s")
    assert other.state.message.startswith("saved")
    for saver in (one, other):
        saver.end(discarded=True)


Make = Callable[[Path], Saver]


def draw_and_wait(saver: Saver) -> None:
    draw_boundary(saver)
    saver.ready()


EXPORTS: dict[str, tuple[Make, Callable[[Any], object]]] = {
    "explore": (explorer, draw_and_wait),
    "surface": (surfacing, lambda saver: saver.ready()),
    "shape-model": (shapes, pull),
}


@pytest.mark.parametrize("name", EXPORTS)
def test_the_second_save_of_what_a_window_makes_is_refused(tmp_path: Path, name: str) -> None:
    make, do = EXPORTS[name]
    one, other = make(tmp_path), make(tmp_path)
    path = tmp_path / "car.obj"
    for saver in (one, other):
        do(saver)
    ways = [saver.save_ways()[0] for saver in (one, other)]
    if name != "shape-model":
        # Where no file is named at first, it is known from the first save on.
        ways[1].write(path)
    ways[0].write(path)
    path.write_text("of the first window")
    for way in ways:
        with pytest.raises(FileChangedError, match="overwrite it"):
            way.write(path)
    assert path.read_text() == "of the first window"
    other.known.note(path)
    ways[1].write(path)
    assert path.read_text() != "of the first window"
    for saver in (one, other):
        saver.end(discarded=True)
