"""A file whose schema is not ours is refused before anything of it is run."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from learnt import change

import patterndb
from patterndb.errors import DatabaseError
from patterndb.store import Database
from patterndb.store.connection import LARGEST_VALUE, connect
from patterndb.store.migrations import SCHEMA_VERSION, migrate
from patterndb.store.schemacheck import find_schema_change

SCHEMA_1 = (Path(__file__).parent / "schema_1.sql").read_text(encoding="utf-8")

#: Statements, and what is said.
TAMPERED = {
    "a trigger": (
        "CREATE TRIGGER greedy AFTER INSERT ON mesh BEGIN UPDATE mesh SET licence = 'mine'; END",
        "trigger 'greedy'",
    ),
    "a view": ("CREATE VIEW liked AS SELECT * FROM usage", "view 'liked'"),
    "a table": ("CREATE TABLE notes (text TEXT)", "table 'notes'"),
    "an index": ("CREATE INDEX many ON pattern (n_quads)", "index 'many'"),
    "a trigger less": ("DROP TRIGGER occurrence_changed", "no trigger 'occurrence_changed'"),
    "an index less": ("DROP INDEX occurrence_mesh", "no index 'occurrence_mesh'"),
    "a column": ("ALTER TABLE mesh ADD COLUMN colour TEXT", "table 'mesh' is not as we make it"),
    "a trigger of our name": (
        "DROP TRIGGER occurrence_changed; CREATE TRIGGER occurrence_changed AFTER UPDATE ON "
        "occurrence BEGIN DELETE FROM mesh; END",
        "trigger 'occurrence_changed' is not as we make it",
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
        "index 'occurrence_mesh' is not as we make it",
    ),
}


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


def test_a_migrated_schema_is_ours(tmp_path: Path) -> None:
    old = sqlite3.connect(":memory:", isolation_level=None)
    old.executescript(SCHEMA_1)
    assert find_schema_change(old, 1) is None
    migrate(old)
    assert find_schema_change(old) is None


def test_an_old_file_with_a_foreign_trigger_is_refused_before_it_is_migrated(
    tmp_path: Path,
) -> None:
    path = tmp_path / "old.db"
    run(path, SCHEMA_1)
    run(path, TAMPERED["a trigger"][0])
    before = path.read_bytes()
    with pytest.raises(DatabaseError, match="trigger 'greedy'"):
        Database(path, "write")
    assert path.read_bytes() == before


def test_what_analyze_and_vacuum_leave_is_ours(full: Path) -> None:
    change(full, "ANALYZE", "VACUUM")
    with patterndb.open(full) as database:
        assert database.verify() == []


@pytest.mark.parametrize("version", [0, -1, -(2**31), SCHEMA_VERSION + 1, 2**31 - 1])
@pytest.mark.parametrize("mode", ["read", "write", "create"])
def test_a_version_that_never_was_is_told(full: Path, version: int, mode: str) -> None:
    change(full, f"PRAGMA user_version = {version}")
    with pytest.raises(DatabaseError, match=f"schema {version}"):
        Database(full, mode)  # type: ignore[arg-type]


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
