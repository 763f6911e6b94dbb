"""The verbs that ask: stats, meshes, query, verify."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb.cli.options import (
    Numbers,
    Range,
    as_json,
    db_to_read,
    open_database,
    picture_path,
    write_json,
)
from patterndb.store.connection import Mode

if TYPE_CHECKING:
    from query import Boundary, Fill

#: Names in the first lines of a table of fills.
SHOWN_WIDTHS = 24


@click.command()
@db_to_read
@as_json
def stats(db: Path | None, as_json: bool) -> int:
    """Count what a database holds.

    \b
    patterndb stats --db my.db
    """
    with open_database(db) as database:
        s = database.statistics()
    if as_json:
        document = dataclasses.asdict(s)
        document["by_sides"] = {str(k): v for k, v in s.by_sides.items()}
        document["by_irregular"] = {str(k): v for k, v in s.by_irregular.items()}
        write_json(document)
        return 0
    click.echo(f"{s.patterns:,} patterns ({s.patterns_oriented:,} with mirror images)")
    click.echo(f"{s.meshes:,} meshes, {s.patches:,} patches")
    click.echo(f"content {s.content_hash}")
    click.echo("\nsides       patterns")
    for n, count in s.by_sides.items():
        click.echo(f"{n:>5}  {count:>13,}")
    click.echo("\nirregular   patterns")
    for n, count in s.by_irregular.items():
        click.echo(f"{n:>5}  {count:>13,}")
    return 0


@click.command()
@db_to_read
@as_json
def meshes(db: Path | None, as_json: bool) -> int:
    """List the meshes a database has learned from, with author and licence.

    \b
    patterndb meshes --json
    """
    with open_database(db) as database:
        rows = database.meshes()
    if as_json:
        write_json({"meshes": [dataclasses.asdict(row) for row in rows]})
        return 0
    width = max((len(row.name) for row in rows), default=4)
    click.echo(f"{'mesh':<{width}}   quads     patches  patterns  licence, author")
    for row in rows:
        said = ", ".join(t for t in (row.provenance.licence, row.provenance.author) if t)
        click.echo(
            f"{row.name:<{width}} {row.quads_read:>7,} {row.distinct:>11,} "
            f"{row.patterns:>9,}  {said or '-'}"
        )
    return 0


@click.command()
@click.option(
    "--sides",
    type=Numbers(),
    required=True,
    help="Edges of every side, counter-clockwise.",
)
@click.option("--closed", is_flag=True, help="One closed side without a corner: --sides 12.")
@db_to_read
@click.option(
    "--limit",
    type=click.IntRange(1),
    default=20,
    show_default=True,
    metavar="N",
    help="List at most N fills.",
)
@click.option(
    "--per-pattern",
    type=click.IntRange(0),
    default=4,
    show_default=True,
    metavar="N",
    help="List at most N fills of one pattern; 0 for all.",
)
@click.option(
    "--max-irregular",
    type=click.IntRange(0),
    metavar="K",
    help="Only patterns with at most K irregular vertices.",
)
@click.option("--valence", type=Range(), help="Only irregular vertices of these valences.")
@click.option(
    "--solver",
    type=click.Choice(["kernel", "cp-sat"]),
    default="kernel",
    show_default=True,
    help="What finds the widths.",
)
@as_json
@click.option(
    "--obj",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Write every fill as DIR/fill-001.obj, flat.",
)
@click.option(
    "--image",
    type=picture_path(".png", ".svg"),
    metavar="FILE",
    help="Draw the fills as one sheet, PNG or SVG.",
)
def query(
    sides: tuple[int, ...],
    closed: bool,
    db: Path | None,
    limit: int,
    per_pattern: int,
    max_irregular: int | None,
    valence: tuple[int, int] | None,
    solver: str,
    as_json: bool,
    obj: Path | None,
    image: Path | None,
) -> int:
    """Find the fills of a boundary: fewest irregular vertices first, then most frequent.

    Exit code 1 where the database holds no fill.

    \b
    patterndb query --sides 3,5,4,6
    patterndb query --sides 8,8,8,8,8,8 --limit 100 --json
    patterndb query --sides 4,3,5 --valence 3..5 --image fills.png --obj fills/
    """
    # Imported here because compiled kernels take a moment that --help need not wait for.
    from query import Boundary, fills

    started = time.perf_counter()
    boundary = Boundary(sides, corners=()) if closed else Boundary(sides)
    with open_database(db) as database:
        found = fills(
            database,
            boundary,
            limit=limit,
            max_irregular=max_irregular,
            valence=valence,
            per_pattern=per_pattern or None,
            solver=solver,  # pyright: ignore[reportArgumentType]
        )
    seconds = time.perf_counter() - started
    if as_json:
        write_json(
            {
                "sides": list(boundary.lengths),
                "feasible_patterns": found.feasible_patterns,
                "truncated": found.truncated,
                "seconds": round(seconds, 4),
                "fills": [fill.to_json() for fill in found],
            }
        )
    elif found.fills:
        _table(found.fills)
        more = "; there are more fills than these" if found.truncated else ""
        click.echo(f"{found.feasible_patterns:,} patterns fit ({seconds:.3f} s){more}", err=True)
    if obj is not None and found.fills:
        _write_objs(obj, found.fills, boundary)
    if image is not None and found.fills:
        from patterndb.cli.pictures import fill_sheet

        for path in fill_sheet(image, found.fills, boundary):
            click.echo(f"drawn: {path}", err=True)
    if not found.fills:
        click.echo(f"no fill: {found.reason}", err=True)
        return 1
    return 0


def _table(fills: list[Fill]) -> None:
    click.echo("rank  pattern           irregular  quads    seen  rot      widths")
    for rank, fill in enumerate(fills, 1):
        widths = " ".join(str(w) for w in fill.widths[:SHOWN_WIDTHS])
        if len(fill.widths) > SHOWN_WIDTHS:
            widths += " …"
        turned = f"{fill.rotation}{' mirror' if fill.mirrored else ''}"
        click.echo(
            f"{rank:>4}  {fill.pattern.name}  {fill.n_irregular:>9}  {len(fill.quads):>5}"
            f"  {fill.pattern.frequency:>6}  {turned:<8} {widths}"
        )


def _write_objs(folder: Path, fills: list[Fill], boundary: Boundary) -> None:
    from patterndb.cli.obj import write_flat_fill

    folder.mkdir(parents=True, exist_ok=True)
    digits = max(3, len(str(len(fills))))
    for rank, fill in enumerate(fills, 1):
        write_flat_fill(folder / f"fill-{rank:0{digits}}.obj", fill, boundary)
    click.echo(f"written: {len(fills)} files in {folder}", err=True)


@click.command()
@db_to_read
@click.option("--migrate", is_flag=True, help="Bring an older database to the present schema.")
@as_json
def verify(db: Path | None, migrate: bool, as_json: bool) -> int:
    """Check a database: the file, every pattern's code, and all counts.

    Exit code 3 if anything is wrong.

    \b
    patterndb verify --db my.db
    """
    mode: Mode = "write" if migrate else "read"
    if migrate and db is None:
        raise click.UsageError("--migrate needs --db: the starter database is always up to date")
    with open_database(db, mode) as database:
        findings = database.verify()
        name = database.path
    if as_json:
        write_json({"ok": not findings, "findings": findings})
    else:
        for finding in findings:
            click.echo(finding)
        click.echo(f"{name}: {'sound' if not findings else f'{len(findings)} findings'}", err=True)
    return 3 if findings else 0


COMMANDS = (stats, meshes, query, verify)
