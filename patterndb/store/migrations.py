"""The schema's version, and the steps from older ones.

``schema.sql`` is the present schema and the only place it stands. A step is added here,
never edited once released, whenever the schema changes: MIGRATIONS[n] brings a database of
version n - 1 to version n.
"""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Callable, Mapping
from functools import partial
from importlib.resources import files
from pathlib import Path

from patterndb.core.code import format_id
from patterndb.core.shortcode import shorten
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store.checksums import (
    read_sums,
    select_rows,
    sum_occurrences,
    sum_rows,
    write_occurrence_sum,
    write_sum,
)
from patterndb.store.columns import read_in_parts
from patterndb.store.tallies import tally_anew
from patterndb.store.writing import describe_patterns

_log = logging.getLogger("patterndb")

APPLICATION_ID = 0x50617444
SCHEMA_VERSION = 7

#: Step 2: how often fills were used, and where patterns come from.
_STEP_2 = """
ALTER TABLE mesh ADD COLUMN
    origin TEXT NOT NULL DEFAULT 'learned' CHECK (origin IN ('learned', 'imported'));
ALTER TABLE pattern ADD COLUMN
    origin TEXT NOT NULL DEFAULT 'learned'
    CHECK (origin IN ('learned', 'imported', 'family', 'constructed'));
CREATE TABLE usage (
    pattern_id INTEGER PRIMARY KEY REFERENCES pattern (id),
    uses       INTEGER NOT NULL CHECK (uses >= 1),
    origin     TEXT    NOT NULL
               CHECK (origin IN ('learned', 'imported', 'family', 'constructed'))
) STRICT;
DROP TRIGGER occurrence_added;
DROP TRIGGER occurrence_removed;
DROP TRIGGER occurrence_changed;
CREATE TRIGGER occurrence_added AFTER INSERT ON occurrence BEGIN
    UPDATE pattern SET
        frequency = frequency + NEW.patches,
        origin = CASE
            WHEN (SELECT origin FROM mesh WHERE id = NEW.mesh_id) = 'learned' THEN 'learned'
            ELSE (
                SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
                WHERE pattern_id = NEW.pattern_id
            )
        END
    WHERE id = NEW.pattern_id;
END;

CREATE TRIGGER occurrence_removed AFTER DELETE ON occurrence BEGIN
    UPDATE pattern SET
        frequency = frequency - OLD.patches,
        origin = coalesce(
            (
                SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
                WHERE pattern_id = OLD.pattern_id
            ),
            (SELECT origin FROM usage WHERE pattern_id = OLD.pattern_id),
            origin
        )
    WHERE id = OLD.pattern_id;
END;

CREATE TRIGGER occurrence_changed AFTER UPDATE ON occurrence BEGIN
    UPDATE pattern SET
        frequency = frequency - OLD.patches,
        origin = coalesce(
            (
                SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
                WHERE pattern_id = OLD.pattern_id
            ),
            (SELECT origin FROM usage WHERE pattern_id = OLD.pattern_id),
            origin
        )
    WHERE id = OLD.pattern_id;
    UPDATE pattern SET
        frequency = frequency + NEW.patches,
        origin = (
            SELECT max(mesh.origin) FROM occurrence JOIN mesh ON mesh.id = mesh_id
            WHERE pattern_id = NEW.pattern_id
        )
    WHERE id = NEW.pattern_id;
END;
"""

#: Step 3: sums of the rows of each table, by which silent changes are found.
_STEP_3 = """
CREATE TABLE checksum (
    name  TEXT PRIMARY KEY,
    total BLOB NOT NULL CHECK (length(total) = 16)
) STRICT, WITHOUT ROWID;
INSERT INTO checksum VALUES
    ('mesh', zeroblob(16)), ('occurrence', zeroblob(16)), ('usage', zeroblob(16));
"""

#: Columns of a pattern that there were up to version 3.
DROPPED = (
    *("corners", "valences", "n_chords", "n_loops", "self_crossing", "rotations"),
    *("label", "sig_rotation", "sig_reflected", "lengths", "joins"),
)

#: Step 4: codes are short, and most of what follows from them is no longer stored.
_STEP_4 = "\n".join(f"ALTER TABLE pattern DROP COLUMN {column};" for column in DROPPED)

#: Step 5: a mesh may be learned with a limit of its patterns.
_STEP_5 = """
ALTER TABLE mesh ADD COLUMN
    pattern_limit INTEGER NOT NULL DEFAULT 0 CHECK (pattern_limit >= 0);
ALTER TABLE mesh ADD COLUMN
    patterns_left_out INTEGER NOT NULL DEFAULT 0 CHECK (patterns_left_out >= 0);
"""

#: Step 6: occurrences have a sum for each mesh, of which the content hash is made.
_STEP_6 = """
ALTER TABLE mesh ADD COLUMN
    occurrence_sum BLOB NOT NULL DEFAULT x'00000000000000000000000000000000'
    CHECK (length(occurrence_sum) = 16);
"""

#: Step 7: counts that every write keeps.
_STEP_7 = """
CREATE TABLE tally (
    n_sides     INTEGER NOT NULL,
    n_irregular INTEGER NOT NULL,
    chiral      INTEGER NOT NULL CHECK (chiral IN (0, 1)),
    patterns    INTEGER NOT NULL CHECK (patterns >= 0),
    PRIMARY KEY (n_sides, n_irregular, chiral)
) STRICT, WITHOUT ROWID;
CREATE TABLE signature (
    id      INTEGER PRIMARY KEY,
    n_sides INTEGER NOT NULL,
    hashes  BLOB    NOT NULL CHECK (length(hashes) > 0 AND length(hashes) % 8 = 0)
) STRICT;
CREATE TABLE handedness (
    met INTEGER NOT NULL CHECK (met >= 0)
) STRICT;
INSERT INTO handedness VALUES (0);
"""

