"""What this process has compiled, and a clock that stands still meanwhile.

Kernels that are not there yet are compiled in the middle of whatever first needs them. This says
how many were and how long it took, lets the command line tell and compile ahead, and keeps it
out of the times that are reported. No compiler is imported here.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

_log = logging.getLogger("patterndb")

#: Seconds of compiling after which a program that does not tell of it itself is told.
PATIENCE = 1.0


@dataclass(slots=True)
class CompileLog:
    """What has been compiled so far.

    kernels: compiled by this process, those that others call included. seconds: of the clock on
    the wall, spent on that and on waiting for other processes that compile. watcher: called when
    compiling begins (True) and ends (False). ahead: called before a kernel that is not there is
    compiled; it may have others compile it. It says whether to be called for the next one, too.
    """

    kernels: int = 0
    seconds: float = 0.0
    watcher: Callable[[bool], None] | None = None
    ahead: Callable[[], bool] | None = None
    _depth: int = 0
    _since: float = 0.0
    _told: bool = False
    _lock: threading.RLock = field(default_factory=threading.RLock)

    def is_compiling(self) -> bool:
        """Is something being compiled at this moment?"""
        return self._depth > 0

    def begin(self) -> None:
        """Note that something begins to be compiled; what is begun meanwhile is part of it."""
        with self._lock:
            self._depth += 1
            if self._depth == 1:
                self._since = time.perf_counter()
                if self.watcher is not None:
                    self.watcher(True)

    def end(self, kernels: int) -> None:
        """Note that it has ended, and how many kernels it made."""
        with self._lock:
            self.kernels += kernels
            self._depth -= 1
            if self._depth == 0:
                self.seconds += time.perf_counter() - self._since
                if self.watcher is not None:
                    self.watcher(False)
                elif not self._told and self.seconds > PATIENCE:
                    self._told = True
                    _log.warning(
                        "patterndb is compiling kernels, once: they are kept for later runs; "
                        "'patterndb warmup' compiles all that a verb needs ahead"
                    )

    def compile_ahead(self) -> bool:
        """Call ``ahead``, if it has not said that it is done; return whether it was called."""
        ahead, self.ahead = self.ahead, None
        if ahead is None:
            return False
        self.begin()
        try:
            if ahead():
                self.ahead = ahead
        finally:
            self.end(0)
        return True

    def count_seconds(self) -> float:
        """Seconds spent so far, those of what is being compiled at this moment included."""
        with self._lock:
            return self.seconds + (time.perf_counter() - self._since if self._depth else 0.0)

    def read_clock(self) -> float:
        """Seconds of a clock that stands still while something is compiled."""
        with self._lock:
            return (self._since if self._depth else time.perf_counter()) - self.seconds


#: Of this process.
COMPILED = CompileLog()


def read_work_clock() -> float:
    """Seconds of a clock that stands still while kernels are compiled."""
    return COMPILED.read_clock()
