"""patterndb import-ddq and export-ddq."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from tests.support.cli.commandline import assert_refused, content_hash, program, run

IMPORT = "import-ddq"
EXPORT = "export-ddq"


@pytest.fixture
def exported(tiny: Path, tmp_path: Path) -> Path:
    """What the database of two meshes is in the authors' layout."""
    file = tmp_path / "patches.db"
    result = run(EXPORT, file, "--db", tiny)
    assert (result.code, result.err) == (0, "")
    assert "3 patterns in " in result.out and str(file) in result.out
    return file


def spoil(file: Path, *statements: str) -> None:
    connection = sqlite3.connect(file)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


def test_there_and_back(exported: Path, tiny: Path, tmp_path: Path) -> None:
    before = run("stats", "--db", tiny, "--json").document()
    db = tmp_path / "new.db"
    document = run(IMPORT, exported, "--db", db, "--json").document()
    assert document["outcome"] == "imported"
    assert (document["refused"], document["refusals"], document["unlike"]) == (0, [], 0)
    assert document["patterns"] == document["new_patterns"] == document["file_patterns"] == 3
    assert document["occurrences"] == before["patches"]
    after = run("stats", "--db", db, "--json").document()
    for name in ("patterns", "patches", "by_sides", "by_irregular", "signatures"):
        assert after[name] == before[name]
    assert run("verify", "--db", db).code == 0
    meshes = run("meshes", "--db", db, "--json").document()["meshes"]
    assert [mesh["name"] for mesh in meshes] == ["patches.db"]
    # Verbs that ask take the imported patterns as any others.
    assert run("query", "--sides=2,2,2,2", "--db", db).code == 0
    again = run(EXPORT, tmp_path / "again.db", "--db", db, "--json").document()
    assert again == {
        "file": "again.db",
        "patterns": 3,
        "rows": document["rows"],
        "occurrences": document["occurrences"],
    }
    assert (tmp_path / "again.db").read_bytes() == exported.read_bytes()


def test_text_and_again(exported: Path, tiny: Path) -> None:
    result = run(IMPORT, exported, "--db", tiny, "--author", "they")
    assert (result.code, result.err) == (0, "")
    assert "3 patterns, 0 of them new" in result.out and f"3 patterns in {tiny}" in result.out
    before = content_hash(tiny)
    result = run(IMPORT, exported, "--db", tiny)
    assert (result.code, result.out) == (0, f"patches.db: unchanged; 3 patterns in {tiny}\n")
    assert content_hash(tiny) == before
    result = run(IMPORT, exported, "--db", tiny, "--licence", "research", "--json")
    document = result.document()
    assert (document["outcome"], document["new_patterns"]) == ("updated", 0)
    assert run("remove", "patches.db", "--db", tiny).code == 0


def test_a_bad_row_is_told_and_the_others_go_in(exported: Path, tmp_path: Path) -> None:
    spoil(
        exported,
        "INSERT INTO Patches SELECT 'zz' || topology, '', '', 0, 4, 1, 4, 1, 0 FROM Patches",
    )
    n = sqlite3.connect(exported).execute("SELECT count(*) FROM Patches").fetchone()[0]
    db = tmp_path / "new.db"
    result = run(IMPORT, exported, "--db", db, "--json")
    document = result.document()
    assert result.code == 3
    assert (document["rows"], document["refused"], document["patterns"]) == (n, n // 2, 3)
    assert document["refusals"][0]["key"].startswith("zz")
    assert "left out: " in result.err and f"row {n} (zz" in result.err
    assert run("verify", "--db", db).code == 0


def test_many_bad_rows_are_counted(exported: Path, tmp_path: Path) -> None:
    for i in range(30):
        spoil(exported, f"INSERT INTO Patches VALUES ('bad {i}', '', '', 0, 4, 1, 4, 1, 0)")
    result = run(IMPORT, exported, "--db", tmp_path / "new.db")
    assert result.code == 3
    assert len(result.err.splitlines()) == 21 and "and 10 rows more" in result.err


def test_miscounted_irregular_vertices_are_told(exported: Path, tmp_path: Path) -> None:
    spoil(exported, "UPDATE Patches SET nSingularities = 9")
    result = run(IMPORT, exported, "--db", tmp_path / "new.db")
    assert result.code == 0
    assert "another number of irregular vertices" in result.err


@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda p: p.write_text("topology\n" * 999), 3, "is not an SQLite file"),
        (lambda p: p.mkdir(), 3, "is a directory"),
        (lambda p: spoil(p, "CREATE TABLE a (b)"), 3, "has no table Patches"),
        (lambda p: None, 3, "No such file"),
    ],
)
def test_what_cannot_be_imported_leaves_no_database(
    make, code: int, words: str, tmp_path: Path
) -> None:
    file = tmp_path / "file.db"
    make(file)
    assert_refused(run(IMPORT, file, "--db", tmp_path / "new.db"), code, words)
    assert not (tmp_path / "new.db").exists()


