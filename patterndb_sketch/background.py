"""Work in a thread, so that whoever asks for it need not wait."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from contextlib import contextmanager
from typing import Generic, TypeVar

Result = TypeVar("Result")


class StoppedError(BaseException):
    """The user wants no more of what a thread is making; only that thread's owner catches it."""


class Stoppable:
    """Lets a thread be stopped between two of its steps, within :meth:`running`."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._thread: int | None = None
        #: Was it asked to stop?
        self.stopped = False

    @contextmanager
    def running(self) -> Generator[None]:
        """Allow this thread to be stopped: StoppedError is raised where it is then."""
        with self._lock:
            self._thread, self.stopped = threading.get_ident(), False
        try:
            yield
        finally:
            # Whoever stops it holds the lock: nothing is raised once this is passed.
            with self._lock:
                self._thread = None

    def stop(self) -> bool:
        """Stop the thread as soon as it does something of Python's; False if none runs."""
        with self._lock:
            if self._thread is None:
                return False
            self.stopped = True
            number, error = ctypes.c_ulong(self._thread), ctypes.py_object(StoppedError)
            return ctypes.pythonapi.PyThreadState_SetAsyncExc(number, error) == 1


class Latest(Generic[Result]):
    """Makes what was wanted last; what was wanted before and has not begun is dropped.

    What was begun is finished, and is :attr:`last` until something newer is. name: of the thread.
    """

    def __init__(self, name: str) -> None:
        self._worker = ThreadPoolExecutor(1, thread_name_prefix=name)
        self._asked: list[tuple[object, Future[Result]]] = []

    def want(self, make: Callable[[], Result], key: object = None) -> None:
        """Have something made, unless the last that was wanted has the same key, not None."""
        if key is not None and self._asked and self._asked[-1][0] == key:
            return
        last = self._last_done()
        for _, future in self._asked:
            future.cancel()
        self._asked = [one for one in self._asked if one is last or not one[1].done()]
        self._asked.append((key, self._worker.submit(make)))

    def drop(self) -> None:
        """Want nothing any more, and forget what was made."""
        for _, future in self._asked:
            future.cancel()
        self._asked = []

    @property
    def busy(self) -> bool:
        """Is the last that was wanted still to be made?"""
        return bool(self._asked) and not self._asked[-1][1].done()

    def wait(self, seconds: float | None = None) -> bool:
        """Wait until the last that was wanted is made; False if time ran out before."""
        return not wait_for([future for _, future in self._asked[-1:]], seconds).not_done

    @property
    def found(self) -> Future[Result] | None:
        """The last that was wanted, if it is made."""
        return None if not self._asked or self.busy else self._asked[-1][1]

    @property
    def last(self) -> Future[Result] | None:
        """The last that was made, of all that was wanted."""
        last = self._last_done()
        return None if last is None else last[1]

    def close(self) -> None:
        """Wait for what was begun."""
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _last_done(self) -> tuple[object, Future[Result]] | None:
        done = (one for one in reversed(self._asked) if one[1].done() and not one[1].cancelled())
        return next(done, None)
