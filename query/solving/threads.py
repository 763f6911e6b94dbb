"""Work shared out to threads: kernels run without the interpreter's lock."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache


def share_out(run: Callable[[int], None], tasks: range, threads: int | None) -> None:
    """Call ``run`` for every task, on at most so many threads (None: one a processor).

    Each thread takes the next task when it is done with the last: tasks differ much in their
    work. The calling thread takes part.
    """
    ahead = iter(tasks)

    def work() -> None:
        for task in ahead:
            run(task)

    others = min(threads or os.cpu_count() or 1, len(tasks)) - 1
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
