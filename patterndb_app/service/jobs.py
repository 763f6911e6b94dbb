"""Jobs: meshes to be learned, one after another, and the journal that outlives the process.

Beside a database that may be changed is a folder, my.db.jobs, with a folder for each job: the mesh
as it was sent, and job.json, which is replaced whenever the job's state changes. A job whose
process was killed stands there as waiting or learning, and is begun again at the next start:
learning a mesh is one transaction, and a mesh that is learned already changes nothing.
"""

from __future__ import annotations

import contextlib
import json
import logging
import re
import shutil
import threading
import time
import uuid
from collections import deque
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import patterndb
from ingest.pipeline import MeshReport, Progress, ingest
from patterndb.errors import NotFoundError, PatternDBError
from patterndb.store import LearningOptions, Provenance
from patterndb.system.files import replace_file
from patterndb_app.service.refusals import BusyError, ConflictError, MalformedRequestError

LOG = logging.getLogger("patterndb.service")

JobState = Literal["waiting", "learning", "done", "failed", "cancelled"]

#: States in which a job is over.
ENDED = ("done", "failed", "cancelled")

#: Times that a job is begun before it counts as what ends the process.
MOST_BEGINNINGS = 3

#: Ended jobs that are kept for whoever asks what became of them.
KEPT = 100

#: What a mesh may be called.
MESH_NAME = re.compile(r"[^\W_][\w .()+-]{0,99}")


class JobBrokenOffError(Exception):
    """Raised within learning: the job is cancelled, or the service stops."""


@dataclass(frozen=True, slots=True)
class Job:
    """A mesh to be learned, and how far that is.

    db: the database's name. mesh: the file's name. beginnings: how often it was begun; more than
    once where a process was killed meanwhile. share: of the work that is done, 0 to 1. patches: met
    so far. times are seconds of the epoch, None for what has not happened.
    """

    id: str
    db: str
    mesh: str
    state: JobState = "waiting"
    options: dict[str, Any] = field(default_factory=dict[str, Any])
    provenance: dict[str, str | None] = field(default_factory=dict[str, str | None])
    created: float = 0.0
    started: float | None = None
    ended: float | None = None
    beginnings: int = 0
    share: float = 0.0
    patches: int = 0
    result: dict[str, Any] | None = None
    error: str | None = None

    def to_json(self) -> dict[str, Any]:
        """The job as JSON takes it."""
        return asdict(self)


