"""What is sound in a damaged database is recovered, and the rest is reported."""

from __future__ import annotations

import random
import sqlite3
from pathlib import Path
from typing import Any

import pytest

import patterndb
from patterndb.errors import DatabaseError
from patterndb.store import Database
from patterndb.store.recovery import recover_database

ROWS = {
    "mesh": "SELECT sha256, name FROM mesh",
    "pattern": "SELECT id, code FROM pattern",
    "occurrence": "SELECT pattern_id, sha256, patches, mirrored_patches, example FROM occurrence "
    "JOIN mesh ON mesh.id = mesh_id",
    "usage": "SELECT pattern_id, uses, origin FROM usage",
}

#: What SQLite's pages with the rows of a table begin with.
TABLE_LEAF = 13


def read_rows(path: Path) -> dict[str, set[tuple[Any, ...]]]:
    connection = sqlite3.connect(path)
    try:
        return {table: set(connection.execute(sql).fetchall()) for table, sql in ROWS.items()}
    finally:
        connection.close()


@pytest.fixture
def used(full: Path) -> Path:
    with Database(full, "write") as db:
        db.record_use(db.pattern_class(4).pattern(0), 3)
    return full


def test_a_sound_database_is_saved_whole(used: Path, tmp_path: Path) -> None:
    saved = tmp_path / "saved.db"
    before = used.read_bytes()
    found = recover_database(used, saved)
    assert found.is_whole
    assert used.read_bytes() == before
    assert read_rows(saved) == read_rows(used)
    with Database(saved) as db, Database(used) as old:
        assert db.verify() == []
        assert db.content_hash() == old.content_hash()
        assert db.uses() == old.uses()
    assert found.saved == {table: len(rows) for table, rows in read_rows(used).items()}


@pytest.mark.parametrize("seed", range(12))
def test_what_spoiled_pages_leave_is_saved(used: Path, tmp_path: Path, seed: int) -> None:
    rows = read_rows(used)
    data = bytearray(used.read_bytes())
    size = int.from_bytes(data[16:18], "big")
    chance = random.Random(seed)
    # Without its schema there is nothing to read a file by.
    pages = [
        page
        for page in range(1, len(data) // size)
        if b"CREATE " not in data[page * size : (page + 1) * size]
    ]
    for page in chance.sample(pages, 1 + seed % 4):
        data[page * size : (page + 1) * size] = chance.randbytes(size) if seed % 2 else bytes(size)
    damaged, saved = tmp_path / "damaged.db", tmp_path / "saved.db"
    damaged.write_bytes(data)
    found = recover_database(damaged, saved)
    with Database(saved) as db:
        assert db.verify() == []
    kept = read_rows(saved)
    for table in ROWS:
        assert kept[table] <= rows[table], table
    assert found.is_whole == (kept == rows)
    assert not [one.name for one in tmp_path.iterdir() if one.name.startswith(".saved")]


def test_rows_around_one_spoiled_leaf_are_saved(used: Path, tmp_path: Path) -> None:
    with patterndb.open() as starter, Database(used, "write") as db:
        many = starter.pattern_class(6)
        for number in range(300):
            db.record_use(many.pattern(number))
    rows = read_rows(used)
    data = bytearray(used.read_bytes())
    size = int.from_bytes(data[16:18], "big")
    # The page of one pattern's code: a long one stands in no other place by chance.
    code = max((code for _, code in rows["pattern"]), key=len)
    page = data.index(code) // size
    assert data[page * size] == TABLE_LEAF
    data[page * size : (page + 1) * size] = bytes(size)
    used.write_bytes(data)
    saved = tmp_path / "saved.db"
    found = recover_database(used, saved)
    assert found.unreadable == ["pattern"]
    lost = len(rows["pattern"] - read_rows(saved)["pattern"])
    assert 0 < lost < len(rows["pattern"]) / 2
    gone = found.lost["occurrence"].total() + found.lost["usage"].total()
    assert gone >= lost


@pytest.mark.parametrize(
    ("sql", "table"),
    [
        ("UPDATE pattern SET code = x'00' WHERE id = (SELECT min(id) FROM pattern)", "pattern"),
        ("UPDATE mesh SET licence = x'ff' WHERE id = 1", "mesh"),
        ("UPDATE mesh SET quads_used = quads_read + 1 WHERE id = 1", "mesh"),
        ("UPDATE mesh SET sha256 = x'00' WHERE id = 1", "mesh"),
        ("UPDATE occurrence SET example = x'80' WHERE mesh_id = 1", "occurrence"),
        ("UPDATE occurrence SET patches = 0 WHERE mesh_id = 1", "occurrence"),
        ("UPDATE occurrence SET patches = 'x' WHERE mesh_id = 1", "occurrence"),
        ("UPDATE occurrence SET patches = 1 << 62 WHERE mesh_id = 1", "occurrence"),
        ("UPDATE usage SET uses = -1", "usage"),
    ],
)
def test_unsound_rows_are_left_out_and_told(
    used: Path, tmp_path: Path, sql: str, table: str
) -> None:
    spoil(used, sql)
    saved = tmp_path / "saved.db"
    found = recover_database(used, saved)
    assert not found.is_whole
    assert found.lost[table]
    with Database(saved) as db:
        assert db.verify() == []


def test_meshes_with_changed_examples_are_reported(used: Path, tmp_path: Path) -> None:
    spoil(used, "UPDATE occurrence SET example = CAST(example || x'01' AS BLOB) WHERE mesh_id = 1")
    saved = tmp_path / "saved.db"
    found = recover_database(used, saved)
    assert len(found.incomplete) == 1 and not any(found.lost.values())
    with Database(saved) as db:
        assert db.verify() == []


def test_counts_that_patches_do_not_reach_are_told(used: Path, tmp_path: Path) -> None:
    spoil(used, "UPDATE mesh SET distinct_patches = distinct_patches + 1 WHERE id = 1")
    saved = tmp_path / "saved.db"
    assert len(recover_database(used, saved).incomplete) == 1
    with Database(saved) as db:
        assert db.verify() == []


def test_what_cannot_be_is_refused(used: Path, tmp_path: Path) -> None:
    there = tmp_path / "there.db"
    there.write_bytes(b"mine")
    with pytest.raises(DatabaseError, match="there already"):
        recover_database(used, there)
    assert there.read_bytes() == b"mine"
    saved = tmp_path / "saved.db"
    other = tmp_path / "other.db"
    other.write_bytes(b"no database at all" * 100)
    with pytest.raises(DatabaseError, match="nothing of"):
        recover_database(other, saved)
    data = used.read_bytes()
    other.write_bytes(data.replace(b"CREATE TABLE mesh", b"CREATE TABLE \xc8esh"))
    with pytest.raises(DatabaseError, match="nothing of"):
        recover_database(other, saved)
    empty = tmp_path / "empty.db"
    empty.write_bytes(b"")
    with pytest.raises(DatabaseError, match="lacks the tables"):
        recover_database(empty, saved)
    with pytest.raises(DatabaseError, match="there is no database"):
        recover_database(tmp_path / "none.db", saved)
    assert not saved.exists()


def spoil(path: Path, sql: str) -> None:
    """Change a file as another program can: without the schema's rules."""
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA ignore_check_constraints = ON")
    connection.execute("PRAGMA writable_schema = ON")
    connection.execute(
        "UPDATE sqlite_schema SET sql = replace(sql, ') STRICT', ')') WHERE type = 'table'"
    )
    connection.commit()
    connection.close()
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA ignore_check_constraints = ON")
    connection.execute(sql)
    connection.commit()
    connection.close()
