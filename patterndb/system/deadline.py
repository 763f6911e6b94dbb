"""A thread's deadline: what may take long looks whether it is late, whoever set it.

A query has a time limit, and the database that it asks knows no queries. So the limit is the
thread's: ``end_by`` sets it around a call, and whatever runs below asks ``is_late``. The clock
stands still while kernels are compiled (:mod:`patterndb.system.compiling`).
"""

from __future__ import annotations

import math
import threading
from collections.abc import Generator
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