class JobBook:
    """The jobs of a service: a journal of each database, and one thread that learns."""

    def __init__(self, databases: Mapping[str, Path], most: int, threads: int) -> None:
        """databases: those that may be changed, by name. most: jobs that may wait. threads: that
        learning may take."""
        self._folders = {name: Path(f"{path}.jobs") for name, path in databases.items()}
        self._paths = dict(databases)
        self._most = most
        self._threads = threads
        self._changed = threading.Condition()
        self._jobs: dict[str, Job] = {}
        self._queue: deque[str] = deque()
        self._cancelled: set[str] = set()
        self._stopping = False
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Read the journals, begin again what a killed process left, and learn from now on."""
        for name, folder in self._folders.items():
            for path in sorted(folder.glob("*/job.json")):
                job = read_journal(path, name)
                if job is None:
                    continue
                self._jobs[job.id] = job
                if job.state in ENDED:
                    self._drop_mesh(job)
                    continue
                if job.beginnings >= MOST_BEGINNINGS:
                    said = (
                        f"given up: the service ended {job.beginnings} times while it learned this"
                    )
                    self._keep(replace(job, state="failed", ended=time.time(), error=said))
                    self._drop_mesh(job)
                else:
                    self._keep(replace(job, state="waiting", share=0.0, patches=0))
                    self._queue.append(job.id)
                LOG.warning(
                    "job %s (%s) was left %s by a process that ended: %s",
                    job.id,
                    job.mesh,
                    job.state,
                    self._jobs[job.id].error or "it is begun again",
                )
        self._forget_old()
        self._thread = threading.Thread(target=self._run, name="learn", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Break off what is being learned, to be begun again at the next start."""
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join()

    def add(
        self,
        db: str,
        data: bytes,
        name: str,
        options: LearningOptions,
        provenance: Provenance,
    ) -> Job:
        """Have a mesh learned; name: of its file, with a suffix that says its format.

        Raises MalformedRequestError for a name that is none, BusyError where too many wait.
        """
        if not MESH_NAME.fullmatch(name):
            raise MalformedRequestError(
                f"name: {name[:64]!r} is no name of a mesh; take letters, digits, spaces and . _ -"
            )
        with self._changed:
            waiting = sum(job.state not in ENDED for job in self._jobs.values())
        if waiting >= self._most:
            raise BusyError(
                f"{waiting} meshes wait to be learned; wait until one is",
                headers={"Retry-After": "60"},
            )
        job = Job(
            uuid.uuid4().hex,
            db,
            name,
            options=asdict(options),
            provenance=asdict(provenance),
            created=time.time(),
        )
        folder = self._folders[db] / job.id
        folder.mkdir(parents=True)
        (folder / name).write_bytes(data)
        with self._changed:
            self._keep(job)
            self._queue.append(job.id)
            self._changed.notify_all()
        return job

    def find(self, number: str) -> Job:
        """The job of an id; raises NotFoundError where there is none."""
        with self._changed:
            found = self._jobs.get(number)
        if found is None:
            raise NotFoundError(f"there is no job {number[:64]}")
        return found

    def list_all(self) -> list[Job]:
        """All jobs, the newest first."""
        with self._changed:
            return sorted(self._jobs.values(), key=lambda job: -job.created)

    def count(self) -> dict[str, int]:
        """How many jobs are in each state."""
        states = [job.state for job in self.list_all()]
        return {state: states.count(state) for state in ("waiting", "learning", *ENDED)}

    def cancel(self, number: str) -> Job:
        """Cancel a job; raises ConflictError where it has ended."""
        job = self.find(number)
        with self._changed:
            job = self._jobs[number]
            if job.state in ENDED:
                raise ConflictError(f"the job has ended: it is {job.state}")
            self._cancelled.add(number)
            if job.state == "waiting":
                self._end(job, "cancelled")
            return self._jobs[number]

    # In the thread that learns.

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._queue or self._stopping)
                if self._stopping:
                    return
                job = self._jobs[self._queue.popleft()]
                if job.state != "waiting":
                    continue
                job = self._keep(
                    replace(
                        job, state="learning", started=time.time(), beginnings=job.beginnings + 1
                    )
                )
            try:
                report = self._learn(job)
            except JobBrokenOffError:
                if job.id in self._cancelled:
                    self._end(job, "cancelled")
                # Else the service stops: the journal says that it was being learned.
            except (PatternDBError, OSError, MemoryError) as error:
                self._end(job, "failed", error=str(error).replace(str(self._folders[job.db]), ""))
            except Exception as error:
                LOG.exception("job %s", job.id)
                self._end(job, "failed", error=f"unforeseen error: {type(error).__name__}")
            else:
                self._end(job, "done", result=tell_report(report))

    def _learn(self, job: Job) -> MeshReport:
        told = 0.0

        def tell(progress: Progress) -> None:
            nonlocal told
            if self._stopping or job.id in self._cancelled:
                raise JobBrokenOffError
            if time.monotonic() - told > TOLD_EVERY:
                told = time.monotonic()
                share = progress.bytes_done / max(progress.bytes_total, 1)
                with self._changed:
                    now = self._jobs[job.id]
                    self._jobs[job.id] = replace(now, share=share, patches=progress.patches)

        with patterndb.open(self._paths[job.db], "write") as database:
            done = ingest(
                database,
                [self._folders[job.db] / job.id / job.mesh],
                LearningOptions(**job.options),
                jobs=self._threads,
                provenance=Provenance(**job.provenance),
                progress=tell,
            )
        return done.meshes[0]

    # Both.

    def _end(
        self,
        job: Job,
        state: JobState,
        *,
        result: dict[str, Any] | None = None,
        error: str | None = None,
    ) -> None:
        with self._changed:
            now = self._jobs[job.id]
            share = 1.0 if state == "done" else now.share
            over = replace(
                now, state=state, ended=time.time(), share=share, result=result, error=error
            )
            # Whoever sees that a job is over may count on its mesh being gone, whoever finds the
            # mesh after a crash on the job not being over.
            self._note(over)
            self._drop_mesh(over)
            self._jobs[job.id] = over
            self._cancelled.discard(job.id)
        LOG.info(json.dumps({"job": job.id, "mesh": job.mesh, "state": state, "error": error}))
        self._forget_old()

    def _keep(self, job: Job) -> Job:
        """Write a job's new state into its journal, then hold it."""
        self._note(job)
        self._jobs[job.id] = job
        return job

    def _note(self, job: Job) -> None:
        path = self._folders[job.db] / job.id / "job.json"
        replace_file(path, json.dumps(job.to_json(), indent=1))

    def _drop_mesh(self, job: Job) -> None:
        with contextlib.suppress(OSError):
            (self._folders[job.db] / job.id / job.mesh).unlink(missing_ok=True)

    def _forget_old(self) -> None:
        ended = [job for job in self.list_all() if job.state in ENDED]
        for job in ended[KEPT:]:
            with self._changed:
                del self._jobs[job.id]
            shutil.rmtree(self._folders[job.db] / job.id, ignore_errors=True)


#: Seconds between two notes of how far a job is.
TOLD_EVERY = 0.1


def read_journal(path: Path, db: str) -> Job | None:
    """Read the journal of a job; None, which is told, where it is not whole."""
    try:
        job = Job(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        LOG.warning("%s cannot be read and is passed over: %s", path, error)
        return None
    if job.id != path.parent.name or not MESH_NAME.fullmatch(job.mesh):
        LOG.warning("%s is of another job and is passed over", path)
        return None
    return replace(job, db=db)


def tell_report(report: MeshReport) -> dict[str, Any]:
    """What became of a mesh, as JSON takes it; paths of this machine are left out."""
    return {name: value for name, value in asdict(report).items() if name != "path"}
