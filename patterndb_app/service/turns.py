"""Turns: which of the threads at work goes on, so that who has nothing yet has something soon.

Python runs one thread at a time, and eight that search at once each take eight times as long, the
first line of a fresh question too. So a question runs at once until its first line, all others
pause for it between two of theirs, and of these a few go on at a time, for some milliseconds each.
Nobody pauses for long: what a turn is waited for may be a search of seconds.
"""

from __future__ import annotations

import threading
import time
from collections import deque

#: Seconds of a turn, unless a fresh question comes: most lists are done within it.
TURN_SECONDS = 0.01

#: Seconds after which a thread goes on without a turn.
PATIENCE_SECONDS = 0.05


class Turns:
    """Takes turns among threads; each calls begin, pause between its lines, and end."""

    def __init__(self, at_once: int) -> None:
        """at_once: threads that go on at the same time, beside those without a first line."""
        self._at_once = at_once
        self._lock = threading.Lock()
        self._fresh = 0
        self._going = 0
        self._queue: deque[threading.Event] = deque()
        self._mine = threading.local()

    def begin(self) -> None:
        """Begin without waiting: nothing is told yet."""
        with self._lock:
            self._fresh += 1
        self._mine.since = None

    def pause(self) -> None:
        """Let others go on first where it is their turn; called after every line."""
        since: float | None = self._mine.since
        if since is not None and not self._fresh and time.perf_counter() < since + TURN_SECONDS:
            return
        with self._lock:
            self._leave()
            if not self._fresh and not self._queue and self._going < self._at_once:
                self._going += 1
                called = None
            else:
                called = threading.Event()
                self._queue.append(called)
                self._call()
        if called is not None and not called.wait(PATIENCE_SECONDS):
            with self._lock:
                # It may have been called at this very moment, and is counted then.
                if not called.is_set():
                    self._queue.remove(called)
                    self._going += 1
        self._mine.since = time.perf_counter()

    def end(self) -> None:
        """End, wherever it is: with or without a line."""
        with self._lock:
            self._leave()
            self._call()

    def _leave(self) -> None:
        if self._mine.since is None:
            self._fresh -= 1
        else:
            self._going -= 1

    def _call(self) -> None:
        """Call those whose turn it is."""
        while self._queue and not self._fresh and self._going < self._at_once:
            self._going += 1
            self._queue.popleft().set()
