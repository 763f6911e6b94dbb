"""The verb that learns from mesh files: ingest, and the line that shows its progress."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeVar

import click

from patterndb.errors import MeshFileError, NotFoundError
from patterndb.system.extras import require_extra
from patterndb_app.cli.database import count_patterns, leaving_no_empty_database
from patterndb_app.cli.failure import EXIT_BAD_INPUT, Interrupted, resumable
from patterndb_app.cli.options import (
    MOST_BYTES,
    Count,
    FileName,
    as_json,
    db_to_write,
    open_database,
    provenance_options,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.progressline import ProgressLine, is_terminal, tell_share
from patterndb_app.cli.text import plural, printable, say, shorten, write, write_json

if TYPE_CHECKING:
    from ingest import MeshReport, Progress

F = TypeVar("F", bound=Callable[..., Any])


def _limit(name: str, default: int, what: str) -> Callable[[F], F]:
    return click.option(
        f"--{name}",
        type=Count(),
        default=default,
        show_default=True,
        metavar="N",
        help=f"{what} of at most N quads; 0 switches them off.",
    )


def _check_scheduler(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    """Refuse what is no scheduler, and one without what it takes, before any file is read."""
    if value is None:
        return None
    from ingest.scheduler import parse_scheduler, reach_scheduler

    try:
        parse_scheduler(value)
    except ValueError as error:
        raise click.BadParameter(str(error), ctx, param) from error
    require_extra("dask", "--scheduler")
    reach_scheduler(value)
    return value


@click.command(
    cls=SectionedCommand,
    sections={
        "What is learned": ("--basic", "--side", "--convex", "--prepare", "--most-patterns"),
        "What is kept with it": ("--db", "--author", "--source", "--licence"),
        "How": ("--jobs", "--scheduler", "--max-bytes", "--skip-bad", "--json"),
    },
)
@click.argument("meshes", nargs=-1, required=True, metavar="MESH...", type=FileName())
@db_to_write
@_limit("basic", 7, "Learn all patches")
@_limit("side", 12, "Learn patches grown by whole sides,")
@_limit("convex", 40, "Learn convex patches grown by whole sides,")
@click.option(
    "--prepare/--no-prepare",
    default=True,
    show_default=True,
    help="Collapse refining polychords first.",
)
@click.option(
    "--most-patterns",
    type=Count(),
    default=0,
    metavar="N",
    help="Keep at most N patterns of each mesh, its most frequent ones.  [default: all]",
)
@click.option("--jobs", type=Count(1, 1024), metavar="N", help="Threads; one a core if not given.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    callback=_check_scheduler,
    help="Learn on a Dask cluster, tcp://HOST:8786, or on N processes of this machine, local:N; "
    "threads of this process if not given.",
)
@provenance_options("meshes")
@click.option(
    "--max-bytes",
    type=Count(1, MOST_BYTES),
    metavar="N",
    help="Refuse files larger than this.  [default: 512 MiB]",
)
@click.option(
    "--skip-bad",
    is_flag=True,
    help="Leave out files that cannot be read, and tell them at the end; exit code 3 then.",
)
@as_json
def ingest(
    meshes: tuple[Path, ...],
    db: Path,
    basic: int,
    side: int,
    convex: int,
    prepare: bool,
    most_patterns: int,
    jobs: int | None,
    scheduler: str | None,
    author: str | None,
    source: str | None,
    licence: str | None,
    max_bytes: int | None,
    skip_bad: bool,
    as_json: bool,
) -> int:
    """Learn the patterns of mesh files into a database.

    MESH is a file (OBJ, PLY, VTK, VTP, USD, OFF) or a folder, of which every such file is
    taken. A mesh that the database has learned with the same options is left as it is, so
    the same command goes on where an interrupted one stopped.

    With --most-patterns no mesh contributes more patterns than this: 15 % of a million are
    150000. The number of patterns left out is reported for each mesh.

    All files are read before anything is learned. A file that cannot be read stops the command,
    unless --skip-bad is given. A mesh without quads is reported; exit code 1 if no mesh has any.

    \b
    patterndb ingest meshes/ --db my.db --licence CC0-1.0
    patterndb ingest downloads/ --db my.db --skip-bad
    patterndb ingest head.obj --db my.db --convex 60 --json
    patterndb ingest meshes/ --db my.db --convex 60 --most-patterns 150000
    patterndb ingest meshes/ --db my.db --scheduler tcp://10.0.0.5:8786
    """
    # Imported here because --help need not wait for it.
    from ingest import check_files
    from ingest import ingest as ingest_files
    from ingest.formats import ReadLimits
    from patterndb.store import LearningOptions, Provenance

    if scheduler is not None and jobs is not None:
        raise click.UsageError("--jobs is about threads here; those of workers are theirs")
    try:
        options = LearningOptions(basic, side, convex, prepare, most_patterns)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    files = [file for mesh in meshes for file in _files(mesh)]
    limits = ReadLimits() if max_bytes is None else ReadLimits(max_bytes=max_bytes)
    # A bad file must not leave an empty database behind, nor must meshes without quads.
    if not db.exists() and not check_files(None, files, options, limits, skip_bad=skip_bad):
        raise NotFoundError(_no_quads(files))
    with (
        # A cluster that is not there must leave no empty database either.
        leaving_no_empty_database(db),
        resumable(f"what was learned is in {db}; the same command goes on from here"),
        open_database(db, "create") as database,
    ):
        with learning_progress(talk=not as_json) as progress:
            report = ingest_files(
                database,
                files,
                options,
                jobs=jobs,
                scheduler=scheduler,
                provenance=Provenance(author, source, licence),
                limits=limits,
                skip_bad=skip_bad,
                progress=progress.update,
                report=progress.report,
            )
        patterns = count_patterns(database)
    if as_json:
        write_json(
            {
                "meshes": [_entry(mesh) for mesh in report.meshes],
                "patterns": patterns,
                "seconds": round(report.seconds, 3),
                "interrupted": report.interrupted,
                "skipped": [
                    {"file": str(error.path), "error": str(error)} for error in report.skipped
                ],
            }
        )
    else:
        learned = sum(m.outcome in ("learned", "replaced") for m in report.meshes)
        write(
            f"{learned:,} of {plural(len(files), 'mesh', 'meshes')} learned, "
            f"{plural(patterns, 'pattern')} in {db} ({report.seconds:.1f} s)"
        )
        cut = [mesh.left_out for mesh in report.meshes if mesh.left_out]
        if cut:
            write(
                f"{plural(len(cut), 'mesh has', 'meshes have')} more than {most_patterns:,} "
                f"patterns, {sum(cut):,} more in all: left out (--most-patterns)"
            )
    if report.interrupted:
        raise Interrupted(
            f"{len(report.meshes):,} of {plural(len(files), 'mesh', 'meshes')} done and in {db}; "
            "the same command goes on from here"
        )
    if report.skipped:
        say(f"{plural(len(report.skipped), 'file')} left out that could not be read:")
        for error in report.skipped:
            say(printable(str(error)))
        return EXIT_BAD_INPUT
    if all(mesh.outcome == "no quads" for mesh in report.meshes):
        raise NotFoundError(_no_quads(files))
    return 0


def _no_quads(files: list[Path]) -> str:
    if len(files) == 1:
        return f"{files[0]} holds no quads; nothing to learn"
    return f"none of the {len(files):,} files can be read and holds quads; nothing to learn"


def _entry(mesh: MeshReport) -> dict[str, object]:
    """A mesh as the JSON document tells of it."""
    return {
        "name": mesh.name,
        "sha256": mesh.sha256,
        "outcome": mesh.outcome,
        "quads_read": mesh.quads_read,
        "quads_used": mesh.quads_used,
        "patches": {
            "basic": mesh.basic,
            "side": mesh.side,
            "convex": mesh.convex,
            "distinct": mesh.distinct,
        },
        "patterns": mesh.patterns,
        "new_patterns": mesh.new_patterns,
        "left_out": mesh.left_out,
        "seconds": round(mesh.seconds, 3),
    }


def _files(path: Path) -> list[Path]:
    """The mesh file, or the mesh files of the folder and those below it."""
    from ingest.formats import SUPPORTED_SUFFIXES

    if not path.is_dir():
        return [path]
    inside = sorted(_below(path))
    files = [p for p in inside if p.suffix.lower() in SUPPORTED_SUFFIXES]
    if not files:
        raise MeshFileError(
            f"there is no mesh in this folder; meshes end in {' '.join(SUPPORTED_SUFFIXES)}",
            path=path,
        )
    if len(files) < len(inside):
        say(f"{path}: {plural(len(inside) - len(files), 'other file')} left out")
    return files


def _below(folder: Path) -> Iterator[Path]:
    """All files in and below the folder, but for hidden ones and those in hidden folders."""
    for path in folder.rglob("*"):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if not hidden and path.is_file():
            yield path


#: Characters of the names of the meshes in work, in the line of progress.
SHOWN_NAMES = 30


def _tell_workers(workers: int | None) -> str:
    if workers is None:
        return ""
    return f"{plural(workers, 'worker') if workers else 'waiting for workers'}: "


class LearningProgress:
    """Shows what an ingest reports: lines for files, and on a terminal a line of progress."""

    def __init__(self, *, talk: bool) -> None:
        self._talk = talk
        self._state: Progress | None = None
        self._started = perf_counter()

    def update(self, state: Progress) -> None:
        """Note how far it is."""
        self._state = state

    def word(self) -> str | None:
        """How far it is, in words; None before that is known."""
        state = self._state
        if state is None:
            return None
        seconds = max(perf_counter() - self._started, 1e-9)
        return (
            f"learning: {tell_share(state.bytes_done / max(state.bytes_total, 1), seconds)}, "
            f"{state.patches / seconds:,.0f} patches/s; {_tell_workers(state.workers)}"
            f"{shorten(printable(', '.join(state.working)), SHOWN_NAMES)}"
        )

    def report(self, mesh: MeshReport) -> None:
        """Tell what became of a file."""
        if not self._talk:
            return
        if mesh.outcome in ("learned", "replaced"):
            text = (
                f"{mesh.name}: {plural(mesh.distinct, 'patch', 'patches')} of "
                f"{plural(mesh.quads_used, 'quad')}, {plural(mesh.patterns, 'pattern')}, "
                f"{mesh.new_patterns:,} of them new"
            )
            if mesh.left_out:
                text += f"; {mesh.left_out:,} rarer ones left out"
            if mesh.outcome == "replaced":
                text += " (had been learned with other options)"
        elif mesh.outcome == "no quads":
            text = f"{mesh.name}: no quads; nothing to learn, left out"
        else:
            text = f"{mesh.name}: {mesh.outcome}"
            if mesh.left_out:
                text += f"; {mesh.left_out:,} of its patterns had been left out"
        say(printable(text))


@contextlib.contextmanager
def learning_progress(*, talk: bool) -> Generator[LearningProgress]:
    """The progress of one ingest; its line goes away at the end."""
    progress = LearningProgress(talk=talk)
    line = ProgressLine(progress.word) if is_terminal() else None
    try:
        yield progress
    finally:
        if line is not None:
            line.close()
