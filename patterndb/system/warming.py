"""Compile kernels of the list ahead, in several processes: :func:`compile_listed`.

Numba compiles under one lock, so threads would wait for each other. A worker is this module as a
program: it is told a kernel by a line, compiles it into the user's folder, and answers by a line.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from patterndb.system.caches import kernel_folder
from patterndb.system.compiling import COMPILED
from patterndb.system.kernellist import (
    ListedKernel,
    find_kernel,
    format_kernel,
    parse_kernel,
    read_list,
)
from patterndb.system.kernelparts import CompileOrder, name_part

#: Most processes that are started: each takes 250 MB, and some seconds to begin.
MOST_PROCESSES = 8
#: Listed seconds that a further process must have to compile: less than it takes to begin.
SECONDS_A_PROCESS = 4

Progress = Callable[[int, int, float], None]


@dataclass(slots=True)
class WarmingResult:
    """What came of it: kernels that are there now, that the code has no more, and errors of those
    that could not be compiled; seconds that each took, by its key."""

    there: list[ListedKernel] = field(default_factory=list[ListedKernel])
    gone: list[ListedKernel] = field(default_factory=list[ListedKernel])
    failed: list[tuple[ListedKernel, str]] = field(default_factory=list[tuple[ListedKernel, str]])
    seconds: dict[tuple[str, str, str], float] = field(
        default_factory=dict[tuple[str, str, str], float]
    )


def find_missing(kernels: Iterable[ListedKernel]) -> list[ListedKernel]:
    """Those of the kernels that are neither in the pack nor in the user's folder."""
    missing: list[ListedKernel] = []
    for kernel in kernels:
        found = find_kernel(kernel)
        if found is not None and not found[0]._cache.is_kept(found[1]):
            missing.append(kernel)
    return missing


def count_processes(kernels: Sequence[ListedKernel]) -> int:
    """How many processes to compile these in: as many as there are processors, where it pays."""
    try:
        processors = len(os.sched_getaffinity(0))
    except AttributeError:  # not everywhere
        processors = os.cpu_count() or 1
    worth = math.ceil(sum(kernel.seconds for kernel in kernels) / SECONDS_A_PROCESS)
    return max(1, min(processors, MOST_PROCESSES, len(kernels), worth))


def compile_ahead(verbs: Iterable[str], progress: Progress, *, plain: bool) -> None:
    """Compile what these verbs lack in other processes; nothing where that does not pay.

    progress: told how many are done, of how many, and about how many seconds are left. plain: only
    what the plainest call of a verb needs: most calls need no more.
    """
    folder = kernel_folder()
    if folder is None or not os.access(folder, os.W_OK):
        return
    missing = find_missing(read_list(verbs, plain=plain))
    processes = count_processes(missing)
    if processes > 1:
        compile_listed(missing, processes=processes, progress=progress)


def compile_listed(
    kernels: Sequence[ListedKernel],
    *,
    processes: int,
    progress: Progress | None = None,
    environment: Mapping[str, str] | None = None,
) -> WarmingResult:
    """Compile the kernels that are not kept yet, in so many processes of their own.

    environment: what theirs has beside this process's. Raises OSError where none can be started.
    """
    asked = {name_part(kernel) for kernel in kernels}
    order = CompileOrder(kernels)
    every = len(order)
    total = sum(order.tenths.values()) / 10
    result = WarmingResult()
    # Guards all of these; it is told when a kernel is done, for which others may wait.
    changed = threading.Condition()
    listed = spent = 0.0
    done = 0

    def take() -> tuple[str, ListedKernel] | None:
        """The next kernel, once there is one; None when no more will come."""
        with changed:
            while (taken := order.take()) is None and not order.is_over():
                changed.wait()
            return taken

    def drive(worker: subprocess.Popen[str]) -> None:
        nonlocal listed, spent, done
        assert worker.stdin is not None and worker.stdout is not None
        while (taken := take()) is not None:
            name, kernel = taken
            try:
                worker.stdin.write(format_kernel(kernel) + "\n")
                worker.stdin.flush()
                answer = json.loads(worker.stdout.readline())
            except (OSError, ValueError):
                # It was killed, by lack of memory or by Ctrl-C: others do what they can.
                with changed:
                    order.finish(name)
                    changed.notify_all()
                    if name in asked:
                        result.failed.append((kernel, "the process that compiled it ended"))
                return
            with changed:
                order.finish(name)
                changed.notify_all()
                # What is wrong with a part is told of the kernel that calls it.
                if name in asked:
                    if answer["found"] is None:
                        result.failed.append((kernel, answer["error"]))
                    elif answer["found"]:
                        result.there.append(kernel)
                    else:
                        result.gone.append(kernel)
                    result.seconds[kernel.key] = answer["seconds"]
                done += 1
                listed += order.tenths[name] / 10
                spent += answer["seconds"]
                pace = (spent + SECONDS_A_PROCESS) / (listed + SECONDS_A_PROCESS)
                if progress is not None:
                    progress(done, every, max(0.0, total - listed) * pace / len(workers))

    workers: list[subprocess.Popen[str]] = []
    try:
        for _ in range(max(1, min(processes, len(kernels)))):
            workers.append(_start_worker(environment or {}))
        threads = [threading.Thread(target=drive, args=(w,), daemon=True) for w in workers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        told = {k.key for k in (*result.there, *result.gone, *(k for k, _ in result.failed))}
        left = [kernel for kernel in kernels if kernel.key not in told]
        result.failed += [(kernel, "no process was left to compile it") for kernel in left]
    finally:
        for worker in workers:
            # Left by Ctrl-C, it would compile on.
            worker.kill()
            for pipe in (worker.stdin, worker.stdout):
                with contextlib.suppress(OSError):
                    if pipe is not None:
                        pipe.close()
            worker.wait()
    return result


def _start_worker(environment: Mapping[str, str]) -> subprocess.Popen[str]:
    # The same modules as here, whatever the present folder holds (-P).
    path = os.pathsep.join(entry for entry in sys.path if entry)
    return subprocess.Popen(
        [sys.executable, "-P", "-m", __name__],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **environment, "PYTHONPATH": path},
        text=True,
        encoding="utf-8",
    )


def compile_kernel(kernel: ListedKernel) -> dict[str, Any]:
    """Compile a kernel in this process, if it is not kept; what a worker answers of it."""
    seconds = COMPILED.seconds
    found = find_kernel(kernel)
    if found is None:
        return {"found": False, "seconds": 0.0}
    dispatcher, types = found
    try:
        if not dispatcher._cache.is_kept(types):
            dispatcher.compile(types)
    except Exception as error:  # whatever the compiler raises, the next kernel may do better
        return {"found": None, "error": f"{type(error).__name__}: {error}", "seconds": 0.0}
    return {"found": True, "seconds": COMPILED.seconds - seconds}


def serve() -> None:
    """Answer a line of stdin by a line of stdout until there are no more."""
    if sys.platform != "win32":
        # Ctrl-C reaches all processes of a terminal: this one has nothing to say about it.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    answers, sys.stdout = sys.stdout, sys.stderr
    COMPILED.watcher = lambda compiling: None
    for line in sys.stdin:
        print(json.dumps(compile_kernel(parse_kernel(line))), file=answers, flush=True)


if __name__ == "__main__":
    serve()
