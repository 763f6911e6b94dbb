"""From mesh files, or a mesh in arrays, to the store: read, learn on all cores or on a cluster
(:mod:`ingest.engines`), write one mesh at a time.

Meshes are taken largest first, so that the cores run dry together; each is written in one step as
soon as its last task has ended, so that a crash loses at most the meshes in work.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Literal

from numpy.typing import ArrayLike

from ingest.arrays import canonical_bytes, mesh_of_arrays
from ingest.engines import LearningEngine, MeshRun, ThreadEngine, list_parts
from ingest.formats import ReadLimits, load_file, parse
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError, MeshFileError
from patterndb.store import Database, Learned, LearningOptions, Provenance

Outcome = Literal["learned", "replaced", "unchanged", "updated", "no quads"]


@dataclass(frozen=True, slots=True)
class MeshReport:
    """What became of one mesh.

    path: its file; None where it was given as arrays.
    outcome: "learned"; "replaced" (it had been learned with other options); "unchanged";
    "updated" (only its name or provenance changed); or "no quads" (nothing to learn from, and
    nothing written).
    seconds: from reading to the end of writing; other meshes may have run beside it.
    left_out: patterns that it has beyond the most that were to be kept.
    """

    path: Path | None
    name: str
    sha256: str
    outcome: Outcome
    quads_read: int
    quads_used: int
    basic: int
    side: int
    convex: int
    distinct: int
    patterns: int
    new_patterns: int
    seconds: float
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class IngestReport:
    """What an ingest did: one report a file that could be read, in the order given.

    skipped: why the others could not be, where bad files were to be skipped.
    """

    meshes: list[MeshReport]
    seconds: float
    interrupted: bool
    skipped: tuple[MeshFileError, ...] = ()


@dataclass(slots=True)
class Progress:
    """How far an ingest is; passed to the callback about ten times a second.

    bytes_done of bytes_total: share of the files, by size, that is learned, counting the
    tasks of meshes in work. patches: met so far, over all modes; on a cluster in meshes that are
    done. working: names in work. workers: processes of the cluster; None where there is none.
    """

    bytes_total: int
    bytes_done: float = 0.0
    patches: int = 0
    working: list[str] = field(default_factory=list[str])
    workers: int | None = None


@dataclass(slots=True)
class _Work:
    """One mesh on its way through the pipeline: a file, or polygons."""

    index: int
    source: Path | PolygonMesh
    name: str
    options: LearningOptions
    size: int = 0
    sha256: str = ""
    outcome: Outcome = "learned"
    started: float = 0.0
    run: MeshRun | None = None


def ingest(
    database: Database,
    paths: Sequence[Path | str],
    options: LearningOptions | Callable[[Path], LearningOptions] | None = None,
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    provenance: Provenance | Callable[[Path], Provenance] | None = None,
    limits: ReadLimits | None = None,
    skip_bad: bool = False,
    progress: Callable[[Progress], None] | None = None,
    report: Callable[[MeshReport], None] | None = None,
) -> IngestReport:
    """Learn the patterns of mesh files into a database open for writing.

    A file whose bytes the database has learned with the same options changes nothing but,
    where ``provenance`` says something else than before, that. jobs: threads, default one a
    core. scheduler: learn on a Dask cluster instead, the one at this address
    ("tcp://10.0.0.5:8786") or one of N processes of this machine ("local:N"); what is learned is
    the same. options, provenance: of all files, or asked for each. report is called for every file
    as it is done.

    All files are read and checked before anything is learned: if one cannot be read,
    MeshFileError is raised (InvalidMeshError, naming all, where there are several) and the
    database is as before. skip_bad: such files are left out, and told in the report; if none
    can be read that is an error all the same. A mesh without quads leaves nothing.

    On KeyboardInterrupt the tasks in work are broken off, what was written stays, and the report
    says "interrupted". Raises MissingExtraError where a scheduler is given and the extra "dask" is
    not installed, ClusterError where the cluster cannot be used, or is lost; what was written stays
    then, too, and the same call goes on.
    """
    started = perf_counter()
    limits = limits or ReadLimits()
    engine = _choose_engine(jobs, scheduler)
    run = _Run(database, engine, limits, provenance, progress, report)
    interrupted = False
    skipped: list[MeshFileError] = []
    try:
        with engine:
            checked = _check(_work_of(paths, options), database, limits, skip_bad)
            skipped = checked.bad
            run.run(checked)
    except KeyboardInterrupt:
        interrupted = True
    return IngestReport(
        [run.reports[i] for i in sorted(run.reports)],
        perf_counter() - started,
        interrupted,
        tuple(skipped),
    )


def _choose_engine(jobs: int | None, scheduler: str | None) -> LearningEngine:
    """Where meshes are learned: on threads, or on a cluster where one is named."""
    if scheduler is None:
        return ThreadEngine(jobs)
    if jobs is not None:
        raise ValueError("jobs is about threads of this process; a cluster's workers have theirs")
    # Imported here because Dask is an extra, and takes a moment.
    from ingest.cluster import ClusterEngine

    return ClusterEngine(scheduler)


def learn_mesh(
    database: Database,
    faces: PolygonMesh | ArrayLike | Sequence[Sequence[int]],
    *,
    name: str,
    options: LearningOptions | None = None,
    provenance: Provenance | None = None,
    jobs: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> MeshReport:
    """Learn a finished mesh from a program into a database open for writing.

    faces: (q, 4) vertex indices, a list of faces of any arity, or a PolygonMesh; name: what
    the mesh is to be called. What is learned is what a file with these faces teaches.

    The mesh is known by its faces (:mod:`ingest.arrays` says how), as a file is by its bytes:
    learned again with the same options it changes nothing but, where ``provenance`` says
    something else than before, that; with other options it is replaced. A mesh with one more
    edit is another mesh: ``database.remove([name])`` takes the old one out.

    Raises InvalidMeshError for faces that are none or an empty name, DatabaseError for a
    database open for reading only; on KeyboardInterrupt the database is as before.

    Example: ``ingest.learn_mesh(db, quads, name="head, finished")``
    """
    if not name.strip():
        raise InvalidMeshError("the name of the mesh is empty; say what it is to be called")
    try:
        name.encode()
    except UnicodeEncodeError:
        raise InvalidMeshError(f"the name {name!a} of the mesh is no text in UTF-8") from None
    mesh = mesh_of_arrays(faces)
    data = canonical_bytes(mesh)
    options = options or LearningOptions()
    w = _Work(0, mesh, name, options, len(data), hashlib.sha256(data).hexdigest())
    w.started = perf_counter()
    here = database.find_mesh(w.sha256)
    if here is not None and here.options != options:
        w.outcome = "replaced"
    checked = _Checked()
    if here is not None and here.options == options:
        checked.known.append(w)
    elif not len(mesh.quads()[0]):
        w.outcome = "no quads"
        checked.empty.append(w)
    else:
        checked.waiting.append(w)
    engine = ThreadEngine(jobs)
    run = _Run(database, engine, ReadLimits(), provenance, progress, None)
    with engine:
        run.run(checked)
    return run.reports[0]


def _work_of(
    paths: Sequence[Path | str],
    options: LearningOptions | Callable[[Path], LearningOptions] | None,
) -> list[_Work]:
    options = options or LearningOptions()
    return [
        _Work(i, path, path.name, options(path) if callable(options) else options)
        for i, path in enumerate(map(Path, paths))
    ]


def check_files(
    database: Database | None,
    paths: Sequence[Path | str],
    options: LearningOptions | Callable[[Path], LearningOptions] | None = None,
    limits: ReadLimits | None = None,
    *,
    skip_bad: bool = False,
) -> int:
    """Read the files as :func:`ingest` would, but for those the database has learned with
    these options, and learn nothing.

    Returns how many hold quads. Raises what :func:`ingest` raises for a bad file.
    """
    work = _work_of(paths, options)
    checked = _check(work, database, limits or ReadLimits(), skip_bad)
    return len(checked.known) + len(checked.waiting) + len(checked.twins)


@dataclass(slots=True)
class _Checked:
    """What the files turned out to be before anything is learned.

    known: those that the database has learned. waiting: to be learned. twins: that hold the same
    bytes as one of these. empty: without quads. bad: that cannot be read.
    """

    known: list[_Work] = field(default_factory=list[_Work])
    waiting: list[_Work] = field(default_factory=list[_Work])
    twins: list[_Work] = field(default_factory=list[_Work])
    empty: list[_Work] = field(default_factory=list[_Work])
    bad: list[MeshFileError] = field(default_factory=list[MeshFileError])


def _check(
    work: list[_Work],
    database: Database | None,
    limits: ReadLimits,
    skip_bad: bool,
) -> _Checked:
    """Read every file once to find the bad ones before the long part begins."""
    checked = _Checked()
    bad = checked.bad
    seen: set[str] = set()
    for w in work:
        w.started = perf_counter()
        assert isinstance(w.source, Path)
        try:
            _check_name(w.source)
            data = load_file(w.source, limits)
            w.size = len(data)
            w.sha256 = hashlib.sha256(data).hexdigest()
            here = None if database is None else database.find_mesh(w.sha256)
            if here is not None and here.options == w.options:
                checked.known.append(w)
                continue
            mesh = parse(data, w.source, limits)
        except MeshFileError as error:
            bad.append(error)
            continue
        if w.sha256 in seen:
            checked.twins.append(w)
            continue
        if not len(mesh.quads()[0]):
            w.outcome = "no quads"
            checked.empty.append(w)
            continue
        seen.add(w.sha256)
        w.outcome = "learned" if here is None else "replaced"
        checked.waiting.append(w)
    if not bad or (skip_bad and len(bad) < len(work)):
        return checked
    if len(bad) == 1:
        raise bad[0]
    raise InvalidMeshError(
        f"{len(bad)} of {len(work)} files cannot be read; nothing was ingested\n"
        + "\n".join(str(error) for error in bad)
        + ("" if len(bad) == len(work) else "\nskip_bad (--skip-bad) leaves such files out")
    )


def _check_name(path: Path) -> None:
    """A mesh is stored under its file's name, so that must be text."""
    try:
        path.name.encode()
    except UnicodeEncodeError:
        raise MeshFileError(
            "the name of the file is not UTF-8, and the mesh is stored under it; rename the file",
            path=ascii(path.name),
        ) from None


