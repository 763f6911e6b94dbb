"""The flag that cancels a query, its time limit, and threads that heed the flag.

A time limit, cancel() or Ctrl-C sets the flag. It is a (1,) uint8 array, so that the compiled core,
which holds no lock, reads it as well; 1 cancels.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.deadline import LOOK_SECONDS, Alarm, end_by, get_deadline
from query.errors import QueryCancelledError

#: (1,) uint8, 1 once nobody waits for the answer any more.
CancelFlag = NDArray[np.uint8]

#: The flag of a computation that nobody cancels.
NEVER: CancelFlag = np.zeros(1, np.uint8)


def raise_if_cancelled(flag: CancelFlag) -> None:
    """Raise QueryCancelledError where the flag is set."""
    if flag[0]:
        raise QueryCancelledError("the query was cancelled")


def wait_unless_cancelled(task: Future[Any], flag: CancelFlag) -> bool:
    """Wait until a task is done and return True; return False once the flag is set before that.

    Ctrl-C interrupts the wait, too. The task goes on then, and the caller has to end it.
    """
    while not task.done():
        if flag[0]:
            return False
        wait([task], LOOK_SECONDS)
    return True


class RunLimits:
    """How long a query may run: its flag, its deadline, and why it stopped.

    flag:     cancels the search that runs at present.
    deadline: in seconds of perf_counter; the earlier of the time limit and the deadline of the
              thread that begins the query.
    stopped:  "cancelled" or "time limit" where one of these stopped it, else None.
    """

    def __init__(self, time_limit: float | None, flag: CancelFlag | None = None) -> None:
        self.flag: CancelFlag = np.zeros(1, np.uint8) if flag is None else flag
        self.deadline = math.inf
        self.stopped: str | None = None
        self._time_limit = time_limit
        self._alarm: Alarm | None = None
        self._begun = False

    def begin(self) -> None:
        """Set the deadline and its alarm, at the first call."""
        if self._begun:
            return
        self._begun = True
        mine = math.inf if self._time_limit is None else perf_counter() + self._time_limit
        self.deadline = min(mine, get_deadline())
        if self.deadline < math.inf:
            # Another thread sets the flag, the only thing that the compiled core looks at.
            self._alarm = self.set_alarm(self.deadline)

    def end(self) -> None:
        """Call the alarm off: nothing runs any more."""
        if self._alarm is not None:
            self._alarm.call_off()

    def cancel(self, why: str) -> None:
        """Stop what runs, from any thread; why: what ``stopped`` will be."""
        self.stopped = why
        self.flag[0] = 1
        self.end()

    def set_alarm(self, moment: float) -> Alarm:
        """Have the search that runs with the present flag stopped at a moment."""
        flag = self.flag

        def ring() -> None:
            self.stopped = self.stopped or "time limit"
            flag[0] = 1

        return Alarm(moment, ring)

    def time_out(self) -> None:
        """Stop what runs: time is up."""
        self.stopped = self.stopped or "time limit"
        self.flag[0] = 1

    def look_at_clock(self) -> None:
        """Stop what runs if time is up."""
        if self.stopped is None and perf_counter() >= self.deadline:
            self.time_out()

    @contextmanager
    def hold(self) -> Generator[None]:
        """Cancel what follows a list when the list would have been; it does not stop the list."""
        self.begin()
        with end_by(self.deadline), flag_deadline(self.flag):
            yield


@contextmanager
def flag_deadline(flag: CancelFlag | None = None) -> Generator[CancelFlag]:
    """Have a flag set at this thread's deadline (:mod:`patterndb.system.deadline`), and yield it.

    flag: None for a new one.
    """
    given = np.zeros(1, np.uint8) if flag is None else flag

    def ring() -> None:
        given[0] = 1

    moment = get_deadline()
    alarm = Alarm(moment, ring) if moment < math.inf else None
    try:
        if perf_counter() >= moment:
            ring()
        yield given
    finally:
        if alarm is not None:
            alarm.call_off()


def share_out(
    run: Callable[[int], None],
    tasks: range,
    threads: int | None,
    *,
    lengthy: CancelFlag | None = None,
) -> None:
    """Call ``run`` for every task, on at most that many threads (None: one a processor).

    Each thread takes the next task when it is done with the last: tasks differ much in their
    work. The calling thread takes part, unless a task may be ``lengthy``: then this is the flag by
    which tasks are cancelled, and the calling thread waits, so that Ctrl-C reaches it.
    """
    ahead = iter(tasks)

    def work() -> None:
        for task in ahead:
            run(task)

    most = min(threads or os.cpu_count() or 1, len(tasks))
    if lengthy is not None and most:
        helpers = [_pool(most).submit(work) for _ in range(most)]
        try:
            for helper in helpers:
                helper.result()
        except BaseException:
            lengthy[0] = 1
            wait(helpers)
            raise
        return
    others = most - 1
    if others <= 0:
        return work()
    helpers = [_pool(others).submit(work) for _ in range(others)]
    work()
    for helper in helpers:
        helper.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that stay: starting one takes longer than many a query."""
    return ThreadPoolExecutor(threads, thread_name_prefix="patterndb-query")
