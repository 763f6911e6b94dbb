"""A thread's deadline: what may take long looks whether it is late, whoever set it.

A command has a time limit, and the database, the drawing and the placing that it asks know no
commands. So the limit is the thread's: ``end_by`` sets it around a call, and all that runs below
asks ``is_late``, or sets an :class:`Alarm` for compiled functions. A step that asks neither is run
by :func:`run_until_late`, which leaves it when time is up, and at Ctrl-C. Moments are those of
``time.perf_counter``.
"""

from __future__ import annotations

import heapq
import math
import os
import threading
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import cache
from itertools import count
from time import perf_counter
from typing import Any, TypeVar

from patterndb.errors import TimeLimitError

T = TypeVar("T")

_of_thread = threading.local()


@contextmanager
def end_by(moment: float) -> Generator[None]:
    """Let what this thread does within the block end at a moment.

    A deadline that is there already and is earlier stays.
    """
    before = get_deadline()
    _of_thread.moment = min(before, moment)
    try:
        yield
    finally:
        _of_thread.moment = before


def get_deadline() -> float:
    """Return this thread's deadline; infinity where there is none."""
    return getattr(_of_thread, "moment", math.inf)


def is_late() -> bool:
    """Is this thread's deadline past?"""
    moment = get_deadline()
    return moment < math.inf and perf_counter() >= moment


@contextmanager
def extend_deadline(seconds: float) -> Generator[None]:
    """Let the block end ``seconds`` after this thread's deadline."""
    before = get_deadline()
    _of_thread.moment = before + seconds
    try:
        yield
    finally:
        _of_thread.moment = before


def refuse_if_late(before: str) -> None:
    """Raise TimeLimitError if this thread's deadline is past; before: what was not done yet."""
    if is_late():
        raise TimeLimitError(f"the time limit was over before {before}; allow more seconds")


@contextmanager
def limit_time(seconds: float | None, since: float | None = None) -> Generator[None]:
    """Let what this thread does within the block end after ``seconds``; None sets no limit.

    since: moment from which the seconds count; None counts from now.
    """
    since = perf_counter() if since is None else since
    with end_by(math.inf if seconds is None else since + seconds):
        yield


#: Seconds between two looks at what should end a task while it runs.
LOOK_SECONDS = 0.02

#: Tasks that run in helping threads, those that nobody waits for any more included.
_RUNNING: set[Future[Any]] = set()


@cache
def _get_helpers() -> ThreadPoolExecutor:
    """Threads for tasks that cannot be ended from within."""
    return ThreadPoolExecutor(MOST_HELPERS, thread_name_prefix="patterndb-helper")


#: Threads for tasks: more than a service has requests at work that wait for one.
MOST_HELPERS = 64


def begin_task(task: Callable[[], T]) -> Future[T]:
    """Begin a task in a thread of its own, with the deadline of this one."""
    moment = get_deadline()

    def run() -> T:
        with end_by(moment):
            return task()

    begun = _get_helpers().submit(run)
    _RUNNING.add(begun)
    begun.add_done_callback(_RUNNING.discard)
    return begun


def run_until_late(task: Callable[[], T], before: str) -> T:
    """Return the result of a task that asks nothing itself, from a thread of its own.

    Raises TimeLimitError as soon as this thread's deadline is past; Ctrl-C ends the wait as well.
    The task goes on then, and its result is dropped. before: what was not done yet, for the error.
    """
    begun = begin_task(task)
    while not begun.done():
        refuse_if_late(before)
        wait([begun], LOOK_SECONDS)
    return begun.result()


def has_tasks_left() -> bool:
    """Do tasks still run, which would keep the process from ending?"""
    return bool(_RUNNING)


class Alarm:
    """Has a function called at a moment, unless it is called off.

    For compiled functions, which look at nothing but a flag that someone must set. ``ring`` is
    called in the one thread that waits for all alarms, so it must do no more than that.
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
                left = self._alarms[0][0] - perf_counter() if self._alarms else math.inf
                if left > 0:
                    self._changed.wait(min(left, threading.TIMEOUT_MAX))
                    continue
                alarm = heapq.heappop(self._alarms)[2]
            alarm.ring()


_WATCH = _Watch()


def _forget_threads() -> None:
    """Begin again in a forked process, which has none of the threads."""
    _WATCH.forget()
    _RUNNING.clear()
    _get_helpers.cache_clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_threads)
