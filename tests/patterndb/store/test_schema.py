"""A file whose schema is not ours is refused before anything of it is run."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

import patterndb
from patterndb.errors import DatabaseError
from patterndb.store import Database, connection
from patterndb.store.connection import LARGEST_VALUE, SCHEMA_VERSION, connect
from tests.support.store.learnt import change

#: Statements, and what is said.
TAMPERED = {
    "a trigger": (
        "CREATE TRIGGER greedy AFTER INSERT ON mesh BEGIN UPDATE mesh SET licence = 'mine'; END",
        "trigger 'greedy'",
    ),
    "a view": ("CREATE VIEW liked AS SELECT * FROM usage", "view 'liked'"),
    "a table": ("CREATE TABLE notes (text TEXT)", "table 'notes'"),
    "an index": ("CREATE INDEX many ON pattern (n_quads)", "index 'many'"),
    "a view less": ("DROP VIEW counted_pattern", "lacks the view 'counted_pattern'"),
    "an index less": ("DROP INDEX occurrence_mesh", "lacks the index 'occurrence_mesh'"),
    "a column": (
        "ALTER TABLE mesh ADD COLUMN colour TEXT",
        "table 'mesh' is not as patterndb makes it",
    ),
    "a view of our name": (
        "DROP VIEW counted_pattern; CREATE VIEW counted_pattern AS SELECT * FROM mesh",
        "view 'counted_pattern' is not as patterndb makes it",
    ),
    "an endless view in place of a table": (
        "DROP TABLE usage; CREATE VIEW usage AS WITH RECURSIVE n(pattern_id) AS "
        "(SELECT 1 UNION ALL SELECT pattern_id FROM n) SELECT pattern_id, 1 AS uses FROM n",
        "view 'usage'",
    ),
    "an index over others": (
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET "
        "sql = 'CREATE INDEX occurrence_mesh ON occurrence (patches)' "
        "WHERE name = 'occurrence_mesh'",
        "index 'occurrence_mesh' is not as patterndb makes it",
    ),
    "an index of an expression": (
        "DROP INDEX occurrence_mesh; CREATE INDEX occurrence_mesh ON occurrence (hex(zeroblob(9)))",
        "index 'occurrence_mesh' is not as patterndb makes it",
    ),
    "an index that compares otherwise": (
        "CREATE INDEX by_licence ON mesh (licence COLLATE NOCASE)",
        "index 'by_licence'",
    ),
    "a table without row numbers": (
        "DROP TABLE usage; CREATE TABLE usage (pattern_id INTEGER PRIMARY KEY, uses INTEGER NOT "
        "NULL) WITHOUT ROWID",
        "table 'usage' is not as patterndb makes it",
    ),
    "a column that is computed": (
        "ALTER TABLE mesh ADD COLUMN long TEXT AS (hex(zeroblob(90000000)))",
        "table 'mesh' is not as patterndb makes it",
    ),
    "statistics with a column that is computed": (
        "ANALYZE; PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = 'CREATE TABLE "
        "sqlite_stat1(tbl AS (hex(zeroblob(1))), idx, stat)' WHERE name = 'sqlite_stat1'",
        "table 'sqlite_stat1'",
    ),
}


def test_a_schema_whose_reading_does_not_end_is_refused(
    full: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SQLite reads what ANALYZE left before anyone can look at the schema: a table of that name
    may have columns that are computed, each as large as a value may be."""
    change(full, "ANALYZE", "CREATE TABLE kept (a, b, c)")
    with sqlite3.connect(full) as held:
        held.executemany("INSERT INTO kept VALUES (1, 1, ?)", [(i,) for i in range(4000)])
        page = held.execute("SELECT rootpage FROM sqlite_schema WHERE name = 'kept'").fetchone()[0]
    statement = (
        "CREATE TABLE sqlite_stat1(a,b,c,tbl AS (hex(zeroblob(00000000+c))),idx AS (1),stat AS (1))"
    )
    change(
        full,
        "PRAGMA writable_schema = ON",
        "DELETE FROM sqlite_schema WHERE name = 'kept'",
        f"UPDATE sqlite_schema SET rootpage = {page}, sql = '{statement}' "
        "WHERE name = 'sqlite_stat1'",
    )
    spoiled = full.read_bytes().replace(b"zeroblob(00000000", b"zeroblob(60000000")
    assert spoiled != full.read_bytes()
    full.write_bytes(spoiled)
    # Without a bound this would be 480 GB of text.
    with pytest.raises(DatabaseError, match="sqlite_stat1"):
        Database(full)
    # With values that are allowed it is the clock that ends it.
    full.write_bytes(spoiled.replace(b"zeroblob(60000000", b"zeroblob(00000060"))
    monkeypatch.setattr(connection, "SECONDS_FOR_SCHEMA", 0.0)
    with pytest.raises(DatabaseError, match=r"sqlite_stat1|takes more than"):
        Database(full)


@pytest.mark.parametrize("mode", ["read", "write", "create"])
@pytest.mark.parametrize("name", TAMPERED)
def test_another_schema_is_refused_and_left_alone(full: Path, name: str, mode: str) -> None:
    statements, words = TAMPERED[name]
    change(full, *statements.split("; ")) if "BEGIN" not in statements else run(full, statements)
    before = full.read_bytes()
    with pytest.raises(DatabaseError, match="another schema") as caught:
        Database(full, mode)  # type: ignore[arg-type]
    assert words in str(caught.value)
    assert full.read_bytes() == before


def run(path: Path, script: str) -> None:
    with sqlite3.connect(path) as connection:
        connection.executescript(script)


def test_what_analyze_and_vacuum_leave_is_ours(full: Path) -> None:
    change(full, "ANALYZE", "VACUUM")
    with patterndb.open(full) as database:
        assert database.verify() == []


@pytest.mark.parametrize("version", [0, -(2**31), SCHEMA_VERSION + 1, 7, 2**31 - 1])
@pytest.mark.parametrize("mode", ["read", "write", "create"])
def test_another_version_is_rejected_with_the_remedy(full: Path, version: int, mode: str) -> None:
    change(full, f"PRAGMA user_version = {version}")
    before = full.read_bytes()
    with pytest.raises(DatabaseError, match=f"version {version} of the schema.*learn its meshes"):
        Database(full, mode)  # type: ignore[arg-type]
    assert full.read_bytes() == before


def test_comments_of_the_schema_may_change(full: Path) -> None:
    sql = "replace(sql, '-- One ', '-- A single ')"
    with sqlite3.connect(full) as held:
        held.execute("PRAGMA writable_schema = ON")
        held.execute(
            f"UPDATE sqlite_schema SET sql = replace({sql}, char(10), ' /* x */ ' || char(10))"
        )
    Database(full).close()


def test_connections_believe_little_of_a_file(full: Path) -> None:
    connection = connect(full)
    try:
        assert connection.execute("PRAGMA trusted_schema").fetchone() == (0,)
        assert connection.execute("PRAGMA cell_size_check").fetchone() == (1,)
        assert connection.getlimit(sqlite3.SQLITE_LIMIT_LENGTH) == LARGEST_VALUE
        with pytest.raises(sqlite3.DataError):
            connection.execute("SELECT zeroblob(?)", (LARGEST_VALUE + 1,)).fetchone()
    finally:
        connection.close()