MIGRATIONS: Mapping[int, str] = {
    2: _STEP_2,
    3: _STEP_3,
    4: _STEP_4,
    5: _STEP_5,
    6: _STEP_6,
    7: _STEP_7,
}

#: What versions 3 to 5 summed of a table.
_SELECT_OCCURRENCES_5 = (
    "SELECT pattern_id, mesh_id, patches, mirrored_patches, example FROM occurrence"
)
_SELECT_USAGE_5 = "SELECT pattern_id, uses, origin FROM usage"
_SELECT_MESHES_5 = (
    "SELECT id, sha256, name, author, source, licence, basic_limit, side_limit, convex_limit, "
    "prepared, quads_read, quads_used, basic_patches, side_patches, convex_patches, "
    "distinct_patches, origin, pattern_limit, patterns_left_out FROM mesh"
)

#: Patterns that step 4 writes anew at a time.
_REWRITTEN_AT_ONCE = 10_000


def _shorten_codes(connection: sqlite3.Connection) -> None:
    """Write what step 4 stores in place of packed codes and signatures."""
    for rows in read_in_parts(connection, "SELECT id, code FROM pattern", _REWRITTEN_AT_ONCE):
        try:
            described = describe_patterns(shorten([code for _, code in rows]))
        except InvalidCodeError as error:
            assert error.row is not None
            raise DatabaseError(
                f"pattern {format_id(rows[error.row][0])} is damaged ({error}), so that the "
                "database cannot be brought to the present schema; 'patterndb verify' of the "
                "patterndb that made it tells what is wrong with the whole file"
            ) from error
        connection.executemany(
            "UPDATE pattern SET code = ?, signature = ? WHERE id = ?",
            [
                (columns[0], columns[-1], number)
                for (number, _), (_, columns) in zip(rows, described, strict=True)
            ],
        )


def _write_sums(connection: sqlite3.Connection, selects: Mapping[str, str]) -> None:
    """Sum tables, each as a statement reads it."""
    for table, select in selects.items():
        write_sum(connection, table, sum_rows(connection.execute(select)))


def _sum_by_mesh(connection: sqlite3.Connection) -> None:
    """Write what step 6 stores: sums of the occurrences of each mesh, and of meshes with these.

    Where rows do not add up to the sum they had, they get none that fits: verify shall still tell.
    """
    held = read_sums(connection)
    meshes = sum_rows(connection.execute(_SELECT_MESHES_5))
    if held.get("occurrence") == sum_rows(connection.execute(_SELECT_OCCURRENCES_5)):
        for mesh_id, total in sum_occurrences(connection).items():
            write_occurrence_sum(connection, mesh_id, total)
    if held.get("mesh") == meshes:
        write_sum(connection, "mesh", sum_rows(select_rows(connection, "mesh")))
    connection.execute("DELETE FROM checksum WHERE name = 'occurrence'")


#: What a step does beside its statements, in the same transaction.
WORK: Mapping[int, Callable[[sqlite3.Connection], None]] = {
    # Rows of meshes are summed with the columns of step 5, once they have them.
    3: partial(
        _write_sums, selects={"occurrence": _SELECT_OCCURRENCES_5, "usage": _SELECT_USAGE_5}
    ),
    4: _shorten_codes,
    5: partial(_write_sums, selects={"mesh": _SELECT_MESHES_5}),
    6: _sum_by_mesh,
    7: tally_anew,
}

#: Steps after which most of the file is free, and given back: they write all of it anew.
SHRINKING = {4}

#: Steps that look at every row, and the patterns from which on they are told before they begin:
#: more than a second or two is to be expected then.
WORTH_TELLING: Mapping[int, int] = {4: 10_000, 6: 200_000, 7: 500_000}


def schema() -> str:
    """The text of schema.sql, from the installed package or from the checkout."""
    packaged = files("patterndb") / "schema.sql"
    if packaged.is_file():
        return packaged.read_text(encoding="utf-8")
    return (Path(__file__).parents[2] / "schema.sql").read_text(encoding="utf-8")


def create(connection: sqlite3.Connection) -> None:
    """Make an empty database; a crash on the way leaves an empty file."""
    connection.executescript(f"BEGIN IMMEDIATE;\n{schema()}\nCOMMIT;")


def migrate(
    connection: sqlite3.Connection,
    steps: Mapping[int, str] = MIGRATIONS,
    target: int = SCHEMA_VERSION,
) -> list[int]:
    """Apply the steps that are missing, each in one transaction with its own number."""
    done: list[int] = []
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    for number in range(version + 1, target + 1):
        if number in WORTH_TELLING:
            (patterns,) = connection.execute("SELECT count(*) FROM pattern").fetchone()
            if patterns >= WORTH_TELLING[number]:
                _log.warning(
                    "patterndb is bringing a database of %s patterns to schema %d, once: "
                    "that may take a minute",
                    f"{patterns:,}",
                    number,
                )
        try:
            connection.executescript(
                f"BEGIN IMMEDIATE;\n{steps[number]}\n;PRAGMA user_version = {number:d};"
            )
            if number in WORK:
                WORK[number](connection)
            connection.execute("COMMIT")
        except BaseException:
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            if connection.execute("PRAGMA user_version").fetchone()[0] >= number:
                continue  # another process took the step while this one waited to
            raise
        done.append(number)
    if SHRINKING.intersection(done):
        connection.execute("VACUUM")
    return done
