"""Spoil databases in every way, and see what becomes of the answers.

Each file is a copy of a sound database that was spoiled once: bits flipped, pages swapped, sectors
zeroed, cut short, a hostile value in a column, or the schema tampered with. Then it is asked what
verbs ask: to be opened, classes, strict fills, statistics, meshes, occurrences, verify, a write.
An answer must be that of the sound database, or an error of ours.
"""

from __future__ import annotations

import contextlib
import random
import sqlite3
import traceback
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from patterndb.errors import PatternDBError
from patterndb.store import Database
from query import fills

TABLES = ("mesh", "pattern", "occurrence", "usage")

#: Of tables without row ids.
KEYS = {"occurrence": "pattern_id, mesh_id"}
VALUES = (
    "NULL",
    "0",
    "-1",
    "1",
    "127",
    "1 << 31",
    "-(1 << 62)",
    "9223372036854775807",
    "0.5",
    "1e300",
    "''",
    "'x'",
    "CAST(x'ff00fe' AS TEXT)",
    "x''",
    "x'00'",
    "x'05'",
    "x'ff'",
    "x'ffffffff07'",
    "x'ffffffffffffffffffff01'",
    "zeroblob(100000)",
    "randomblob(40)",
)
TAMPERING = (
    "CREATE TRIGGER greedy AFTER INSERT ON mesh BEGIN UPDATE mesh SET licence = 'x'; END",
    "CREATE TRIGGER endless AFTER INSERT ON usage BEGIN DELETE FROM mesh; END",
    "DROP TABLE usage; CREATE VIEW usage AS WITH RECURSIVE n(pattern_id) AS "
    "(SELECT 1 UNION ALL SELECT pattern_id FROM n) SELECT pattern_id, 1 AS uses, 'x' AS origin "
    "FROM n",
    "DROP VIEW counted_pattern",
    "DROP INDEX occurrence_mesh",
    "DROP TABLE occurrence",
    "ALTER TABLE mesh ADD COLUMN colour TEXT",
    "ALTER TABLE mesh RENAME COLUMN name TO title",
    "PRAGMA user_version = -7",
    "PRAGMA user_version = 2147483647",
    "PRAGMA user_version = 7",
    "PRAGMA application_id = 7",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = 'nonsense' WHERE name = 'mesh'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = 2 WHERE name = 'pattern'",
)


def flip_bits(path: Path, chance: random.Random) -> None:
    data = bytearray(path.read_bytes())
    for _ in range(chance.choice([1, 1, 1, 2, 8, 64])):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    path.write_bytes(data)


def swap_pages(path: Path, chance: random.Random) -> None:
    data = path.read_bytes()
    size = int.from_bytes(data[16:18], "big")
    pages = [data[i : i + size] for i in range(0, len(data), size)]
    a, b = chance.sample(range(len(pages)), 2)
    pages[a], pages[b] = pages[b], pages[a]
    path.write_bytes(b"".join(pages))


def zero_sector(path: Path, chance: random.Random) -> None:
    data = bytearray(path.read_bytes())
    at = 512 * chance.randrange(len(data) // 512)
    data[at : at + 512] = bytes(512)
    path.write_bytes(data)


def cut_short(path: Path, chance: random.Random) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: chance.randrange(len(data))])


