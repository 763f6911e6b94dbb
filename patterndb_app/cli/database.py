"""The verbs that look after a database: stats, meshes, verify, merge, remove."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb.errors import PatternDBError
from patterndb_app.cli.failure import EXIT_BAD_INPUT
from patterndb_app.cli.options import FileName, as_json, db_to_read, db_to_write, open_database
from patterndb_app.cli.text import plural, printable, say, shorten, table, write, write_json

if TYPE_CHECKING:
    from patterndb.store import Database, Mesh

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
        # The other counts, which the text does not have, take most of the time.
        s = database.statistics(signatures=as_json)
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
                shorten(printable(row.name), SHOWN_NAME),
                row.quads_read,
                row.distinct,
                _tell_patterns(row),
                ", ".join(text for text in said if text) or "-",
            )
        )
    write(table(("mesh", "quads", "patches", "patterns", "licence, author, source"), lines))
    return 0


def _tell_patterns(mesh: Mesh) -> int | str:
    """The number of a mesh's patterns, and of how many where some were left out."""
    if not mesh.left_out:
        return mesh.patterns
    return f"{mesh.patterns:,} of {mesh.patterns + mesh.left_out:,}"


@click.command()
@db_to_read
@click.option(
    "--repair",
    type=FileName(),
    metavar="NEW",
    help="Recover what is sound in a damaged database into a new file, and report what is lost.",
)
@as_json
def verify(db: Path | None, repair: Path | None, as_json: bool) -> int:
    """Check a database: the file, every pattern's code, and all counts.

    Exit code 3 if anything is wrong. A damaged file is never changed: --repair writes another.

    \b
    patterndb verify --db my.db
    patterndb verify --db damaged.db --repair saved.db
    """
    if repair is not None:
        if db is None:
            raise click.UsageError("--repair needs --db")
        return _recover(db, repair, as_json)
    with open_database(db) as database:
        findings = database.verify()
        name = database.path
    if as_json:
        write_json({"ok": not findings, "findings": findings})
    else:
        for finding in findings:
            write(finding)
        say(f"{name}: {plural(len(findings), 'finding') if findings else 'sound'}")
    return EXIT_BAD_INPUT if findings else 0


def _recover(db: Path, into: Path, as_json: bool) -> int:
    """Recover what is sound in a database into a new file, and report what became of the rest."""
    # Imported here because --help need not wait for it.
    from patterndb.store.recovery import recover_database

    found = recover_database(db, into)
    if as_json:
        document = dataclasses.asdict(found) | {"ok": found.is_whole, "file": str(into)}
        write_json(document)
        return 0 if found.is_whole else EXIT_BAD_INPUT
    for name, reasons in found.lost.items():
        for why, count in reasons.most_common():
            write(f"{name}: {plural(count, 'row')} not recovered: {printable(why)}")
    for name in found.unreadable:
        write(f"{name}: some rows cannot be read")
    for name in found.incomplete:
        write(f"incomplete: {printable(name)}; remove and ingest it to learn it again")
    saved = found.saved
    say(
        f"{into}: {plural(saved['mesh'], 'mesh', 'meshes')}, "
        f"{plural(saved['pattern'], 'pattern')}, {plural(saved['occurrence'], 'occurrence')}, "
        f"{plural(saved['usage'], 'pattern')} with uses; "
        + ("all that was there" if found.is_whole else "what is sound")
    )
    return 0 if found.is_whole else EXIT_BAD_INPUT


@click.command()
@click.argument("others", nargs=-1, metavar="OTHER...", type=FileName())
@db_to_write
@click.option("--starter", is_flag=True, help="Add the starter database, too.")
@as_json
def merge(others: tuple[Path, ...], db: Path, starter: bool, as_json: bool) -> int:
    """Add the meshes of other databases to --db, which is made if there is none.

    The result is what ingesting all their meshes would give. A mesh that both hold with
    different options is taken from OTHER.

    \b
    patterndb merge mine.db yours.db --db ours.db
    patterndb merge --starter --db my.db
    """
    if not others and not starter:
        raise click.UsageError("name the databases to add, or give --starter")
    added = replaced = same = 0
    with contextlib.ExitStack() as stack:
        stack.enter_context(leaving_no_empty_database(db))
        # All are opened before anything is written, so that a wrong name changes nothing.
        names = (*others, None) if starter else others
        sources = [stack.enter_context(open_database(path)) for path in names]
        database = stack.enter_context(open_database(db, "create"))
        for other in sources:
            counts = database.merge(other)
            added, replaced, same = added + counts[0], replaced + counts[1], same + counts[2]
        patterns = count_patterns(database)
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
        patterns = count_patterns(database)
    if as_json:
        write_json({"meshes": n_meshes, "patterns_removed": n_patterns, "patterns": patterns})
    else:
        write(
            f"{plural(n_meshes, 'mesh', 'meshes')} and {plural(n_patterns, 'pattern')} removed; "
            f"{plural(patterns, 'pattern')} left in {db}"
        )
    return 0


@click.command()
@click.argument("first", metavar="A", type=FileName())
@click.argument("second", metavar="[B]", required=False, type=FileName())
@as_json
def diff(first: Path, second: Path | None, as_json: bool) -> int:
    """Compare two databases: what only one of them holds, and what was counted differently.

    B is the starter database if not given. Exit code 0 whether they differ or not; --json says in
    "alike" whether they do.

    \b
    patterndb diff mine.db yours.db
    patterndb diff mine.db --json
    """
    # Imported here because --help need not wait for it.
    from patterndb.core.code import format_id
    from patterndb.store.database import compare_databases

    with open_database(first) as one, open_database(second) as other:
        found = compare_databases(one, other)
    names = [str(first), "the starter database" if second is None else str(second)]
    if as_json:
        alone = [
            {
                "database": name,
                "meshes": [mesh.name for mesh in meshes],
                "patterns": [format_id(number) for number in ids.tolist()],
            }
            for name, meshes, ids in zip(names, found.meshes, found.ids, strict=True)
        ]
        write_json(
            {
                "alike": found.alike,
                "alone": alone,
                "retaught": [mesh.name for mesh in found.retaught],
                "patterns_of_both": found.both,
                "recounted": [format_id(number) for number in found.recounted.tolist()],
            }
        )
        return 0
    if found.alike:
        write(f"{names[0]} and {names[1]} hold the same")
        return 0
    for name, meshes, ids in zip(names, found.meshes, found.ids, strict=True):
        write(
            f"{name} alone: {plural(len(meshes), 'mesh', 'meshes')}, {plural(len(ids), 'pattern')}"
        )
        for mesh in meshes:
            write(f"  {printable(mesh.name)}")
    write(
        f"both: {plural(found.both, 'pattern')}, {len(found.recounted):,} of them seen in "
        "different numbers of patches"
    )
    for mesh in found.retaught:
        write(f"  {printable(mesh.name)}: learned with different options")
    return 0


@contextlib.contextmanager
def leaving_no_empty_database(db: Path) -> Generator[None]:
    """Remove the database that the block makes, where an error ends it before anything is in it."""
    fresh = not db.exists()
    try:
        yield
    except (PatternDBError, OSError):
        if fresh and db.exists() and _has_no_mesh(db):
            db.unlink()
        raise


def _has_no_mesh(db: Path) -> bool:
    if not db.stat().st_size:
        return True
    with open_database(db) as database:
        return not database.meshes()


def count_patterns(database: Database) -> int:
    """Count the patterns; statistics() would count all signatures as well."""
    return sum(database.sides_histogram().values())
