"""Databases from elsewhere: whatever stands in them, they are refused and nothing crashes."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

import patterndb
from patterndb.errors import DatabaseError, PatternDBError
from tests.support.store.learnt import change, content

#: Codes that are none: empty, no whole quad, an edge out of range, one that is named twice, one
#: that closes its quad, two quads of which one is not reached.
CODES = ["", "00", "000000ff", "00000009", "00020100", "010000", "0000000000000000"]


@pytest.mark.parametrize("code", CODES)
def test_a_bad_code_is_refused_by_merge_and_by_reading(
    code: str, full: Path, tmp_path: Path
) -> None:
    with patterndb.open(full) as database:
        n_sides = 4
        row = int(database.pattern_class(n_sides).ids[0])
    change(full, f"UPDATE pattern SET code = x'{code}' WHERE id = {row}")
    with patterndb.open(full) as other, patterndb.open(tmp_path / "new.db", "create") as new:
        empty = new.content_hash()
        with pytest.raises(DatabaseError, match="damaged"):
            new.merge(other)
        assert new.content_hash() == empty
        with pytest.raises(DatabaseError, match="damaged"):
            other.pattern(f"{row:016x}")
        assert other.verify()
        with pytest.raises(PatternDBError):
            other.pattern_class(n_sides).pattern(0)


def test_an_id_of_another_pattern_is_refused_by_merge(full: Path, tmp_path: Path) -> None:
    with patterndb.open(full) as database:
        first, second = database.pattern_class(4).ids[:2].tolist()
    change(
        full,
        "PRAGMA foreign_keys = OFF",
        f"UPDATE pattern SET id = 1 WHERE id = {first}",
        f"UPDATE pattern SET id = {first} WHERE id = {second}",
        f"UPDATE pattern SET id = {second} WHERE id = 1",
    )
    with (
        patterndb.open(full) as other,
        patterndb.open(tmp_path / "new.db", "create") as new,
        pytest.raises(DatabaseError, match="is damaged"),
    ):
        new.merge(other)


@pytest.mark.parametrize("column", ["code", "signature"])
def test_a_damaged_column_is_told_and_does_not_crash(column: str, full: Path) -> None:
    for junk in ("", "05", "0505", "ff"):
        change(full, f"UPDATE pattern SET {column} = x'{junk}' WHERE n_sides = 5")
        with patterndb.open(full) as database:
            assert database.verify()
            try:
                database.pattern_class(5)
            except DatabaseError as error:
                assert "damaged" in str(error)


def test_nothing_of_this_changes_a_sound_merge(full: Path, tmp_path: Path) -> None:
    with patterndb.open(full) as other, patterndb.open(tmp_path / "new.db", "create") as new:
        new.merge(other)
    assert content(tmp_path / "new.db") == content(full)


@pytest.mark.parametrize("value", ["1 << 40", "-1", "0.5", "'x'"])
def test_a_hash_that_is_no_bytes_is_told(value: str, full: Path) -> None:
    def set_schema(connection: sqlite3.Connection, sql: str) -> None:
        connection.execute("PRAGMA writable_schema = ON")
        connection.execute("UPDATE sqlite_schema SET sql = ? WHERE name = 'mesh'", (sql,))

    def connect() -> sqlite3.Connection:
        return sqlite3.connect(full, isolation_level=None)

    with closing(connect()) as connection:
        (sql,) = connection.execute("SELECT sql FROM sqlite_schema WHERE name = 'mesh'").fetchone()
        # SQLite takes any value where the table is not strict.
        set_schema(connection, sql.replace(") STRICT", ")"))
    with closing(connect()) as connection:
        connection.execute("PRAGMA ignore_check_constraints = ON")
        connection.execute(f"UPDATE mesh SET sha256 = {value} WHERE id = 1")
        set_schema(connection, sql)
    with patterndb.open(full, "write") as database:
        for ask in (
            database.meshes,
            database.known_meshes,
            lambda: database.pattern_ids(4, ["cup.obj"]),
            lambda: database.remove(["cup.obj"]),
        ):
            with pytest.raises(DatabaseError, match="not bytes"):
                ask()
        assert database.verify()
