"""The flag that cancels a query, and threads that heed it.

A time limit, cancel() or Ctrl-C sets the flag. It is a (1,) uint8 array, so that the compiled core,
which holds no lock, reads it as well; 1 cancels.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.deadline import LOOK_SECONDS
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
