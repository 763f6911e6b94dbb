"""What all windows have, on a real display: files dropped and opened, work found again after a
kill, colours, keys and the palette."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hands import Shown, end, read_within
from jobs import JOBS, draw_square
from six_windows import OPENING

DRAGGING = Path(__file__).with_name("dragging.py")


@contextmanager
def dragging(shown: Shown, path: Path) -> Iterator[None]:
    """Have a window of another program from which a file can be dragged."""
    process = subprocess.Popen(
        [sys.executable, str(DRAGGING), str(path)], env=shown.environment,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert read_within(os.dup(process.stdout.fileno())) == "shown"
        yield
    finally:
        end(process)


def drop(shown: Shown) -> None:
    """Drag from the other window into the middle of this one, and let go."""
    middle = shown.find_pixels(np.zeros((1, 2)))[0]
    # The programs answer each other between two moves.
    words: list[object] = ["mousemove", 20, 12, "sleep", 0.2, "mousedown", 1, "sleep", 0.3]
    for part in (0.05, 0.3, 0.6, 0.9, 1.0, 1.01):
        words += ["mousemove", *np.round(part * middle).astype(int), "sleep", 0.15]
    shown.do(*words, "sleep", 0.3, "mouseup", 1)


@pytest.mark.parametrize("name", JOBS)
def test_a_file_is_dropped(shown: Shown, name: str) -> None:
    shown.open(name)
    path = shown.folder / "another.obj"
    path.touch()
    before = shown.tell("id(window.saver.state)")
    with dragging(shown, path):
        drop(shown)
        if name not in OPENING:
            assert shown.tell("id(window.saver.state)") == before
            assert shown.tell("window.saver.state.message") == ""
            return
        shown.until(f"id(window.saver.state) != {before}")
    assert shown.tell("window.windowTitle()").startswith("another.obj")
    assert shown.tell("[path.name for path in window.settings.recent_files(window.saver.kind)]")


@pytest.mark.parametrize("name", OPENING)
def test_a_file_is_opened_by_name(shown: Shown, name: str) -> None:
    job = JOBS[name]
    shown.open(name)
    good, bad = shown.folder / "good.obj", shown.folder / "bad.obj"
    for path in (good, bad):
        path.touch()
    job.do(shown)
    shown.until(job.done)
    before = shown.tell("id(window.saver.state)")

    def open_by_dialog(path: Path, answer: str) -> None:
        shown.keys("ctrl+o")
        shown.name_file(path, asked=bool(job.file))
        if job.file:
            # What is not saved is asked about first.
            shown.press_button(answer)

    if job.file:
        open_by_dialog(good, "Cancel")
        assert shown.tell("id(window.saver.state)") == before and shown.tell(job.done)
    # Another file than it must be changes nothing.
    open_by_dialog(bad, "Discard")
    shown.until("'no such file' in state.message")
    assert shown.tell("id(window.saver.state)") == before and shown.tell(job.done)
    open_by_dialog(good, "Discard")
    shown.until(f"id(window.saver.state) != {before}")
    assert not shown.tell("window.saver.would_lose()")
    # All of the window goes by what is shown now.
    shown.tell("globals().update(state=window.saver.state)")
    shown.until("window.isActiveWindow()")
    job.do(shown)
    shown.until(job.done)


#: Keeps what is drawn in case of a crash, as the program does, without waiting half a minute.
KEEP = """
from patterndb_sketch.retopo.autosave import Autosave
editing = window.saver.state.editing
editing.files._autosave = Autosave(
    editing.ground, editing.shown.state, session=editing.files.session_path,
    name='sheet.obj', every=0.0,
)
"""

#: What is drawn, as it can be compared.
DRAWN = (
    "[(n, c.count, c.points.tolist(), c.normals.tolist()) "
    "for n, c in sorted(state.network.chains.items())]"
)


def test_work_is_found_after_a_kill(
    display: dict[str, str], tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    first = Shown(display, tmp_path)
    try:
        first.open("retopo")
        first.tell(f"exec({KEEP!r}, globals())")
        draw_square(first)
        first.until("len(state.shown.body.mesh.quads) > 3 and not state.editing.waiting")
        drawn, quads = first.tell(DRAWN), first.tell("len(state.shown.body.mesh.quads)")
        (left,) = first.until(
            f"[str(p) for p in __import__('pathlib').Path({str(tmp_path)!r}).glob('*.recovery')]"
        )
        size = -1
        while size != (size := Path(left).stat().st_size):
            first.until("not state.editing.tick()")
    finally:
        first.process.kill()
        first.process.wait()
    second = Shown(display, tmp_path_factory.mktemp("again"))
    second.folder = tmp_path
    try:
        second.open("retopo")
        ask = (
            "setattr(state, 'message', window.saver.files.find_lost(state.ground, "
            f"__import__('pathlib').Path({str(tmp_path)!r})))"
        )
        second.tell(ask)
        second.tell("QTimer.singleShot(0, window.offer_lost_work)")
        second.press_button("Open it")
        second.until("len(state.network.chains) > 4 and not state.editing.waiting")
        assert second.tell(DRAWN) == drawn
        second.until(f"len(state.shown.body.mesh.quads) == {quads}")
        # It is not saved yet; once it is, nothing is left of it.
        assert second.tell("bool(window.saver.would_lose())") and Path(left).exists()
        second.keys("ctrl+s")
        second.until("not window.saver.would_lose()")
        assert not Path(left).exists() and (tmp_path / "sheet.retopo").stat().st_size > 0
        second.close_by_manager()
        second.until("not window.isVisible()")
        second.finish()
    finally:
        end(second.process)


@pytest.mark.parametrize("name", JOBS)
def test_colours_change_while_a_window_is_open(shown: Shown, name: str) -> None:
    shown.open(name)
    JOBS[name].do(shown)
    shown.until(JOBS[name].done)
    # What is in the corner of the window, and of its picture.
    seen = (
        "(lambda i, p: (i.pixelColor(3, 3).lightness(), i.pixelColor(p.x(), p.y()).lightness()))"
        "(app.primaryScreen().grabWindow(window.winId()).toImage(),"
        " window.picture.mapTo(window, window.picture.rect().topRight()) - QPoint(8, -8))"
    )
    found = {}
    for theme in ("light", "dark", "light"):
        shown.keys("ctrl+comma")
        shown.until("isinstance(app.activeModalWidget(), PreferencesDialog)")
        shown.until("app.activeModalWidget().isActiveWindow()")
        # By the keyboard, as far as the list of colours has it.
        shown.until("app.activeModalWidget().theme.hasFocus()")
        shown.keys(theme[0])
        shown.until(f"window.settings.theme == {theme!r}")
        shown.keys("Escape")
        shown.until("app.activeModalWidget() is None and window.isActiveWindow()")
        light = theme == "light"
        shown.until(f"({seen}[0] > 128) == {light}")
        found.setdefault(theme, shown.tell(seen))
    assert found["light"][1] > found["dark"][1], "the picture too"
    assert shown.tell(JOBS[name].done)


def test_a_key_that_was_chosen_is_kept(
    display: dict[str, str], shown: Shown, tmp_path_factory: pytest.TempPathFactory
) -> None:
    shown.open("browse")
    shown.keys("ctrl+comma")
    shown.until("isinstance(app.activeModalWidget(), PreferencesDialog)")
    shown.until("app.activeModalWidget().isActiveWindow()")
    row = shown.tell("list(window.table.bound).index('mirror')")
    shown.tell(f"[app.activeModalWidget().keys.selectRow({row}),"
               " app.activeModalWidget().edit.setFocus()] and 0")  # fmt: skip
    shown.keys("ctrl+j")
    shown.until("app.activeModalWidget().edit.keySequence().toString() == 'Ctrl+J'")
    # Tab goes on to the button that takes it.
    shown.tell("app.activeModalWidget().use.setFocus()")
    shown.keys("space")
    shown.until("window.settings.shortcuts('browse') == {'mirror': 'Ctrl+J'}")
    shown.keys("Escape")
    shown.until("app.activeModalWidget() is None and window.isActiveWindow()")
    shown.keys("ctrl+j")
    shown.until("state.mirrored")
    shown.keys("m")
    assert shown.tell("state.mirrored"), "its own key is free"
    shown.close_by_manager()
    shown.until("not window.isVisible()")
    # In another process, with the same settings.
    again = Shown(display, shown.home)
    try:
        again.open("browse")
        again.keys("ctrl+j")
        again.until("state.mirrored")
        again.tell("window.table.choose_shortcut('mirror', None)")
        again.keys("m")
        again.until("not state.mirrored")
        again.close_by_manager()
        again.until("not window.isVisible()")
        again.finish()
    finally:
        end(again.process)


def test_the_keyboard_reaches_all_of_a_dialog(shown: Shown) -> None:
    shown.open("browse")
    shown.keys("ctrl+comma")
    shown.until("isinstance(app.activeModalWidget(), PreferencesDialog)")
    shown.until("app.activeModalWidget().isActiveWindow()")
    focus = "id(app.focusWidget())"
    begun, reached = shown.tell(focus), []
    for _ in range(40):
        reached.append(shown.tell("type(app.focusWidget()).__name__"))
        shown.keys("Tab")
        if shown.tell(focus) == begun:
            break
    assert shown.tell(focus) == begun, reached
    assert {"QComboBox", "QTableWidget", "QPushButton"} <= set(reached)
    assert reached.count("QComboBox") == 2 and reached.count("QPushButton") == 4
    shown.keys("Escape")
    shown.until("app.activeModalWidget() is None")


@pytest.mark.parametrize("name", JOBS)
def test_the_palette_does_what_is_typed(shown: Shown, name: str) -> None:
    shown.open(name)
    shown.keys("ctrl+p")
    shown.until("app.activeModalWidget() is not None and app.activeModalWidget().isActiveWindow()")
    shown.do("type", "preferences")
    shown.keys("Return")
    shown.until("isinstance(app.activeModalWidget(), PreferencesDialog)")
    shown.until("app.activeModalWidget().isActiveWindow()")
    shown.keys("Escape")
    shown.until("app.activeModalWidget() is None")
    assert shown.tell("state.message") == ""
