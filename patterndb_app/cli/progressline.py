"""One line of talk that changes: what a verb waits for, on a terminal and in a file."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable, Generator

from patterndb.system.progress import describe_progress
from patterndb_app.cli.text import LAST_WORD, say

#: Seconds between two states of the line on a terminal, where it is written over.
ON_TERMINAL = 0.25
#: Seconds between two lines where there is no terminal: nobody waits longer without a word.
IN_FILE = 1.5
#: Seconds without a word after which a terminal is told that there is work going on.
SILENCE = 1.5


class ProgressLine:
    """A line that ``text`` words anew until :meth:`close`; what ends within a moment is not told.

    On a terminal it is rewritten and goes away in the end; elsewhere it is a line every
    IN_FILE seconds. text: called on a thread of its own; None where there is nothing to tell.
    """

    def __init__(self, text: Callable[[], str | None]) -> None:
        self._text = text
        self._terminal = is_terminal()
        self._shown = ""
        self._over = threading.Event()
        # What is said in a file by this line's own thread makes way for itself.
        self._lock = threading.RLock()
        LAST_WORD.clear.append(self._make_way)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        last = time.monotonic()
        while not self._over.wait(ON_TERMINAL):
            text = self._text()
            with self._lock:
                if self._over.is_set():
                    return
                if text is None:
                    self._erase()
                    # Work and waiting may take turns: only a wait of some length is told.
                    continue
                if self._terminal:
                    # A line that wraps could not be taken away.
                    text = text[: count_columns() - 1]
                    self._write(f"\r\x1b[K{text}")
                    self._shown = text
                    self.note_shown()
                elif time.monotonic() - last >= IN_FILE:
                    last = time.monotonic()
                    say(text)

    def close(self) -> None:
        """Take the line away."""
        with self._lock:
            self._over.set()
            self._erase()
        self._thread.join()
        LAST_WORD.clear.remove(self._make_way)

    def _make_way(self) -> None:
        with self._lock:
            self._erase()

    def note_shown(self) -> None:
        """Note that the terminal says something."""
        LAST_WORD.at = time.monotonic()

    def _erase(self) -> None:
        if self._shown:
            self._write("\r\x1b[K")
            self._shown = ""

    def _write(self, text: str) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text)
            sys.stderr.flush()


def is_terminal() -> bool:
    """Is there somebody who sees stderr as it is written?"""
    # There is no stderr at all where the shell closed it (2>&-).
    return sys.stderr is not None and sys.stderr.isatty()  # pyright: ignore[reportUnnecessaryComparison]


def tell_share(share: float, seconds: float) -> str:
    """Say how much is done and how long the rest takes, if it goes on as in ``seconds`` so far."""
    share = min(max(share, 0.0), 1.0)
    if share == 0:
        return "0%"
    minutes, left = divmod(round(seconds * (1 - share) / share), 60)
    return f"{share:.0%}, {minutes}:{left:02} left"


@contextlib.contextmanager
def told_share(task: str) -> Generator[Callable[[int, int], None] | None]:
    """Tell a terminal, within the block, how much of a task is done; None where there is none.

    What is yielded takes how much is done, and of how much.
    """
    if not is_terminal():
        yield None
        return
    began, share = time.monotonic(), 0.0

    def update(done: int, total: int) -> None:
        nonlocal share
        share = done / max(total, 1)

    line = ProgressLine(lambda: f"{task}: {tell_share(share, time.monotonic() - began)}")
    try:
        yield update
    finally:
        line.close()


def count_columns() -> int:
    """How many characters fit on a line of the terminal behind stderr; 80 where that is unknown."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


class WaitingLine(ProgressLine):
    """The line that a terminal sees while a verb works and says nothing: its name and how long."""

    #: Is somebody else on the terminal's line, or is the verb waiting for a person?
    hushed = False

    def __init__(self, name_verb: Callable[[], str | None]) -> None:
        self._name_verb = name_verb
        self._began = LAST_WORD.at = time.monotonic()
        super().__init__(self._word)

    def _word(self) -> str | None:
        now = time.monotonic()
        if WaitingLine.hushed or now - LAST_WORD.at < SILENCE:
            return None
        word = f"{self._name_verb() or 'patterndb'}: at work, {now - self._began:.0f} s"
        running = describe_progress()
        return word if running is None else f"{word}; {running}"

    def note_shown(self) -> None:
        """Note nothing: the silence goes on."""


@contextlib.contextmanager
def told_waiting(name_verb: Callable[[], str | None]) -> Generator[None]:
    """Tell a terminal, within the block, that a verb is at work while it says nothing itself.

    name_verb: asked for the verb's name.
    """
    if not is_terminal():
        yield
        return
    line = WaitingLine(name_verb)
    try:
        yield
    finally:
        line.close()


@contextlib.contextmanager
def hushed() -> Generator[None]:
    """Tell nothing of waiting within the block: a window is open, or a bar shows what is done."""
    before, WaitingLine.hushed = WaitingLine.hushed, True
    try:
        yield
    finally:
        WaitingLine.hushed = before
        LAST_WORD.at = time.monotonic()
