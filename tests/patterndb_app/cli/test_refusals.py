"""What the verbs that ask refuse: the exit code, the words, and nothing on stdout."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest

from tests.support.cli.commandline import (
    TINY,
    Result,
    assert_refused,
    program,
    run,
    without_privileges,
)
from tests.support.shared import EXAMPLES

ASKING = (
    ("stats",),
    ("stats", "--json"),
    ("meshes",),
    ("query", "--sides", "3,5,4,6"),
    ("query", "--sides", "3,5,4,6", "--json"),
    ("verify",),
    ("show", "04", "-o", "picture.svg"),
    ("gallery", "--class", "4", "-o", "picture.svg"),
)


NO_NUMBERS = (
    "",
    ",",
    "3,,4",
    "abc",
    "3;4",
    "3 4",
    "1e3,1",
    "2.0,2",
    "nan,4",
    "inf",
    "0x4,4",
    "٤,٤",
)


def query(db: Path, sides: str, *options: object) -> Result:
    return run("query", f"--sides={sides}", "--db", db, *options)


class TestBoundaries:
    @pytest.mark.parametrize("json", [(), ("--json",)])
    def test_odd_perimeter(self, learned: Path, json: tuple[str, ...]) -> None:
        result = query(learned, "3,5,4,5", *json)
        assert_refused(result, 3, "the perimeter 17 is odd", "change one side by 1")

    @pytest.mark.parametrize("sides", ["0,4", "4,0,4", "-1,5", "-4", "2,2,-2"])
    def test_no_length(self, learned: Path, sides: str) -> None:
        assert_refused(query(learned, sides), 3, "every side needs at least 1 edge")

    @pytest.mark.parametrize("sides", ["1,1", "2"])
    def test_too_short(self, learned: Path, sides: str) -> None:
        assert_refused(query(learned, sides), 3, "below 4")

    @pytest.mark.parametrize("sides", ["2000,2000", "1000,1002", "9" * 18])
    def test_too_long(self, learned: Path, sides: str) -> None:
        assert_refused(query(learned, sides), 3, "above the limit of 2000")

    @pytest.mark.parametrize("sides", NO_NUMBERS)
    def test_no_numbers(self, learned: Path, sides: str) -> None:
        assert_refused(query(learned, sides), 2, "--sides", "like 3,5,4,6")

    def test_spaces_and_signs_are_read(self, learned: Path) -> None:
        assert query(learned, " 3, 5 ,+4,6", "--json").document()["sides"] == [3, 5, 4, 6]

    def test_closed_takes_one_length(self, learned: Path) -> None:
        assert_refused(query(learned, "4,4", "--closed"), 2, "--closed")

    def test_sides_are_needed(self, learned: Path) -> None:
        assert_refused(run("query", "--db", learned), 2, "--sides")


@pytest.mark.parametrize(
    "options",
    [
        ("--limit", "0"),
        ("--limit", "-5"),
        ("--limit", "all"),
        ("--per-pattern", "-1"),
        ("--max-irregular", "-1"),
        ("--max-irregular", "nan"),
        ("--valence", "5..3"),
        ("--valence", "0..4"),
        ("--valence", "3-5"),
        ("--valence", "-3..5"),
        ("--solver", "magic"),
        ("--image", "picture.bmp"),
        ("--image", "picture"),
        ("--image", "no/such/folder/picture.png"),
        ("--obj", ""),
        ("--frobnicate",),
        ("more",),
    ],
)
def test_wrong_options(learned: Path, options: tuple[str, ...]) -> None:
    assert_refused(query(learned, "3,5,4,6", *options), 2, "Error: ")


def test_unknown_verb() -> None:
    assert_refused(run("frobnicate"), 2, "there is no verb 'frobnicate'")


@pytest.mark.parametrize("verb", ASKING, ids=" ".join)
class TestDatabases:
    @pytest.fixture(autouse=True)
    def _elsewhere(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)

    def test_missing(self, verb: tuple[str, ...]) -> None:
        result = run(*verb, "--db", "gone.db")
        assert_refused(result, 3, "no database at gone.db", "patterndb ingest")
        assert not Path("gone.db").exists()

    def test_folder(self, verb: tuple[str, ...]) -> None:
        Path("folder").mkdir()
        assert_refused(run(*verb, "--db", "folder"), 3, "folder is a directory")

    def test_not_a_database(self, verb: tuple[str, ...]) -> None:
        Path("letter.db").write_text("Dear Ada, " * 1000)
        assert_refused(run(*verb, "--db", "letter.db"), 3, "letter.db is not an SQLite file")

    def test_empty(self, verb: tuple[str, ...]) -> None:
        Path("empty.db").touch()
        assert_refused(run(*verb, "--db", "empty.db"), 3, "empty.db")
        assert Path("empty.db").stat().st_size == 0

    def test_of_another_program(self, verb: tuple[str, ...]) -> None:
        with sqlite3.connect("other.db") as connection:
            connection.execute("CREATE TABLE pattern (id)")
        connection.close()
        assert_refused(run(*verb, "--db", "other.db"), 3, "another kind")

    def test_of_another_version(self, verb: tuple[str, ...], learned: Path) -> None:
        shutil.copy(learned, "new.db")
        with sqlite3.connect("new.db") as connection:
            connection.execute("PRAGMA user_version = 99")
        connection.close()
        assert_refused(run(*verb, "--db", "new.db"), 3, "version 99", "ingest MESH")

    def test_cut_short(self, verb: tuple[str, ...], learned: Path) -> None:
        data = learned.read_bytes()
        Path("cut.db").write_bytes(data[: len(data) // 2])
        assert_refused(run(*verb, "--db", "cut.db"), 3, "cut.db is damaged", "copy")


@pytest.mark.parametrize("verb", ASKING, ids=" ".join)
def test_damage_within_never_ends_in_a_traceback(
    learned: Path, tmp_path: Path, verb: tuple[str, ...]
) -> None:
    data = bytearray(learned.read_bytes())
    for at in range(8192, len(data)):
        data[at] = at * 7919 % 251
    db = tmp_path / "damaged.db"
    db.write_bytes(data)
    result = program(*verb, "--db", db, folder=tmp_path)
    assert result.code == 3
    assert "Traceback" not in result.err
    assert "damaged" in result.err or "SQLite: " in result.out


class TestPermissions:
    """Root may write anywhere; these run without that privilege."""

    def test_a_database_that_may_not_be_read(self, db: Path) -> None:
        db.chmod(0o000)
        result = program("stats", "--db", db, before=without_privileges)
        assert_refused(result, 3, str(db), "cannot be opened")

    def test_a_database_that_may_not_be_written(self, db: Path, learned: Path) -> None:
        assert run("remove", "jug.obj", "--db", db).code == 0
        db.chmod(0o444)
        before = db.read_bytes()
        for verb in (
            ("ingest", EXAMPLES / "jug.obj", *TINY),
            ("remove", "hand.obj"),
            ("merge", learned),
        ):
            result = program(*verb, "--db", db, before=without_privileges)
            assert result.code == 3 and result.out == ""
            assert f"{db} cannot be written" in result.err and "read-only" in result.err
        assert db.read_bytes() == before
        # Asking needs no writing.
        result = program("query", "--sides=2,2,2,2", "--db", db, before=without_privileges)
        assert result.code == 0

    def test_a_mesh_that_may_not_be_read(self, tmp_path: Path) -> None:
        mesh = Path(shutil.copy(EXAMPLES / "jug.obj", tmp_path))
        mesh.chmod(0o000)
        result = program("ingest", mesh, "--db", tmp_path / "a.db", before=without_privileges)
        assert_refused(result, 3, str(mesh), "Permission denied")

    def test_a_folder_that_may_not_be_written(self, learned: Path, tmp_path: Path) -> None:
        folder = tmp_path / "locked"
        folder.mkdir(mode=0o555)
        for options in (("--obj", folder / "fills"), ("--image", folder / "fills.svg")):
            result = program(
                *("query", "--sides=2,2,2,2", "--db", learned, *options), before=without_privileges
            )
            assert result.code == 3
            assert f"patterndb: {folder}" in result.err and "Permission denied" in result.err
            assert "Traceback" not in result.err
        assert list(folder.iterdir()) == []


def test_output_below_a_file(learned: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert_refused(query(learned, "2,2,2,2", "--obj", tmp_path / "file"), 2, "is a file")
    result = query(learned, "2,2,2,2", "--obj", tmp_path / "file" / "below")
    assert result.code == 3
    assert "Not a directory" in result.err


def test_a_database_that_is_being_written(db: Path) -> None:
    import patterndb.store.connection

    connection = sqlite3.connect(db, isolation_level=None)
    connection.execute("BEGIN EXCLUSIVE")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(patterndb.store.connection, "BUSY_SECONDS", 0.05)
        for verb in (("stats",), ("remove", "jug.obj")):
            assert_refused(run(*verb, "--db", db), 3, "being written by another process")
    connection.execute("ROLLBACK")
    connection.close()
    assert run("stats", "--db", db).code == 0