def test_nothing_in_it(exported: Path, tmp_path: Path) -> None:
    spoil(exported, "DELETE FROM Patches")
    assert_refused(run(IMPORT, exported, "--db", tmp_path / "new.db"), 1, "nothing to import")
    assert not (tmp_path / "new.db").exists()


def test_what_is_refused_changes_nothing(exported: Path, tiny: Path, tmp_path: Path) -> None:
    before = content_hash(tiny)
    assert_refused(run(IMPORT, tiny, "--db", tiny), 3, "patterndb merge")
    assert_refused(run(EXPORT, exported, "--db", tiny), 3, "already")
    assert_refused(run(EXPORT, tmp_path / "x.db", "--db", tmp_path / "no.db"), 3, "no database")
    assert_refused(run(EXPORT, tmp_path / "x.db", "--db", tiny, "--digits", 0), 2, "--digits")
    assert_refused(run(IMPORT, exported), 2, "--db")
    assert not (tmp_path / "x.db").exists()
    assert content_hash(tiny) == before


def test_in_a_process_of_its_own(exported: Path, tmp_path: Path) -> None:
    result = program(IMPORT, exported, "--db", "new.db", folder=tmp_path)
    assert (result.code, result.err) == (0, "")
    result = program(EXPORT, "out.db", "--db", "new.db", "--digits", 16, folder=tmp_path)
    assert result.code == 0
    rows = sqlite3.connect(tmp_path / "out.db").execute("SELECT topology, nFaces FROM Patches")
    assert all(len(topology) == 48 * n for topology, n in rows)


@pytest.mark.parametrize("verb", ["export-ddq", "repair", "export", "picture"])
def test_a_full_disk_is_said_of_the_file_that_is_written(
    verb: str, learned: Path, tmp_path: Path
) -> None:
    output = tmp_path / "full" / "out"
    output.parent.mkdir()
    asked = {
        "export-ddq": ("export-ddq", output, "--db", learned),
        "repair": ("verify", "--db", learned, "--repair", output),
        "export": ("export", output.with_suffix(".jsonl"), "--db", learned),
        "picture": ("gallery", "--class", 4, "--db", learned, "-o", output.with_suffix(".png")),
    }[verb]

    def no_more() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))

    result = program(*asked, before=no_more)
    assert result.code == 3
    assert str(output) in result.err
    assert str(learned) not in result.err and ".patterndb-" not in result.err
    assert list(output.parent.iterdir()) == []


def test_merging_a_damaged_database_leaves_no_file(tiny: Path, tmp_path: Path) -> None:
    spoil(tiny, "UPDATE mesh SET distinct_patches = 127")
    result = run("merge", tiny, "--db", tmp_path / "new.db")
    assert_refused(result, 3, "is damaged", "--repair")
    assert not (tmp_path / "new.db").exists()
