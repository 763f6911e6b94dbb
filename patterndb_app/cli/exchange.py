"""The exchange with the program of the paper's authors: import-ddq, export-ddq."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb_app.cli.database import count_patterns
from patterndb_app.cli.options import (
    Count,
    FileName,
    as_json,
    db_to_read,
    db_to_write,
    open_database,
    provenance_options,
)
from patterndb_app.cli.progressline import told_share
from patterndb_app.cli.text import plural, printable, say, write, write_json

if TYPE_CHECKING:
    from patterndb.store import PatchTable

#: Refused rows that stderr shows one by one.
SHOWN_REFUSALS = 20


@click.command("import-ddq")
@click.argument("file", metavar="FILE", type=FileName())
@db_to_write
@provenance_options("patterns")
@as_json
def import_ddq(
    file: Path,
    db: Path,
    author: str | None,
    source: str | None,
    licence: str | None,
    as_json: bool,
) -> int:
    """Add the patterns that the program of the paper's authors learned to --db.

    FILE is their SQLite database, with one table Patches. Its patterns are reduced to the end
    and merged with those that are there; its occurrences count in their frequencies. The file
    is kept like one mesh: importing it again changes nothing, and `remove` takes it out. --db
    is made if there is none.

    Every row is checked. One that is wrong is left out and told, and the exit code is 3 then,
    though the others are in.

    \b
    patterndb import-ddq patches.db --db my.db
    patterndb import-ddq patches.db --db my.db --licence "research only" --json
    """
    # Imported here because --help need not wait for it.
    from patterndb.store import Provenance, read_table
    from patterndb.store.ddq import file_hash

    said = Provenance(author, source, licence)
    if db.exists() and file.is_file():
        with open_database(db, "write") as database:
            held = database.find_mesh(file_hash(file))
            if held is not None:
                outcome = database.complete_provenance(held, said)
                patterns = count_patterns(database)
                if as_json:
                    write_json(
                        {
                            "file": held.name,
                            "sha256": held.sha256,
                            "outcome": outcome,
                            "occurrences": held.distinct,
                            "file_patterns": held.patterns,
                            "new_patterns": 0,
                            "patterns": patterns,
                        }
                    )
                else:
                    write(
                        f"{printable(held.name)}: {outcome}; {plural(patterns, 'pattern')} in {db}"
                    )
                return 0
    with told_share("reading") as progress:
        table = read_table(file, progress)
    with open_database(db, "create") as database:
        outcome, new = database.import_ddq(table, said)
        patterns = sum(database.sides_histogram().values())
    for row in table.told[:SHOWN_REFUSALS]:
        key = f" ({printable(row.key)})" if row.key else ""
        say(f"row {row.rowid}{key} left out: {printable(row.reason)}")
    if table.refused > SHOWN_REFUSALS:
        say(f"and {plural(table.refused - SHOWN_REFUSALS, 'row')} more")
    if table.unlike:
        say(
            f"{plural(table.unlike, 'row')} told another number of irregular vertices than the "
            "faces have; the faces were believed"
        )
    if as_json:
        write_json(
            {**_summary(table), "outcome": outcome, "new_patterns": new, "patterns": patterns}
        )
    else:
        write(
            f"{table.rows - table.refused:,} of {plural(table.rows, 'row')} read: "
            f"{plural(len(table.learned.codes), 'pattern')}, {new:,} of them new, "
            f"{plural(table.learned.distinct, 'occurrence')}; "
            f"{plural(patterns, 'pattern')} in {db}"
        )
    return 3 if table.refused else 0


def _summary(table: PatchTable) -> dict[str, object]:
    return {
        "file": table.name,
        "sha256": table.sha256,
        "rows": table.rows,
        "refused": table.refused,
        "refusals": [
            {"row": row.rowid, "key": row.key, "reason": row.reason} for row in table.told
        ],
        "unlike": table.unlike,
        "occurrences": table.learned.distinct,
        "file_patterns": len(table.learned.codes),
    }


@click.command("export-ddq")
@click.argument("file", metavar="FILE", type=FileName())
@db_to_read
@click.option(
    "--digits",
    type=Count(1, 16),
    metavar="N",
    help="Hexadecimal digits of every face; the authors' program reads 16.  "
    "[default: the fewest that a row needs]",
)
@as_json
def export_ddq(file: Path, db: Path | None, digits: int | None, as_json: bool) -> int:
    """Write the patterns of a database for the program of the paper's authors.

    FILE is a new SQLite file with one table Patches. A pattern and its mirror image are two
    rows there, each with the occurrences of its own. What was only used is left out.

    \b
    patterndb export-ddq patches.db --db my.db --digits 16
    """
    with open_database(db) as database, told_share("writing") as progress:
        done = database.export_ddq(file, digits=digits, progress=progress)
    if as_json:
        write_json(
            {
                "file": file.name,
                "patterns": done.patterns,
                "rows": done.rows,
                "occurrences": done.occurrences,
            }
        )
    else:
        write(
            f"{plural(done.patterns, 'pattern')} in {plural(done.rows, 'row')}, "
            f"{plural(done.occurrences, 'occurrence')}: {file}"
        )
    return 0
