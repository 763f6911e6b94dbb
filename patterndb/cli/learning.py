"""The verbs that change a database: ingest, merge, remove."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from patterndb.cli.options import as_json, db_to_write, open_database, write_json
from patterndb.cli.progress import learning_progress
from patterndb.errors import MeshFileError
from patterndb.store.records import LARGEST_PATCH, LearningOptions, Provenance

F = TypeVar("F", bound=Callable[..., Any])


def _limit(name: str, default: int, what: str) -> Callable[[F], F]:
    return click.option(
        f"--{name}",
        type=click.IntRange(0, LARGEST_PATCH),
        default=default,
        show_default=True,
        metavar="N",
        help=f"{what} of at most N quads; 0 switches them off.",
    )


@click.command()
@click.argument(
    "meshes", nargs=-1, required=True, metavar="MESH...", type=click.Path(path_type=Path)
)
@db_to_write
@_limit("basic", 7, "Learn all patches")
@_limit("side", 12, "Learn patches grown by whole sides,")
@_limit("convex", 40, "Learn convex patches grown by whole sides,")
@click.option("--prepare/--no-prepare", default=True, help="Collapse refining polychords first.")
@click.option("--jobs", type=click.IntRange(1, 1024), metavar="N", help="Threads; one a core.")
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
    from ingest import ingest as ingest_files
    from ingest.read import ReadLimits

    options = LearningOptions(basic, side, convex, prepare)
    files = [file for mesh in meshes for file in _files(mesh)]
    limits = ReadLimits() if max_bytes is None else ReadLimits(max_bytes=max_bytes)
    with open_database(db, "create") as database, learning_progress(talk=not as_json) as progress:
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
        patterns = database.statistics().patterns
    if as_json:
        write_json(
            {
                "meshes": [
                    {
                        "name": m.name,
                        "sha256": m.sha256,
                        "outcome": m.outcome,
                        "quads_read": m.quads_read,
                        "quads_used": m.quads_used,
                        "patches": {
                            "basic": m.basic,
                            "side": m.side,
                            "convex": m.convex,
                            "distinct": m.distinct,
                        },
                        "patterns": m.patterns,
                        "new_patterns": m.new_patterns,
                        "seconds": round(m.seconds, 3),
                    }
                    for m in report.meshes
                ],
                "patterns": patterns,
                "seconds": round(report.seconds, 3),
                "interrupted": report.interrupted,
            }
        )
    else:
        learned = sum(m.outcome in ("learned", "replaced") for m in report.meshes)
        click.echo(
            f"{learned} of {len(files)} meshes learned, {patterns:,} patterns in {db} "
            f"({report.seconds:.1f} s)"
        )
    if report.interrupted:
        click.echo(
            f"interrupted: {len(report.meshes)} of {len(files)} meshes are in {db}; "
            "the same command goes on from here",
            err=True,
        )
        return 130
    return 0


def _files(path: Path) -> list[Path]:
    """The mesh file, or the mesh files of the folder and those below it."""
    from ingest.read import SUPPORTED_SUFFIXES

    if not path.is_dir():
        return [path]
    inside = sorted(p for p in path.rglob("*") if p.is_file() and not p.name.startswith("."))
    files = [p for p in inside if p.suffix.lower() in SUPPORTED_SUFFIXES]
    if len(files) < len(inside):
        click.echo(
            f"{path}: {len(inside) - len(files)} files that are no meshes of a kind that holds "
            "quads are left out",
            err=True,
        )
    if not files:
        raise MeshFileError(f"no mesh in this folder ({', '.join(SUPPORTED_SUFFIXES)})", path=path)
    return files


@click.command()
@click.argument(
    "others", nargs=-1, required=True, metavar="OTHER...", type=click.Path(path_type=Path)
)
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
    with open_database(db, "create") as database:
        for path in others:
            with open_database(path) as other:
                counts = database.merge(other)
            added, replaced, same = (
                added + counts[0],
                replaced + counts[1],
                same + counts[2],
            )
        patterns = database.statistics().patterns
    if as_json:
        write_json({"added": added, "replaced": replaced, "unchanged": same, "patterns": patterns})
    else:
        click.echo(
            f"{added} meshes added, {replaced} replaced, {same} there before; "
            f"{patterns:,} patterns in {db}"
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
        patterns = database.statistics().patterns
    if as_json:
        write_json({"meshes": n_meshes, "patterns_removed": n_patterns, "patterns": patterns})
    else:
        click.echo(
            f"{n_meshes} meshes and {n_patterns:,} patterns removed; {patterns:,} patterns left"
        )
    return 0


COMMANDS = (ingest, merge, remove)