def set_value(path: Path, chance: random.Random) -> None:
    """Put a value into one row of a column, past types and checks; the schema stays."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        table = chance.choice(TABLES)
        columns = [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]
        column = chance.choice(columns)
        (sql,) = connection.execute(
            "SELECT sql FROM sqlite_schema WHERE name = ?", (table,)
        ).fetchone()
        _set_schema(
            connection,
            table,
            sql.replace("NOT NULL", "").replace("STRICT, ", "").replace(") STRICT", ")"),
        )
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA ignore_check_constraints = ON")
        key = KEYS.get(table, "rowid")
        row = connection.execute(
            f"SELECT {key} FROM {table} LIMIT 1 OFFSET ? % (SELECT count(*) FROM {table})",
            (chance.randrange(1 << 30),),
        ).fetchone()
        where = " AND ".join(f"{name} = ?" for name in key.split(", "))
        # A key that cannot be so leaves the file sound.
        with contextlib.suppress(sqlite3.Error):
            connection.execute(
                f"UPDATE {table} SET {column} = {chance.choice(VALUES)} WHERE {where}",
                row,
            )
    _restore_schema(path)


def tamper(path: Path, chance: random.Random) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(chance.choice(TAMPERING))


def _set_schema(connection: sqlite3.Connection, name: str, sql: str) -> None:
    connection.execute("PRAGMA writable_schema = ON")
    connection.execute("UPDATE sqlite_schema SET sql = ? WHERE name = ?", (sql, name))


def _restore_schema(path: Path) -> None:
    from patterndb.store.connection import read_schema

    with closing(sqlite3.connect(":memory:")) as fresh:
        fresh.executescript(read_schema())
        whole = fresh.execute("SELECT type, name, sql FROM sqlite_schema").fetchall()
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        for kind, name, sql in whole:
            if kind == "table":
                _set_schema(connection, name, sql)


WAYS: dict[str, Callable[[Path, random.Random], None]] = {
    "bits": flip_bits,
    "pages": swap_pages,
    "sector": zero_sector,
    "cut": cut_short,
    "value": set_value,
    "schema": tamper,
}


def ask_everything(path: Path) -> list[str]:
    """What a database answers, or the errors of ours that it gives, question by question."""
    answers: list[str] = []

    def ask(name: str, question: Callable[[], object]) -> None:
        try:
            answers.append(f"{name}: {question()}")
        except PatternDBError as error:
            answers.append(f"{name}: error {error}")

    def query(database: Database, n_sides: int) -> object:
        # An even perimeter: one side longer than the others where their number is odd.
        lengths = (3,) * (n_sides - 1) + (3 + n_sides % 2,)
        return [(f.pattern.name, f.widths) for f in fills(database, lengths, strict=True, limit=3)]

    try:
        with Database(path) as database:
            sides = range(9)
            for n in sides:
                ask(f"class {n}", lambda n=n: _tell_class(database, n))
            ask("fills", lambda: query(database, 5))
            ask("statistics", database.statistics)
            ask("meshes", database.meshes)
            ask("uses", database.uses)
            ask("ids", lambda: database.pattern_ids(None).tolist())
            ask("occurrences", lambda: _tell_occurrences(database))
            ask("verify", database.verify)
        with Database(path, "write") as database:
            ask("write", lambda: database.remove([database.meshes()[0].name]))
    except PatternDBError as error:
        answers.append(f"open: error {error}")
    return answers


def _tell_class(database: Database, n_sides: int) -> object:
    held = database.pattern_class(n_sides)
    return [
        (pattern.name, pattern.frequency, pattern.origin, uses, meshes)
        for pattern, uses, meshes in zip(
            (held.pattern(row) for row in range(len(held))),
            held.uses.tolist(),
            held.n_meshes.tolist(),
            strict=True,
        )
    ]


def _tell_occurrences(database: Database) -> object:
    return [
        database.occurrences(database.pattern(f"{number:016x}"))
        for number in database.pattern_ids(None).tolist()
    ]


def read_content(path: Path) -> object:
    """All rows as they stand; None where SQLite cannot read them."""
    try:
        with closing(sqlite3.connect(path)) as connection:
            connection.text_factory = bytes
            if connection.execute("SELECT 1 FROM sqlite_schema WHERE type = 'view'").fetchone():
                return None  # it may never end
            rows = (connection.execute(f"SELECT * FROM {table}") for table in TABLES)
            return [sorted(map(repr, held)) for held in rows]
    except (sqlite3.Error, UnicodeDecodeError):  # a message may quote what is no text
        return None


def judge(path: Path, sound: list[str], content: object) -> tuple[str, str]:
    """What became of a spoiled file, in a word, and the particulars."""
    changed = read_content(path) != content
    try:
        answers = ask_everything(path)
    except Exception:
        return "unforeseen", traceback.format_exc(limit=-3)
    told = any(": error" in answer for answer in answers)
    found = any(a.startswith("verify") and a != "verify: []" for a in answers)
    if told or found:
        return "refused" if told else "found", ""
    if not changed:
        return "unchanged", ""
    return "unseen", "; ".join(a[:200] for a in answers if a not in sound)
