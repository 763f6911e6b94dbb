"""The verbs that ask about a database: stats, meshes, verify."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb_app.cli.failure import EXIT_BAD_INPUT
from patterndb_app.cli.options import as_json, db_to_read, open_database
from patterndb_app.cli.text import plural, printable, say, shortened, table, write, write_json

if TYPE_CHECKING:
    pass

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


COMMANDS = (stats, meshes, verify)
