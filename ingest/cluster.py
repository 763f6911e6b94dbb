"""Learning on a Dask cluster: the engine that sends meshes to workers and gets columns back.

A mesh is cut into parts of some seconds each. Its bytes are one task, each part is one, ten parts
are merged by one, and the last gives what the mesh teaches (:mod:`ingest.clustertasks`). All of
them can be done again elsewhere, so a worker that dies costs what it had in work. Only this process
writes. Small meshes are one task whole.

Needs the extra "dask". docs/cluster.md tells how to start a cluster, and what it trusts.
"""

from __future__ import annotations

import itertools
import logging
import time
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from ingest.clustertasks import (
    Columns,
    MeshParcel,
    find_differences,
    finish_mesh,
    from_columns,
    hold_parcel,
    learn_part,
    learn_whole,
    list_versions,
    merge_parts,
)
from ingest.engines import MeshRun, choose_shard
from ingest.scheduler import explain_unreachable, parse_scheduler, reach_scheduler
from patterndb.core.halfedge import Int32Array
from patterndb.errors import ClusterError, PatternDBError
from patterndb.store.records import Learned, LearningOptions
from patterndb.system.extras import require_extra

#: Parts that one task merges: in trials a tree of twos died at its root, and one merge of all of
#: a large mesh held all of its parts at once.
TOGETHER = 10
#: Parts that are under way for every thread of the workers: one in work, one waiting.
QUEUED = 2
#: Seconds to wait for a scheduler that takes connections to answer, and for its first worker.
ANSWER_SECONDS = 10.0
PATIENCE = 20.0
#: Seconds between two counts of workers.
COUNT_SECONDS = 1.0


