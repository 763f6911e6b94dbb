"""What a terminal sees while a verb says nothing itself."""

from __future__ import annotations

import io
import re
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager

import pytest

from patterndb_app.cli import progressline
from patterndb_app.cli.progressline import hushed, tell_share, told_share, told_waiting
from patterndb_app.cli.text import LAST_WORD, say


class Terminal(io.StringIO):
    """A stderr that somebody looks at."""

    def isatty(self) -> bool:
        return True

    def seen(self) -> str:
        """What stands there in the end, line by line."""
        return "\n".join(re.sub(r".*\x1b\[K", "", line) for line in self.getvalue().split("\n"))


@contextmanager
def stderr_as(made: io.StringIO) -> Generator[None]:
    """Write stderr to ``made``, and be patient for a moment alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stderr", made)
        patch.setattr(progressline, "SILENCE", 0.05)
        patch.setattr(progressline, "ON_TERMINAL", 0.01)
        yield
    assert not LAST_WORD.clear


def wait_for(terminal: Terminal, text: str) -> None:
    """Wait, a few seconds at most, for a terminal to show a text."""
    end = time.monotonic() + 10
    while text not in terminal.getvalue():
        assert time.monotonic() < end, terminal.getvalue()
        time.sleep(0.005)


def test_silence_is_filled_and_nothing_of_it_stays() -> None:
    terminal = Terminal()
    with stderr_as(terminal), told_waiting(lambda: "holes"):
        wait_for(terminal, "holes: at work, 0 s")
        say("read: head.obj")
        wait_for(terminal, "read: head.obj\n\r\x1b[Kholes: at work")
    assert terminal.seen() == "read: head.obj\n"


def test_windows_and_bars_hush_it() -> None:
    terminal = Terminal()
    with stderr_as(terminal), told_waiting(lambda: "holes"), hushed():
        time.sleep(0.3)
    assert terminal.getvalue() == ""


def test_files_are_told_nothing() -> None:
    written = io.StringIO()
    with stderr_as(written), told_waiting(lambda: "holes"):
        time.sleep(0.3)
    assert written.getvalue() == ""


def test_how_much_is_done_goes_away_at_the_end() -> None:
    terminal = Terminal()
    with stderr_as(terminal), told_share("writing") as progress:
        assert progress is not None
        wait_for(terminal, "writing: 0%")
        progress(3, 4)
        wait_for(terminal, "writing: 75%, 0:0")
    assert terminal.seen() == ""


def test_a_file_is_not_told_how_much_is_done() -> None:
    written = io.StringIO()
    with stderr_as(written), told_share("writing") as progress:
        assert progress is None
    assert written.getvalue() == ""


@pytest.mark.parametrize(
    ("share", "seconds", "text"),
    [
        (0.0, 3.0, "0%"),
        (0.25, 60.0, "25%, 3:00 left"),
        (0.5, 9.0, "50%, 0:09 left"),
        (1.0, 7.0, "100%, 0:00 left"),
        (1.5, 7.0, "100%, 0:00 left"),
    ],
)
def test_the_rest_is_told_as_what_was(share: float, seconds: float, text: str) -> None:
    assert tell_share(share, seconds) == text


def test_a_line_keeps_to_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progressline, "count_columns", lambda: 20)
    terminal = Terminal()
    with stderr_as(terminal), told_share("a task of many words, each long"):
        wait_for(terminal, "a task of many word")
    assert "words" not in terminal.getvalue()
