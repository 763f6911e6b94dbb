"""The verbs that change a database: ingest, merge, remove."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from patterndb.errors import MeshFileError
from patterndb_app.cli.failure import Interrupted, resumable
from patterndb_app.cli.options import FileName, as_json, db_to_write, open_database
from patterndb_app.cli.progress import learning_progress
from patterndb_app.cli.text import plural, say, write, write_json

if TYPE_CHECKING:
    from ingest import MeshReport
    from patterndb.store import Database

F = TypeVar("F", bound=Callable[..., Any])


def _limit(name: str, default: int, what: str) -> Callable[[F], F]:
    return click.option(
        f"--{name}",
        type=click.IntRange(0),
        default=default,
        show_default=True,
        metavar="N",
        help=f"{what} of at most N quads; 0 switches them off.",
    )


@click.command()
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
    "--jobs", type=click.IntRange(1, 1024), metavar="N", help="Threads; one a core if not given."
)
@click.option("--author", metavar="TEXT", help="Who made the meshes; kept with them.")
@click.option("--source", metavar="TEXT", help="Where they come from; kept with them.")
@click.option("--licence", "--license", metavar="TEXT", help="Their licence; kept with them.")
@click.option(
    "--max-bytes",
    type=click.IntRange(1),
    metavar="N",
    help="Refuse files larger than this.  [default: 512 MiB]",
)
@as_json
def ingest(
    meshes: tuple[Path, ...],
    db: Path,
    basic: int,
    side: int,
    convex: int,
    prepare: bool,
    jobs: int | None,
    author: str | None,
    source: str | None,
    licence: str | None,
    max_bytes: int | None,
    as_json: bool,
) -> int:
    """Learn the patterns of mesh files into a database.

    MESH is a file (OBJ, PLY, VTK, VTP, USD) or a folder, of which every such file is
    taken. A mesh that the database has learned with the same options is left as it is, so
    the same command goes on where an interrupted one stopped.

    \b
    patterndb ingest meshes/ --db my.db --licence CC0-1.0
    patterndb ingest head.obj --db my.db --convex 60 --json
    """
    # Imported here because compiled kernels take a moment that --help need not wait for.
    from ingest import check_files
    from ingest import ingest as ingest_files
    from ingest.formats import ReadLimits
    from patterndb.store import LearningOptions, Provenance

    try:
        options = LearningOptions(basic, side, convex, prepare)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    files = [file for mesh in meshes for file in _files(mesh)]
    limits = ReadLimits() if max_bytes is None else ReadLimits(max_bytes=max_bytes)
    if not db.exists():
        # A bad file must not leave an empty database behind.
        check_files(None, files, options, limits)
    with (
        resumable(f"what was learned is in {db}; the same command goes on from here"),
        open_database(db, "create") as database,
    ):
        with learning_progress(talk=not as_json) as progress:
            report = ingest_files(
                database,
                files,
                options,
                jobs=jobs,
                provenance=Provenance(author, source, licence),
                limits=limits,
                progress=progress.update,
                report=progress.report,
            )
        patterns = _count(database)
    if as_json:
        write_json(
            {
                "meshes": [_entry(mesh) for mesh in report.meshes],
                "patterns": patterns,
                "seconds": round(report.seconds, 3),
                "interrupted": report.interrupted,
            }
        )
    else:
        learned = sum(m.outcome in ("learned", "replaced") for m in report.meshes)
        write(
            f"{learned:,} of {plural(len(files), 'mesh', 'meshes')} learned, "
            f"{plural(patterns, 'pattern')} in {db} ({report.seconds:.1f} s)"
        )
    if report.interrupted:
        raise Interrupted(
            f"{len(report.meshes):,} of {plural(len(files), 'mesh', 'meshes')} done and in {db}; "
            "the same command goes on from here"
        )
    return 0


def _count(database: Database) -> int:
    """The number of patterns; statistics() would hash all content as well."""
    return sum(database.sides_histogram().values())


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


@click.command()
@click.argument("others", nargs=-1, required=True, metavar="OTHER...", type=FileName())
@db_to_write
@as_json
def merge(others: tuple[Path, ...], db: Path, as_json: bool) -> int:
    """Add the meshes of other databases to --db, which is made if there is none.

    The result is what ingesting all their meshes would give. A mesh that both hold with
    different options is taken from OTHER.

    \b
    patterndb merge mine.db yours.db --db ours.db
    """
    added = replaced = same = 0
    with contextlib.ExitStack() as stack:
        # All are opened before anything is written, so that a wrong name changes nothing.
        sources = [stack.enter_context(open_database(path)) for path in others]
        database = stack.enter_context(open_database(db, "create"))
        for other in sources:
            counts = database.merge(other)
            added, replaced, same = added + counts[0], replaced + counts[1], same + counts[2]
        patterns = _count(database)
    if as_json:
        write_json({"added": added, "replaced": replaced, "unchanged": same, "patterns": patterns})
    else:
        write(
            f"{plural(added, 'mesh', 'meshes')} added, {replaced:,} replaced, {same:,} there "
            f"before; {plural(patterns, 'pattern')} in {db}"
        )
    return 0


@click.command()
@click.argument("meshes", nargs=-1, required=True, metavar="MESH...")
@db_to_write
@as_json
def remove(meshes: tuple[str, ...], db: Path, as_json: bool) -> int:
    """Take meshes out of a database, by name or first digits of their SHA-256.

    Frequencies become what they would be had the mesh never been ingested, and patterns
    that no other mesh holds go too.

    \b
    patterndb remove head.obj --db my.db
    """
    with open_database(db, "write") as database:
        n_meshes, n_patterns = database.remove(meshes)
        patterns = _count(database)
    if as_json:
        write_json({"meshes": n_meshes, "patterns_removed": n_patterns, "patterns": patterns})
    else:
        write(
            f"{plural(n_meshes, 'mesh', 'meshes')} and {plural(n_patterns, 'pattern')} removed; "
            f"{plural(patterns, 'pattern')} left in {db}"
        )
    return 0


COMMANDS = (ingest, merge, remove)
