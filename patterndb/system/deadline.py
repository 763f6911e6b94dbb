"""A thread's deadline: what may take long looks whether it is late, whoever set it.

A query has a time limit, and the database that it asks knows no queries. So the limit is the
thread's: ``end_by`` sets it around a call, and whatever runs below asks ``is_late``. The clock
stands still while kernels are compiled (:mod:`patterndb.system.compiling`).
"""

from __future__ import annotations

import heapq
import math
import os
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from itertools import count

from patterndb.system.compiling import read_work_clock

_of_thread = threading.local()


@contextmanager
def end_by(moment: float) -> Generator[None]:
    """Let what this thread does within the block end at a moment of the work clock.

    A deadline that is there already and is earlier stays.
    """
    before = get_deadline()
    _of_thread.moment = min(before, moment)
    try:
        yield
    finally:
        _of_thread.moment = before


def get_deadline() -> float:
    """Return this thread's deadline on the work clock; infinity where there is none."""
    return getattr(_of_thread, "moment", math.inf)


def is_late() -> bool:
    """Is this thread's deadline past?"""
    moment = get_deadline()
    return moment < math.inf and read_work_clock() >= moment


class Alarm:
    """Has a function called when the work clock comes to a moment, unless it is called off.

    For kernels, which look at nothing but a flag that someone must set. ``ring`` is called in the
    one thread that waits for all alarms, so it must do no more than that.
    """

    def __init__(self, moment: float, ring: Callable[[], None]) -> None:
        self._ring: Callable[[], None] | None = ring
        _WATCH.add(moment, self)

    def call_off(self) -> None:
        """Let it not ring, if it has not yet."""
        self._ring = None

    def ring(self) -> None:
        """Call the function, once."""
        ring, self._ring = self._ring, None
        if ring is not None:
            ring()


class _Watch:
    """The thread that waits for all alarms of the process; begun with the first."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew: a forked process has neither the thread nor who set the alarms."""
        self._changed = threading.Condition()
        self._alarms: list[tuple[float, int, Alarm]] = []
        self._number = count()
        self._thread: threading.Thread | None = None

    def add(self, moment: float, alarm: Alarm) -> None:
        with self._changed:
            heapq.heappush(self._alarms, (moment, next(self._number), alarm))
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._wait, name="patterndb-alarm", daemon=True
                )
                self._thread.start()
            elif self._alarms[0][2] is alarm:
                self._changed.notify()

    def _wait(self) -> None:
        while True:
            with self._changed:
                left = self._alarms[0][0] - read_work_clock() if self._alarms else math.inf
                if left > 0:
                    # The clock may have stood still when this is over; so it is read again.
                    self._changed.wait(min(left, threading.TIMEOUT_MAX))
                    continue
                alarm = heapq.heappop(self._alarms)[2]
            alarm.ring()


_WATCH = _Watch()

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_WATCH.forget)
