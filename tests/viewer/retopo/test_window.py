"""The window of retopology: files, and simulated events."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.recovery import find_recoveries
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.files import RetopoFiles
from patterndb_sketch.retopo.filling import RetopoMesh, weld_patches
from patterndb_sketch.retopo.network import are_equal
from patterndb_sketch.retopo.script import Script, play_script, read_script
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession, autosave_session
from query.engine import PatternSource
from tests.support.viewer.events import read
from tests.support.viewer.sheets import drag, keys, opened, sheet, square, tube
from viewer.keymap import Effect
from viewer.retopo import RetopoState, show
from viewer.retopo.keys import KEYS
from viewer.retopo.window import RetopoSaver

SIZE = (720, 450)


def writer(folder: Path, **paths: Path) -> RetopoFiles:
    def write_mesh(path: Path, mesh: RetopoMesh) -> None:
        path.write_text(f"{len(mesh.quads)} quads")

    session, script = paths.get("session"), paths.get("script")
    return RetopoFiles(folder, session, script, Script("sheet.obj", ()), write_mesh)


def test_everything_is_saved(tmp_path: Path, state: RetopoState, source: PatternSource) -> None:
    files = writer(tmp_path)
    state.editing.files = files
    saver = RetopoSaver(state, files, SIZE)
    assert saver.play(["o", "S"]) is Effect.NOTHING
    assert "nothing has been done" in state.message and not list(tmp_path.iterdir())
    square(state)
    assert state.editing.unsaved
    saver.play(["s", "p", "o", "S", "s"])
    assert state.message == f"saved {tmp_path / 'retopo-1.retopo'}" and not state.editing.unsaved
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["quads-1.obj", "retopo-1.jsonl", "retopo-1.png", "retopo-1.retopo"]
    kept = RETOPO_SESSION.read(tmp_path / "retopo-1.retopo")
    assert are_equal(kept.state.network, state.network) and kept.name == "sheet.obj"
    quads = len(state.shown.body.mesh.quads)
    assert (tmp_path / "quads-1.obj").read_text() == f"{quads} quads"
    script = read_script(tmp_path / "retopo-1.jsonl")
    assert script.surface == "sheet.obj"
    again = Retopology(sheet(), source)
    assert len(list(play_script(script, again, lambda _path, _found: None))) == 4
    assert np.array_equal(weld_patches(again.fill()).vertices, state.shown.body.mesh.vertices)
    assert read(tmp_path / "retopo-1.png").shape[:2] == (SIZE[1], SIZE[0])
    lost = writer(tmp_path / "no")
    state.editing.files = lost
    for key in "spSo":
        state.message = ""
        RetopoSaver(state, lost, SIZE).obey(key)
        assert state.message.startswith("not saved: "), key
    state.editing.files = None
    for key in "sSo":
        state.message = ""
        KEYS.press(state, key)
        assert "cannot be saved here" in state.message


def test_sessions_and_scripts_go_into_the_files_that_were_named(
    tmp_path: Path, state: RetopoState
) -> None:
    paths = {"session": tmp_path / "mine.zip", "script": tmp_path / "mine.jsonl"}
    paths["session"].write_bytes(b"older")
    state.editing.files = writer(tmp_path, **paths)
    square(state)
    RetopoSaver(state, writer(tmp_path), SIZE).play(["s", "S", "s", "S"])
    assert sorted(tmp_path.iterdir()) == sorted(paths.values())
    assert len(RETOPO_SESSION.read(paths["session"]).state.network.patches) == 1


def test_a_crash_would_lose_half_a_minute(tmp_path: Path, state: RetopoState) -> None:
    now = [0.0]
    autosave = autosave_session(
        RetopoSession(state.surface, state.shown.state), folder=tmp_path, clock=lambda: now[0]
    )
    state.editing.files = RetopoFiles(tmp_path, None, None, Script("sheet.obj", ()), None, autosave)
    square(state)
    state.poll()
    assert list(tmp_path.iterdir()) == []
    now[0] = 31.0
    state.poll()
    (kept,) = tmp_path.iterdir()
    assert are_equal(RETOPO_SESSION.read(kept).state.network, state.network)
    state.editing.save_session()
    assert [path.name for path in tmp_path.iterdir()] == ["retopo-1.retopo"]
    state.editing.undo()
    state.settle()
    now[0] = 62.0
    autosave.path = tmp_path / "no" / "where"
    assert state.poll() and state.message.startswith("nothing is kept in case of a crash")


def test_a_window_leaves_a_script_and_no_recovery_file(
    tmp_path: Path, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A window draws a square, and ends as it is told to."""
    failures: list[BaseException] = []

    def run(saver: RetopoSaver, pressed: object, *_: object) -> RetopoSaver:
        ended = bool(failures)
        try:
            return draw_in(saver, pressed)
        finally:
            # As the shell does: Ctrl-C does not ask what to do with the work.
            saver.end(discarded=not ended)

    def draw_in(saver: RetopoSaver, pressed: object) -> RetopoSaver:
        saver.play(list(pressed))  # type: ignore[call-overload]
        saver.drawn()
        KEYS.press(saver.state, "3")
        square(saver.state)
        saver.state.poll()
        kept = [path for path in tmp_path.iterdir() if path.suffix == ".recovery"]
        assert len(kept) == 1
        if failures:
            raise failures.pop()
        return saver

    monkeypatch.setattr("viewer.shell.opening.open_window", run)
    monkeypatch.setattr("viewer.shell.probe.check_display", lambda: None)
    monkeypatch.setattr(
        "viewer.retopo.window.autosave_session",
        lambda *a, **k: autosave_session(*a, **(k | {"every": 0.0})),
    )
    editor, script = Retopology(sheet(), source), tmp_path / "done.jsonl"
    show(
        editor,
        title="sheet",
        script=script,
        begun=Script("sheet.obj", ()),
        folder=tmp_path,
        keys="i",
    )
    assert [path.name for path in tmp_path.iterdir()] == ["done.jsonl"]
    assert [line.call.tool for line in read_script(script).lines] == ["stroke"] * 4
    script.unlink()
    # A window that is closed has asked what to do with the work: then nothing is left of it.
    show(Retopology(sheet(), source), folder=tmp_path)
    assert not list(tmp_path.iterdir())
    for failure in (KeyboardInterrupt(), ZeroDivisionError()):
        failures.append(failure)
        with pytest.raises(type(failure)):
            show(Retopology(sheet(), source), folder=tmp_path)
        (kept,) = tmp_path.iterdir()
        assert kept.suffix == ".recovery", "only an end that was asked for takes it away"
        assert len(RETOPO_SESSION.read(kept).state.network.chains) == 5, (
            "the border and four strokes"
        )
        assert [one.path for one in find_recoveries(folder=tmp_path)] == [kept]
        kept.unlink()
    with pytest.raises(ValueError, match="no key"):
        show(editor, keys="zz")


