"""Opening, refusing, and who may change what."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from ingest import ingest
from patterndb.errors import DatabaseError, NotFoundError
from patterndb.store import Database, Provenance, connection
from patterndb.store.connection import APPLICATION_ID, SCHEMA_VERSION, atomic, connect
from tests.support.store.learnt import OPTIONS, change, content


def pragma(path: Path, name: str) -> int:
    return sqlite3.connect(path).execute(f"PRAGMA {name}").fetchone()[0]


def test_a_new_database_says_what_it_is_and_is_empty(tmp_path: Path) -> None:
    path = tmp_path / "new.db"
    with Database(path, "create") as db:
        statistics = db.statistics()
        assert db.verify() == []
    assert (statistics.patterns, statistics.meshes, statistics.patches) == (0, 0, 0)
    assert (statistics.by_sides, statistics.by_irregular) == ({}, {})
    assert pragma(path, "application_id") == APPLICATION_ID == int.from_bytes(b"PatD", "big")
    assert pragma(path, "user_version") == SCHEMA_VERSION


def test_create_opens_what_is_there(full: Path) -> None:
    before = content(full)
    with Database(full, "create") as db:
        assert db.content_hash() == before


def test_an_empty_file_becomes_a_database(tmp_path: Path) -> None:
    path = tmp_path / "empty.db"
    path.touch()
    with pytest.raises(DatabaseError, match="is empty"):
        Database(path)
    Database(path, "create").close()
    assert Database(path).meshes() == []


@pytest.mark.parametrize("mode", ["read", "write"])
def test_a_missing_file_is_not_made(tmp_path: Path, mode: str) -> None:
    path = tmp_path / "none.db"
    with pytest.raises(DatabaseError, match="no database at"):
        Database(path, mode)  # type: ignore[arg-type]
    assert not path.exists()


def no_sqlite(path: Path) -> None:
    path.write_bytes(b"v 0 0 0\n" * 4000)


def other_kind(path: Path) -> None:
    change(path, "CREATE TABLE bookmarks (a)")


def other_application(path: Path) -> None:
    change(path, "PRAGMA application_id = 77")


def newer(path: Path) -> None:
    Database(path, "create").close()
    change(path, f"PRAGMA user_version = {SCHEMA_VERSION + 1}")


def directory(path: Path) -> None:
    path.mkdir()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
@pytest.mark.parametrize("mode", ["read", "write", "create"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path, mode: str) -> None:
    path = tmp_path / "pipe.db"
    os.mkfifo(path)
    with pytest.raises(DatabaseError, match="pipe"):
        Database(path, mode)  # type: ignore[arg-type]


@pytest.mark.parametrize("mode", ["read", "write", "create"])
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (no_sqlite, "is not an SQLite file"),
        (other_kind, "another kind"),
        (other_application, "another kind"),
        (newer, "version 2 of the schema.*learn its meshes again"),
        (directory, "is a directory"),
    ],
)
def test_other_files_are_refused_and_left_alone(
    tmp_path: Path, make: Callable[[Path], None], message: str, mode: str
) -> None:
    path = tmp_path / "other.db"
    make(path)
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(DatabaseError, match=message):
        Database(path, mode)  # type: ignore[arg-type]
    assert (path.read_bytes() if path.is_file() else None) == before


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(DatabaseError, match="no folder"):
        Database(tmp_path / "none" / "new.db", "create")


def test_a_path_with_signs_that_mean_something_in_uris(tmp_path: Path) -> None:
    path = tmp_path / "50% a?b#c.db"
    Database(path, "create").close()
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert Database(path).meshes() == []


def test_a_database_open_for_reading_cannot_be_changed(full: Path, files: dict[str, Path]) -> None:
    before = full.read_bytes()
    with Database(full) as db:
        changes: list[Callable[[], object]] = [
            lambda: ingest(db, [files["cup"]], OPTIONS, provenance=Provenance("x")),
            lambda: db.remove(["cup.obj"]),
            lambda: db.merge(Database(full)),
            lambda: db.update_provenance("00" * 32, "x", Provenance()),
        ]
        for attempt in changes:
            with pytest.raises(DatabaseError):
                attempt()
        with pytest.raises(sqlite3.OperationalError, match="readonly"):
            db._connection.execute("DELETE FROM mesh")
    assert full.read_bytes() == before


def test_a_file_that_may_not_be_written_is_said_to_be_read_only(full: Path) -> None:
    """As whoever runs the tests may write anything, the file system's refusal is SQLite's."""
    uri = f"file:{full}?mode=ro"
    reader = sqlite3.connect(uri, uri=True, isolation_level=None)
    with pytest.raises(DatabaseError, match="read-only"), atomic(reader) as change_:
        change_.execute("DELETE FROM mesh")
    reader.close()


def test_an_immutable_database_is_read_beside_a_lock(full: Path) -> None:
    """It is opened without looking at locks, so no file beside it is needed or made."""
    before = content(full)
    writer = sqlite3.connect(full, isolation_level=None)
    writer.execute("BEGIN EXCLUSIVE")
    with Database(full, immutable=True) as db:
        assert db.content_hash() == before
    writer.close()


def test_every_pragma_is_set(full: Path) -> None:
    opened = connect(full, "write")
    assert opened.execute("PRAGMA foreign_keys").fetchone() == (1,)
    assert opened.execute("PRAGMA trusted_schema").fetchone() == (0,)
    with pytest.raises(sqlite3.IntegrityError):
        opened.execute("DELETE FROM pattern")
    opened.close()


def test_a_second_writer_is_told_so(
    full: Path, files: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_SECONDS", 0.05)
    before = content(full)
    writer = sqlite3.connect(full, isolation_level=None)
    writer.execute("BEGIN IMMEDIATE")
    with Database(full, "write") as db:
        with pytest.raises(DatabaseError, match="written by another process; try again"):
            db.remove(["cup.obj"])
        writer.execute("ROLLBACK")
        assert db.content_hash() == before
        assert db.remove(["cup.obj"])[0] == 1
    writer.close()


def test_a_reader_that_holds_up_a_commit_does_not_spoil_the_writer(
    full: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_SECONDS", 0.05)
    before = content(full)
    reader = sqlite3.connect(full, isolation_level=None)
    reader.execute("BEGIN")
    reader.execute("SELECT count(*) FROM mesh").fetchone()
    with Database(full, "write") as db:
        with pytest.raises(DatabaseError, match="another process"):
            db.remove(["cup.obj"])
        reader.execute("COMMIT")
        assert db.content_hash() == before
        assert db.remove(["cup.obj"])[0] == 1
    reader.close()


def test_an_error_inside_takes_all_back(full: Path) -> None:
    before = content(full)
    opened = connect(full, "write")
    with pytest.raises(RuntimeError), atomic(opened) as change_:
        change_.execute("DELETE FROM occurrence")
        change_.execute("DELETE FROM mesh")
        raise RuntimeError
    assert not opened.in_transaction
    opened.close()
    assert content(full) == before


def test_one_unknown_name_and_nothing_is_removed(full: Path) -> None:
    before = content(full)
    with Database(full, "write") as db, pytest.raises(NotFoundError):
        db.remove(["cup.obj", "nobody.obj"])
    assert content(full) == before


def test_two_processes_may_make_the_same_database(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both find no file; the other is first."""
    path = tmp_path / "one.db"
    read_schema = connection.read_schema

    def second() -> str:
        monkeypatch.setattr(connection, "read_schema", read_schema)
        Database(path, "create").close()
        return read_schema()

    monkeypatch.setattr(connection, "read_schema", second)
    with Database(path, "create") as db:
        assert db.verify() == []
        assert db.remove([]) == (0, 0)
