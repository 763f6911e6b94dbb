from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from learnt import change

from patterndb.errors import DatabaseError
from patterndb.store import Database, connection
from patterndb.store.migrations import MIGRATIONS, SCHEMA_VERSION, migrate, schema

STEPS = {
    2: "ALTER TABLE mesh ADD COLUMN poly_count INTEGER;",
    3: "CREATE TABLE note (text TEXT); INSERT INTO note VALUES ('step 3')",
}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    Database(tmp_path / "old.db", "create").close()
    return tmp_path / "old.db"


def opened(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, isolation_level=None)


def version(path: Path) -> int:
    return opened(path).execute("PRAGMA user_version").fetchone()[0]


def tables(path: Path) -> set[str]:
    return {row[0] for row in opened(path).execute("SELECT name FROM sqlite_schema")}


def test_every_version_has_a_step() -> None:
    assert set(MIGRATIONS) == set(range(2, SCHEMA_VERSION + 1))


def test_the_schema_stands_in_one_file_and_has_the_present_version() -> None:
    fresh = sqlite3.connect(":memory:")
    fresh.executescript(schema())
    assert fresh.execute("PRAGMA user_version").fetchone() == (SCHEMA_VERSION,)


def test_missing_steps_are_applied_in_order(path: Path) -> None:
    assert migrate(opened(path), STEPS, 3) == [2, 3]
    assert version(path) == 3
    assert opened(path).execute("SELECT text FROM note").fetchall() == [("step 3",)]
    assert migrate(opened(path), STEPS, 3) == []


def test_each_step_is_committed_with_its_number(path: Path) -> None:
    """The third fails half-way: the second stays, with its number; the third leaves nothing."""
    steps = {**STEPS, 3: "CREATE TABLE half (a); INSERT INTO nowhere VALUES (1);"}
    held = opened(path)
    with pytest.raises(sqlite3.OperationalError, match="nowhere"):
        migrate(held, steps, 3)
    assert not held.in_transaction
    assert version(path) == 2
    assert "half" not in tables(path)
    assert migrate(opened(path), STEPS, 3) == [3]
    assert "note" in tables(path)


def test_an_older_database_is_brought_up_by_opening_it_for_writing(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "SCHEMA_VERSION", SCHEMA_VERSION + 1)
    with pytest.raises(DatabaseError, match="open it once for writing"):
        Database(path)
    done: list[sqlite3.Connection] = []

    def step(held: sqlite3.Connection) -> None:
        migrate(held, {SCHEMA_VERSION + 1: "CREATE TABLE note (text TEXT)"}, SCHEMA_VERSION + 1)
        done.append(held)

    monkeypatch.setattr(connection, "migrate", step)
    Database(path, "write").close()
    assert len(done) == 1
    assert version(path) == SCHEMA_VERSION + 1
    Database(path).close()


def test_a_database_without_a_known_step_is_left_alone(path: Path) -> None:
    change(path, "PRAGMA user_version = 1")
    with pytest.raises(KeyError):
        migrate(opened(path), {}, 2)
    assert version(path) == 1