def left(folder: Path, source: PatternSource, name: str = "unnamed") -> tuple[Path, Retopology]:
    """What a window left that was killed after a square was drawn, and its editor."""
    state = opened(source)
    square(state)
    editor, now = Retopology(sheet(), source), state.shown.state
    state.close()
    path = folder / f"{name}.999999999-abc.recovery"
    RETOPO_SESSION.write(path, RetopoSession(sheet(), now, "sheet.obj"))
    editor.restore(now)
    return path, editor


def test_what_a_crash_left_is_opened_by_a_key_and_goes_when_it_is_saved(
    tmp_path: Path, state: RetopoState, source: PatternSource
) -> None:
    keys(state, "R")
    assert state.message == "there is nothing that a crash left"
    path, editor = left(tmp_path, source)
    files = writer(tmp_path)
    state.editing.files = files
    assert files.find_lost(state.surface).endswith("R opens it in place of what is here")
    # After something else was done it would be lost.
    keys(state, "d")
    drag(state, (-3.0, 3.0), (3.0, 3.0))
    keys(state, "R")
    assert "undo what has been done first" in state.message and path.exists()
    assert len(state.network.patches) == 0
    keys(state, "u R")
    assert are_equal(state.network, editor.fill().network) and len(state.shown.body.mesh.quads) > 0
    assert state.editing.unsaved and not state.shown.undoable and path.exists()
    keys(state, "S")
    assert "did not begin from the bare surface" in state.message
    keys(state, "R")
    assert state.message == "there is nothing that a crash left"
    keys(state, "s")
    assert not path.exists(), "it is saved now"
    assert are_equal(RETOPO_SESSION.read(tmp_path / "retopo-1.retopo").state.network, state.network)
    keys(state, "s")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["retopo-1.retopo"]


def test_what_a_crash_left_and_cannot_be_opened_stays(
    tmp_path: Path, state: RetopoState, source: PatternSource
) -> None:
    files = writer(tmp_path)
    assert files.find_lost(state.surface) == ""
    path, _ = left(tmp_path, source)
    assert "of another surface, sheet.obj; rename it" in files.find_lost(tube())
    path.write_bytes(b"no session")
    said = files.find_lost(state.surface)
    assert said.startswith(f"a crash left {path.name}, which cannot be read: ")
    assert files.lost is None
    state.editing.files = files
    square(state)
    keys(state, "s")
    assert path.exists()
    # What was found and not opened stays, too.
    state.editing.files = files = writer(tmp_path)
    RETOPO_SESSION.write(path, RetopoSession(sheet(), state.shown.state, ""))
    assert "R opens it" in files.find_lost(state.surface) and files.lost is not None
    keys(state, "s")
    assert path.exists()
