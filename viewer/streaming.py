"""Fills that arrive while something else goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable

from patterndb.core.patternclass import PatternClass
from query import Fill, Fills
from query.engine import PatternSource


class OneAtATime:
    """A source of patterns that several threads may ask: a database serves one at a time."""

    def __init__(self, source: PatternSource) -> None:
        self._source = source
        self._lock = threading.Lock()

    def pattern_class(self, n_sides: int) -> PatternClass:
        """As the source's."""
        with self._lock:
            return self._source.pattern_class(n_sides)


class Search:
    """A query that runs in a thread of its own.

    ask: makes the query; it is called in the thread, too, as patterns may have to be read.
    fills: those found so far, best first; it only grows. done: has it ended? failure: what it
    was ended by, if it failed. reason: why there is no fill, once it has ended without one.
    """

    def __init__(self, ask: Callable[[], Fills]) -> None:
        self.fills: list[Fill] = []
        self.done = False
        self.failure: Exception | None = None
        self.reason: str | None = None
        self.truncated = False
        self._ask = ask
        self._asked: Fills | None = None
        self._cancelled = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="fills", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """End it soon; does not wait."""
        with self._changed:
            self._cancelled = True
            if self._asked is not None:
                self._asked.cancel()

    def wait(self, count: int | None = None, timeout: float | None = None) -> bool:
        """Until there are so many fills, or it has ended; False if time ran out before."""

        def reached() -> bool:
            return self.done or (count is not None and len(self.fills) >= count)

        with self._changed:
            return self._changed.wait_for(reached, timeout)

    def join(self) -> None:
        """Until the thread has ended: then nothing of the database is in use any more."""
        self._thread.join()

    def _run(self) -> None:
        try:
            self._stream()
        except Exception as error:
            # Raised here it would be lost; whoever waits for fills raises it.
            self.failure = error
        finally:
            with self._changed:
                self.done = True
                self._changed.notify_all()

    def _stream(self) -> None:
        if self._cancelled:
            return
        asked = self._ask()
        with self._changed:
            self._asked = asked
            if self._cancelled:
                return
        for fill in asked:
            with self._changed:
                self.fills.append(fill)
                self._changed.notify_all()
        self.truncated = asked.truncated
        if not self._cancelled:
            self.reason = asked.reason
