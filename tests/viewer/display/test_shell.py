"""What all windows have, on a real display: files that are dropped and opened."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from tests.support.display.hands import Shown, end, read_within
from tests.support.display.jobs import JOBS
from tests.support.display.six_windows import OPENING
from tests.support.shared import CHECKOUT

DRAGGING = CHECKOUT / "tests" / "support" / "display" / "dragging.py"


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
    shown.until("app.activeModalWidget() is None and window.isActiveWindow()")
    # The window manager may still be raising it, and clicks would go to what lies above.
    shown.do("sleep", 0.5)
    job.do(shown)
    shown.until(job.done)
