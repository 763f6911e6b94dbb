"""One line of talk that changes: what a verb waits for, on a terminal and in a file."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable

from patterndb_app.cli.text import say

#: Seconds between two states of the line on a terminal, where it is written over.
ON_TERMINAL = 0.25
#: Seconds between two lines where there is no terminal: nobody waits longer without a word.
IN_FILE = 1.5


class ProgressLine:
    """A line that ``text`` words anew until :meth:`close`; what ends within a moment is not told.

    On a terminal it is rewritten and goes away in the end; elsewhere it is a line every
    IN_FILE seconds. text: called on a thread of its own; None where there is nothing to tell.
    """

    def __init__(self, text: Callable[[], str | None]) -> None:
        self._text = text
        # There is no stderr at all where the shell closed it (2>&-).
        self._terminal = sys.stderr is not None and sys.stderr.isatty()  # pyright: ignore[reportUnnecessaryComparison]
        self._shown = ""
        self._over = threading.Event()
        self._lock = threading.Lock()
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
                    self._write(f"\r\x1b[K{text}")
                    self._shown = text
                elif time.monotonic() - last >= IN_FILE:
                    last = time.monotonic()
                    say(text)

    def close(self) -> None:
        """Take the line away."""
        with self._lock:
            self._over.set()
            self._erase()
        self._thread.join()

    def _erase(self) -> None:
        if self._shown:
            self._write("\r\x1b[K")
            self._shown = ""

    def _write(self, text: str) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text)
            sys.stderr.flush()
