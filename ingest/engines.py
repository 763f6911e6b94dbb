"""Where the parts of a mesh are learned: what the pipeline asks, and the answer on threads.

A :class:`LearningEngine` takes one mesh after another and gives a :class:`MeshRun` for each, which
ends in what the mesh teaches. :class:`ThreadEngine` runs the tasks of :mod:`ingest.learning` on
threads of this process, which is enough for one machine, for the search runs without the
interpreter's lock; :mod:`ingest.cluster` has one that runs them on a Dask cluster.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ingest.learning import MeshLearning
from patterndb.core.halfedge import Int32Array
from patterndb.store.records import Learned, LearningOptions

#: Most quads of a growth task, which remembers the patches it met: up to 100 kB a quad on
#: very irregular meshes.
SHARD_QUADS = 4096
#: Where one mesh must keep all cores busy it is cut finer, but not below this: patches that
#: reach into two shards are found twice.
SMALLEST_SHARD = 1024


@dataclass(slots=True)
class MeshRun:
    """A mesh that is being learned.

    parts: what it waits for. finish: puts their results together, once all have ended.
    """

    parts: frozenset[Future[Any]]
    finish: Callable[[], Learned]

    @property
    def share(self) -> float:
        """How much of it is done, from 0 to 1."""
        return sum(part.done() for part in self.parts) / max(len(self.parts), 1)

    def is_done(self) -> bool:
        """Have all parts ended? Raises what a part that failed raised."""
        for part in self.parts:
            if part.done():
                part.result()
        return all(part.done() for part in self.parts)


class LearningEngine(Protocol):
    """What learns meshes, several at a time; a context manager that ends what is in work."""

    def __enter__(self) -> LearningEngine: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

    @property
    def width(self) -> int:
        """How many parts it works on at a time."""
        ...

    @property
    def n_workers(self) -> int | None:
        """How many other processes work; None where it is this one alone."""
        ...

    def begin(
        self, quads: Int32Array, faces: NDArray[np.int64], options: LearningOptions, *, alone: bool
    ) -> MeshRun:
        """Begin with a mesh of quads (q, 4) at these places (q,) of its file. alone: no other
        meshes are left to keep all busy."""
        ...

    def count_patches(self) -> int:
        """Patches that were met so far in meshes that may be in work still."""
        ...


def choose_shard(n_quads: int, width: int, *, alone: bool) -> int:
    """Choose the most quads of a task of a mesh, of which ``width`` tasks run at a time."""
    if alone and width > 1:
        return max(SMALLEST_SHARD, min(SHARD_QUADS, n_quads // (2 * width)))
    return SHARD_QUADS


class ThreadEngine:
    """Learns on threads of this process."""

    n_workers = None

    def __init__(self, jobs: int | None) -> None:
        """jobs: how many threads; one a core if None."""
        self.width = jobs or os.cpu_count() or 1
        self._pulse = np.zeros(2, np.int64)

    def __enter__(self) -> ThreadEngine:
        self._pool = ThreadPoolExecutor(self.width, thread_name_prefix="learn")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # Tasks in work are broken off.
        self._pulse[0] = 1
        self._pool.shutdown(cancel_futures=True)

    def begin(
        self, quads: Int32Array, faces: NDArray[np.int64], options: LearningOptions, *, alone: bool
    ) -> MeshRun:
        """Prepare the mesh and start its tasks."""
        shard = choose_shard(len(quads), self.width, alone=alone)
        learning = MeshLearning(quads, faces, options, shard_quads=shard, pulse=self._pulse)
        parts = [self._pool.submit(task) for task in learning.tasks]
        return MeshRun(frozenset(parts), lambda: learning.finish([part.result() for part in parts]))

    def count_patches(self) -> int:
        """Patches that were met so far."""
        # Several threads count in one place without a lock, and may lose a patch.
        return int(self._pulse[1])


def list_parts(runs: Iterable[MeshRun]) -> list[Future[Any]]:
    """List the parts of meshes in work that have not ended."""
    return [part for run in runs for part in run.parts if not part.done()]
