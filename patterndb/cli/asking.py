"""The verbs that ask: stats, meshes, query, verify."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb.cli.failure import EXIT_BAD_INPUT, EXIT_NOTHING
from patterndb.cli.options import (
    FileName,
    Numbers,
    as_json,
    boundary_of,
    db_to_read,
    max_irregular_option,
    open_database,
    picture_path,
    valence_option,
)
from patterndb.cli.text import (
    plural,
    printable,
    say,
    shortened,
    table,
    write,
    write_json,
    write_json_with,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from query import Boundary, Fill

#: Characters of a mesh's name in a table; the rest of the line is its licence and author.
SHOWN_NAME = 40


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
    write(f"{plural(s.patterns, 'pattern')}, {s.patterns_oriented:,} with mirror images")
    write(f"{plural(s.meshes, 'mesh', 'meshes')}, {plural(s.patches, 'patch', 'patches')}")
    write(f"content {s.content_hash}")
    for head, counts in (("sides", s.by_sides), ("irregular", s.by_irregular)):
        if counts:
            write("\n" + table((head, "patterns"), list(counts.items())))
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
    lines: list[tuple[object, ...]] = []
    for row in rows:
        said = (row.provenance.licence, row.provenance.author, row.provenance.source)
        lines.append(
            (
                shortened(printable(row.name), SHOWN_NAME),
                row.quads_read,
                row.distinct,
                row.patterns,
                ", ".join(text for text in said if text) or "-",
            )
        )
    write(table(("mesh", "quads", "patches", "patterns", "licence, author, source"), lines))
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
@max_irregular_option
@valence_option
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
    type=FileName(),
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
    if obj is not None and obj.exists() and not obj.is_dir():
        raise click.BadParameter(f"{obj} is a file; name a folder", param_hint="'--obj'")
    # Imported here because compiled kernels take a moment that --help need not wait for.
    from query import fills

    started = time.perf_counter()
    boundary = boundary_of(sides, closed)
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
        document = {
            "sides": list(boundary.lengths),
            "feasible_patterns": found.feasible_patterns,
            "truncated": found.truncated,
            "reason": found.reason,
            "seconds": round(seconds, 4),
        }
        write_json_with(document, "fills", (fill.to_json() for fill in found))
    elif found.fills:
        write(_fill_table(found.fills))
        fit = "pattern fits" if found.feasible_patterns == 1 else "patterns fit"
        more = "; there are more fills than these (--limit, --per-pattern)"
        say(f"{found.feasible_patterns:,} {fit} ({seconds:.2f} s){more if found.truncated else ''}")
    if obj is not None and found.fills:
        _write_objs(obj, found.fills, boundary)
    if image is not None and found.fills:
        from patterndb.cli.pictures import fill_sheet

        for path in fill_sheet(image, found.fills, boundary):
            say(f"drawn: {path}")
    if not found.fills:
        say(f"no fill: {found.reason}")
        return EXIT_NOTHING
    return 0


def _fill_table(fills: Sequence[Fill]) -> str:
    heads = ("rank", "pattern", "irregular", "quads", "seen", "turned", "widths")
    return table(
        heads,
        [
            (
                rank,
                fill.pattern.name,
                fill.n_irregular,
                len(fill.quads),
                fill.pattern.frequency,
                f"{fill.rotation} mirrored" if fill.mirrored else str(fill.rotation),
                " ".join(map(str, fill.widths)),
            )
            for rank, fill in enumerate(fills, 1)
        ],
    )


def _write_objs(folder: Path, fills: Sequence[Fill], boundary: Boundary) -> None:
    from patterndb.cli.obj import write_flat_fill

    folder.mkdir(parents=True, exist_ok=True)
    digits = max(3, len(str(len(fills))))
    for rank, fill in enumerate(fills, 1):
        write_flat_fill(folder / f"fill-{rank:0{digits}}.obj", fill, boundary)
    say(f"written: {plural(len(fills), 'file')} in {folder}")


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
    if migrate and db is None:
        raise click.UsageError("--migrate needs --db: the starter database is always up to date")
    with open_database(db, "write" if migrate else "read") as database:
        findings = database.verify()
        name = database.path
    if as_json:
        write_json({"ok": not findings, "findings": findings})
    else:
        for finding in findings:
            write(finding)
        say(f"{name}: {plural(len(findings), 'finding') if findings else 'sound'}")
    return EXIT_BAD_INPUT if findings else 0


COMMANDS = (stats, meshes, query, verify)