class ClusterEngine:
    """Learns on the workers of a Dask cluster; see :class:`ingest.engines.LearningEngine`.

    bytes_sent, bytes_received: of meshes and of what they taught, as they left and came to this
    process, without what Dask adds.
    """

    def __init__(self, scheduler: str) -> None:
        """scheduler: "tcp://HOST:PORT", or "local:N". Raises ValueError for what is neither, and
        MissingExtraError where the extra "dask" is not installed."""
        require_extra("dask", "a cluster")
        self._address = scheduler
        self._n_processes = parse_scheduler(scheduler)
        self._closing = ExitStack()
        self._threads: Mapping[str, int] = {}
        self._counted = 0.0
        self._numbers = itertools.count()
        self._name = f"patterndb-{uuid4().hex[:8]}"
        self.bytes_sent = 0
        self.bytes_received = 0

    def __enter__(self) -> ClusterEngine:
        """Connect, and compare versions.

        Raises ClusterError where there is no scheduler, or no worker, or one differs.
        """
        reach_scheduler(self._address)
        from distributed import Client

        # Dask tells of every lost connection; what matters is raised.
        for name in ("distributed", "distributed.client", "tornado.application"):
            logger = logging.getLogger(name)
            self._closing.callback(logger.setLevel, logger.level)
            logger.setLevel(logging.CRITICAL)
        try:
            where: Any = self._address
            if self._n_processes is not None:
                where = self._closing.enter_context(_start_processes(self._n_processes))
            # Its methods give coroutines or values, by how it was made: types cannot tell.
            self._client: Any = Client(
                where, timeout=ANSWER_SECONDS, set_as_default=False, name="patterndb"
            )
            self._closing.callback(self._close_client)
            self._meet_workers()
        except BaseException as error:
            self._closing.close()
            # Another server makes Dask raise anything, such as MemoryError for what it takes for a
            # length.
            if isinstance(error, Exception) and not isinstance(error, PatternDBError):
                raise explain_unreachable(self._address, error) from error
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._closing.close()

    def _close_client(self) -> None:
        # What is in work is of no use to anybody; a scheduler that is lost cannot be told.
        with suppress(Exception):
            self._client.close(timeout=5)

    @property
    def width(self) -> int:
        """Parts under way at a time."""
        return QUEUED * max(1, sum(self._count_threads().values()))

    @property
    def n_workers(self) -> int:
        """How many workers there are."""
        return len(self._count_threads())

    def count_patches(self) -> int:
        """None that are not in a mesh that is done: parts tell when they end."""
        return 0

    def begin(
        self, quads: Int32Array, faces: NDArray[np.int64], options: LearningOptions, *, alone: bool
    ) -> MeshRun:
        """Send a mesh to the workers."""
        shard = choose_shard(len(quads), self.width, alone=alone)
        n_parts = -(-len(quads) // shard)
        key = f"{self._name}-{next(self._numbers)}"
        sent = MeshParcel.wrap(quads, faces, options, shard)
        self.bytes_sent += len(sent.quads) + len(sent.faces)
        submit = self._client.submit
        parcel = submit(hold_parcel, sent, key=f"{key}-mesh")
        if n_parts == 1:
            parts: list[Any] = []
            last = submit(learn_whole, parcel, key=f"{key}-all")
        else:
            parts = [
                submit(learn_part, parcel, k, n_parts, key=f"{key}-part-{k}")
                for k in range(n_parts)
            ]
            merged = [
                submit(merge_parts, parts[k : k + TOGETHER], key=f"{key}-merge-{k}")
                for k in range(0, n_parts, TOGETHER)
            ]
            last = submit(finish_mesh, parcel, merged, key=f"{key}-all")
        result = _Followed(self, last, gathered=True)
        followed = [_Followed(self, part, gathered=False).future for part in parts]

        def finish() -> Learned:
            columns: Columns = result.future.result()
            self.bytes_received += sum(
                value.nbytes for value in columns.values() if isinstance(value, np.ndarray)
            )
            return from_columns(Learned, columns)

        return MeshRun(frozenset((result.future, *followed)), finish)

    def _meet_workers(self) -> None:
        """Wait for a worker, and see that all are like this program."""
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ClusterError(
                f"the scheduler {self._address} has no worker; start some where patterndb is "
                f"installed: 'dask worker {self._address}'"
            ) from None
        mine = list_versions()
        found: dict[str, Any] = self._client.run(list_versions, on_error="return")
        wrong: list[str] = []
        for worker, theirs in sorted(found.items()):
            if isinstance(theirs, ModuleNotFoundError):
                wrong.append(f"{worker}: patterndb is not installed there ({theirs})")
            elif isinstance(theirs, BaseException):
                wrong.append(f"{worker}: it does not tell its versions ({theirs})")
            else:
                wrong += [f"{worker}: {one}" for one in find_differences(mine, theirs)]
        if wrong:
            raise ClusterError(
                "workers must have the versions that this program has, since what is learned may "
                "depend on them; install the same and start the workers again\n" + "\n".join(wrong)
            )

    def _count_threads(self) -> Mapping[str, int]:
        """Threads of every worker, as of a moment ago."""
        if time.monotonic() - self._counted > COUNT_SECONDS:
            # Not while it cannot be asked: what is in work tells then.
            if self._client.status == "running":
                with suppress(OSError, TimeoutError):
                    self._threads = self._client.nthreads()
            self._counted = time.monotonic()
        return self._threads

    def explain(self, error: BaseException) -> BaseException:
        """What a task's error means to who learns."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker):
            return ClusterError(
                f"a part of a mesh has ended every worker that tried it ({error}); they may lack "
                "memory: start them with a greater --memory-limit, or fewer threads. What was "
                "learned before is kept, and the same command goes on from there"
            )
        return error

    def lost(self) -> ClusterError:
        """The error that says that the scheduler is gone."""
        return ClusterError(
            f"the scheduler {self._address} is lost. What was learned before is kept: start it and "
            "its workers again, and the same command goes on from there"
        )


def _start_processes(number: int) -> Any:
    """A scheduler and so many processes of one thread on this machine."""
    from distributed import LocalCluster

    start: Any = LocalCluster
    return start(
        n_workers=number,
        threads_per_worker=1,
        processes=True,
        # Port 0: any that is free; others may have a cluster here.
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL,
    )


class _Followed:
    """A task on the cluster, as a future that the pipeline waits for.

    gathered: is its result wanted here, or only that it ended?
    """

    def __init__(self, engine: ClusterEngine, task: Any, *, gathered: bool) -> None:
        self.future: Future[Any] = Future()
        self._engine = engine
        self._task = task
        self._gathered = gathered
        # Dask calls it in a thread of its own.
        task.add_done_callback(self._end)

    def _end(self, task: Any) -> None:
        try:
            if task.status == "error":
                self.future.set_exception(self._engine.explain(task.exception()))
            elif task.status != "finished":
                self.future.set_exception(self._engine.lost())
            else:
                self.future.set_result(task.result() if self._gathered else None)
        except BaseException as error:  # whatever it is, who waits must hear of it
            self.future.set_exception(
                error if isinstance(error, PatternDBError) else self._engine.lost()
            )
