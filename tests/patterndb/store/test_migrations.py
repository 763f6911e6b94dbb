from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest

from patterndb.core.shortcode import lengthen
from patterndb.errors import DatabaseError
from patterndb.store import Database, connection
from patterndb.store.migrations import (
    _SELECT_MESHES_5,
    _SELECT_OCCURRENCES_5,
    MIGRATIONS,
    SCHEMA_VERSION,
    WORTH_TELLING,
    _write_sums,
    migrate,
    schema,
)
from tests.support.store.learnt import change, content, rows

NEXT = SCHEMA_VERSION + 1
STEPS = {
    NEXT: "ALTER TABLE mesh ADD COLUMN poly_count INTEGER;",
    NEXT + 1: "CREATE TABLE note (text TEXT); INSERT INTO note VALUES ('last step')",
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
    assert migrate(opened(path), STEPS, NEXT + 1) == [NEXT, NEXT + 1]
    assert version(path) == NEXT + 1
    assert opened(path).execute("SELECT text FROM note").fetchall() == [("last step",)]
    assert migrate(opened(path), STEPS, NEXT + 1) == []


def test_each_step_is_committed_with_its_number(path: Path) -> None:
    """The second fails half-way: the first stays, with its number; the second leaves nothing."""
    steps = {**STEPS, NEXT + 1: "CREATE TABLE half (a); INSERT INTO nowhere VALUES (1);"}
    held = opened(path)
    with pytest.raises(sqlite3.OperationalError, match="nowhere"):
        migrate(held, steps, NEXT + 1)
    assert not held.in_transaction
    assert version(path) == NEXT
    assert "half" not in tables(path)
    assert migrate(opened(path), STEPS, NEXT + 1) == [NEXT + 1]
    assert "note" in tables(path)


def test_an_older_database_is_brought_up_by_opening_it_for_writing(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "SCHEMA_VERSION", SCHEMA_VERSION + 1)
    with pytest.raises(DatabaseError, match="open it once for writing"):
        Database(path)
    done: list[sqlite3.Connection] = []

    def step(held: sqlite3.Connection) -> None:
        migrate(held, {SCHEMA_VERSION + 1: "ANALYZE"}, SCHEMA_VERSION + 1)
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


def test_a_step_that_another_process_took_meanwhile_is_done(path: Path) -> None:
    class Late(sqlite3.Connection):
        """Its first script waits for the lock until the other has taken the step."""

        def executescript(self, script: str) -> sqlite3.Cursor:
            if version(path) < NEXT:
                migrate(opened(path), STEPS, NEXT)
            return super().executescript(script)

    late = sqlite3.connect(path, isolation_level=None, factory=Late)
    assert migrate(late, STEPS, NEXT) == []
    assert not late.in_transaction
    assert version(path) == NEXT


#: Columns that are as in version 1.
FOLLOWING = ("n_sides", "n_reflex", "n_quads", "n_irregular", "chiral")


def made_by_version_1(path: Path, full: Path) -> Path:
    """The content of a database in a file with the schema of version 1."""
    old = sqlite3.connect(path)
    old.executescript((Path(__file__).parent / "schema_1.sql").read_text(encoding="ascii"))
    old.execute("ATTACH ? AS present", (str(full),))
    # Version 1 stored packed codes, and all that follows from them; what is not used by the steps
    # to the present version may be anything here.
    numbers = ["n_chords", "n_loops", "self_crossing", "sig_rotation", "sig_reflected"]
    rows = old.execute(
        "SELECT id, code, n_sides, n_reflex, n_quads, n_irregular, chiral FROM present.pattern"
    )
    for number, short, *told in rows.fetchall():
        columns = dict(zip(FOLLOWING, told, strict=True))
        columns |= {"id": number, "code": lengthen([short])[0], "rotations": 1}
        columns |= dict.fromkeys(numbers, 0)
        columns |= dict.fromkeys(
            ["corners", "valences", "label", "signature", "lengths", "joins"], b""
        )
        old.execute(
            f"INSERT INTO pattern ({', '.join(columns)}) VALUES ({', '.join('?' * len(columns))})",
            list(columns.values()),
        )
    for table in ("mesh", "occurrence"):
        names = [row[1] for row in old.execute(f"PRAGMA main.table_info({table})")]
        columns = ", ".join(names)
        old.execute(f"INSERT INTO {table} ({columns}) SELECT {columns} FROM present.{table}")
    old.commit()
    old.close()
    return path


def described(path: Path) -> dict[str, object]:
    """Columns of all tables, and the text of all triggers and indices."""
    held = opened(path)
    found: dict[str, object] = {}
    for kind, name, sql in held.execute("SELECT type, name, sql FROM sqlite_schema").fetchall():
        found[name] = held.execute(f"PRAGMA table_xinfo({name})").fetchall() or sql
        if kind == "table":
            found[f"{name} strict"] = "STRICT" in sql
            found[f"{name} checks"] = sql.count("CHECK")
            found[f"{name} refers"] = held.execute(f"PRAGMA foreign_key_list({name})").fetchall()
    return found


def test_version_1_becomes_the_present_one(full: Path, tmp_path: Path) -> None:
    old = made_by_version_1(tmp_path / "old.db", full)
    assert version(old) == 1
    with pytest.raises(DatabaseError, match="has schema 1; open it once for writing"):
        Database(old)
    with Database(old, "write") as db:
        assert db.uses() == {}
        assert {m.origin for m in db.meshes()} == {"learned"}
    assert version(old) == SCHEMA_VERSION
    assert content(old) == content(full)
    assert described(old) == described(full)
    for table in ("pattern", "occurrence", "usage"):
        assert rows(old, table) == rows(full, table)
    # Next to nothing of the file is free.
    free = opened(old).execute("SELECT freelist_count FROM pragma_freelist_count").fetchone()[0]
    assert free == 0
    # And what the database keeps by itself is kept.
    with Database(old, "write") as db, Database(full, "write") as present:
        for each in (db, present):
            each.remove(["cup.obj"])
            each.record_use(each.pattern_class(4).pattern(0))
    assert content(old) == content(full)
    assert rows(old, "usage") == rows(full, "usage")


def test_a_step_that_takes_long_is_told_before(
    full: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    Database(made_by_version_1(tmp_path / "small.db", full), "write").close()
    assert not caplog.records
    monkeypatch.setattr("patterndb.store.migrations.WORTH_TELLING", dict.fromkeys(WORTH_TELLING, 1))
    Database(made_by_version_1(tmp_path / "large.db", full), "write").close()
    assert [record.levelname for record in caplog.records] == ["WARNING"] * 3
    for number in (4, 6, 7):
        assert f"patterns to schema {number}" in caplog.text


def test_a_damaged_code_is_told_and_the_file_stays_as_it_was(full: Path, tmp_path: Path) -> None:
    old = made_by_version_1(tmp_path / "old.db", full)
    (number,) = opened(old).execute("SELECT max(id) FROM pattern").fetchone()
    change(old, f"UPDATE pattern SET code = x'09000000' WHERE id = {number}")
    with pytest.raises(DatabaseError, match=f"pattern {number:016x} is damaged"):
        Database(old, "write")
    assert version(old) == 3
    assert "label" in [row[1] for row in opened(old).execute("PRAGMA table_info(pattern)")]


#: What takes a database of version 7 back to version 6.
BACK_TO_6 = (
    *(f"DROP TABLE {table}" for table in ("tally", "signature", "handedness")),
    "PRAGMA user_version = 6",
)


def test_version_6_gets_counts(full: Path, tmp_path: Path) -> None:
    old = tmp_path / "old.db"
    shutil.copy(full, old)
    change(old, *BACK_TO_6)
    with pytest.raises(DatabaseError, match="has schema 6; open it once for writing"):
        Database(old)
    Database(old, "write").close()
    assert content(old) == content(full)
    assert described(old) == described(full)
    for table in ("tally", "handedness"):
        assert rows(old, table) == rows(full, table)
    with Database(old) as db, Database(full) as present:
        assert db.statistics() == present.statistics()


def made_by_version_5(path: Path, full: Path, *statements: str) -> Path:
    """A database as version 5 held it, with its sums, and what was changed behind its back."""
    shutil.copy(full, path)
    change(path, *BACK_TO_6)
    change(path, "ALTER TABLE mesh DROP COLUMN occurrence_sum", "PRAGMA user_version = 5")
    change(path, "INSERT INTO checksum VALUES ('occurrence', zeroblob(16))")
    held = sqlite3.connect(path)
    _write_sums(held, {"occurrence": _SELECT_OCCURRENCES_5, "mesh": _SELECT_MESHES_5})
    held.commit()
    held.close()
    change(path, *statements)
    return path


def test_version_5_gets_sums_by_mesh(full: Path, tmp_path: Path) -> None:
    old = made_by_version_5(tmp_path / "old.db", full)
    with pytest.raises(DatabaseError, match="has schema 5; open it once for writing"):
        Database(old)
    Database(old, "write").close()
    assert content(old) == content(full)
    assert described(old) == described(full)
    for table in ("mesh", "checksum"):
        assert rows(old, table) == rows(full, table)


@pytest.mark.parametrize(
    ("table", "statement"),
    [
        (
            "occurrence",
            "UPDATE occurrence SET example = CAST(x'7f' || substr(example, 2) AS BLOB) "
            "WHERE pattern_id = (SELECT max(pattern_id) FROM occurrence "
            "WHERE substr(example, 1, 1) < x'7f')",
        ),
        ("mesh", "UPDATE mesh SET licence = 'mine' WHERE id = 1"),
    ],
)
def test_what_version_5_would_have_found_is_found_still(
    full: Path, tmp_path: Path, table: str, statement: str
) -> None:
    old = made_by_version_5(tmp_path / "old.db", full, statement)
    Database(old, "write").close()
    with Database(old) as db:
        assert [table in finding for finding in db.verify()] == [True]