class _Run:
    """One call of :func:`ingest` or :func:`learn_mesh`."""

    def __init__(
        self,
        database: Database,
        engine: LearningEngine,
        limits: ReadLimits,
        provenance: Provenance | Callable[[Path], Provenance] | None,
        progress: Callable[[Progress], None] | None,
        report: Callable[[MeshReport], None] | None,
    ) -> None:
        self.database = database
        self.engine = engine
        self.limits = limits
        self.provenance = provenance
        self.progress = progress
        self.report = report
        self.reports: dict[int, MeshReport] = {}
        self.done_bytes = 0
        self.done_patches = 0

    def run(self, checked: _Checked) -> None:
        """See to meshes that are there, to be learned, and to twins of these."""
        waiting = checked.waiting
        self.state = Progress(sum(w.size for w in (*checked.known, *waiting, *checked.twins)))
        for w in checked.known:
            self._report_known(w)
        for w in checked.empty:
            self._report(w, 0, 0, (0, 0, 0, 0), 0, 0)
        waiting.sort(key=lambda w: (-w.size, w.index))
        open_meshes: list[_Work] = []
        while waiting or open_meshes:
            # One mesh more than are worked on at a time keeps all of them busy.
            while waiting and self._count_parts(open_meshes) <= self.engine.width:
                fresh = waiting.pop(0)
                self._begin(fresh, alone=len(waiting) < self.engine.width)
                open_meshes.append(fresh)
            running = list_parts(w.run for w in open_meshes if w.run is not None)
            if running:
                wait(running, timeout=0.1, return_when=FIRST_COMPLETED)
            for w in list(open_meshes):
                if w.run is not None and w.run.is_done():
                    self._finish(w, w.run.finish())
                    open_meshes.remove(w)
            self._show(open_meshes)
        for w in checked.twins:
            self._report_known(w)

    @staticmethod
    def _count_parts(open_meshes: Iterable[_Work]) -> int:
        return len(list_parts(w.run for w in open_meshes if w.run is not None))

    def _begin(self, w: _Work, *, alone: bool) -> None:
        """Read the mesh and begin to learn it. alone: no other meshes are left to keep the
        engine busy."""
        w.started = perf_counter()
        if isinstance(w.source, Path):
            data = load_file(w.source, self.limits)
            if hashlib.sha256(data).hexdigest() != w.sha256:
                raise InvalidMeshError(f"{w.source} changed while it was being ingested; run again")
            mesh = parse(data, w.source, self.limits)
        else:
            mesh = w.source
        quads, faces = mesh.quads()
        w.run = self.engine.begin(quads, faces, w.options, alone=alone)

    def _finish(self, w: _Work, learned: Learned) -> None:
        w.run = None
        here = self.database.find_mesh(w.sha256)
        provenance = self._provenance_of(w, here.provenance if here else Provenance())
        new = self.database.add_mesh(w.name, w.sha256, provenance, w.options, learned)
        self.done_bytes += w.size
        self.done_patches += learned.basic + learned.side + learned.convex
        self._report(
            w,
            learned.quads_read,
            learned.quads_used,
            (learned.basic, learned.side, learned.convex, learned.distinct),
            len(learned.codes),
            new,
            left_out=learned.left_out,
        )

    def _report_known(self, w: _Work) -> None:
        """A mesh that is there: change its provenance if something else is said of it."""
        here = self.database.find_mesh(w.sha256)
        assert here is not None
        wanted = self._provenance_of(w, here.provenance)
        w.outcome = "unchanged"
        if wanted != here.provenance:
            self.database.update_provenance(w.sha256, here.name, wanted)
            w.outcome = "updated"
        self.done_bytes += w.size
        self._report(
            w,
            here.quads_read,
            here.quads_used,
            (here.basic, here.side, here.convex, here.distinct),
            here.patterns,
            0,
            here.name,
            here.left_out,
        )

    def _provenance_of(self, w: _Work, held: Provenance) -> Provenance:
        """What is said of the mesh, and where nothing is said what the database holds."""
        said = self.provenance
        if callable(said):
            assert isinstance(w.source, Path)
            said = said(w.source)
        if said is None:
            return held
        return Provenance(
            said.author or held.author, said.source or held.source, said.licence or held.licence
        )

    def _report(
        self,
        w: _Work,
        quads_read: int,
        quads_used: int,
        patches: tuple[int, int, int, int],
        patterns: int,
        new_patterns: int,
        name: str | None = None,
        left_out: int = 0,
    ) -> None:
        entry = MeshReport(
            w.source if isinstance(w.source, Path) else None,
            name or w.name,
            w.sha256,
            w.outcome,
            quads_read,
            quads_used,
            *patches,
            patterns,
            new_patterns,
            perf_counter() - w.started,
            left_out,
        )
        self.reports[w.index] = entry
        if self.report is not None:
            self.report(entry)

    def _show(self, open_meshes: Iterable[_Work]) -> None:
        if self.progress is None:
            return
        done = float(self.done_bytes)
        for w in open_meshes:
            done += 0.0 if w.run is None else w.size * w.run.share
        self.state.bytes_done = done
        met = max(self.done_patches, self.engine.count_patches())
        self.state.patches = max(self.state.patches, met)
        self.state.workers = self.engine.n_workers
        self.state.working = [w.name for w in open_meshes]
        self.progress(self.state)
