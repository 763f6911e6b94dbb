"""A thread's deadline: what may take long looks whether it is late, whoever set it.

A query has a time limit, and the database that it asks knows no queries. So the limit is the
thread's: ``end_by`` sets it around a call, and whatever runs below asks ``is_late``. The clock
stands still while kernels are compiled (:mod:`patterndb.system.compiling`).
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager

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
    """A thread that calls a function when the work clock comes to a moment.

    For kernels, which look at nothing but a flag that someone must set. It may be called off.
    """

    def __init__(self, moment: float, ring: Callable[[], None]) -> None:
        self._moment = moment
        self._ring = ring
        self._called_off = threading.Event()
        threading.Thread(target=self._wait, name="patterndb-alarm", daemon=True).start()

    def call_off(self) -> None:
        """Let it not ring, if it has not yet."""
        self._called_off.set()

    def _wait(self) -> None:
        left = self._moment - read_work_clock()
        while left > 0:
            # The clock may have stood still meanwhile.
            if self._called_off.wait(min(left, threading.TIMEOUT_MAX)):
                return
            left = self._moment - read_work_clock()
        if not self._called_off.is_set():
            self._ring()
