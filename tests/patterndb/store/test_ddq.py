"""Tables of the authors' layout: out and in again, and what is refused."""

from __future__ import annotations

import random
import sqlite3
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from patterndb._native.store.ddqkey import smallest_key
from patterndb.core.code import canonical_code
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from patterndb.errors import DatabaseError, NotFoundError
from patterndb.store import Database, Provenance, ddq, read_table
from patterndb.store.ddqkey import fewest_digits
from tests.support.meshes import TRIANGLE, disks, grid
from tests.support.store.learnt import change, content

COUNTS = (
    "SELECT id, sum(patches), sum(mirrored_patches), frequency FROM counted_pattern "
    "JOIN occurrence ON pattern_id = id GROUP BY id ORDER BY id"
)


def counts(path: Path) -> list[tuple[int, ...]]:
    with Database(path) as db:
        assert db.verify() == []
        return db._connection.execute(COUNTS).fetchall()


def row_of(twin: list[int] | np.ndarray, number: int, digits: int | None = None) -> tuple:
    """The row of a disk as it is, not reduced."""
    code, mirrored, _, _ = canonical_code(np.array(twin, np.int32))
    return ddq._row(code, mirrored, number, digits)


def table(path: Path, rows: Iterable[tuple]) -> Path:
    connection = sqlite3.connect(path)
    connection.execute("CREATE TABLE patches (" + ", ".join(ddq.COLUMNS) + ")")
    connection.executemany(ddq._INSERT, rows)
    connection.commit()
    connection.close()
    return path


def imported(path: Path, *files: Path) -> Path:
    with Database(path, "create") as db:
        for file in files:
            db.import_ddq(read_table(file))
    return path


TRI = row_of(QuadMesh.from_quads(TRIANGLE).twin, 5)


@pytest.mark.parametrize("digits", [None, 16])
def test_what_was_learned_comes_back(full: Path, tmp_path: Path, digits: int | None) -> None:
    with Database(full) as db:
        done = db.export_ddq(tmp_path / "out.db", digits=digits)
        statistics = db.statistics()
    assert (done.patterns, done.rows) == (statistics.patterns, statistics.patterns_met)
    assert done.occurrences == statistics.patches
    found = read_table(tmp_path / "out.db")
    assert (found.rows, found.refused, found.unlike) == (done.rows, 0, 0)
    again = imported(tmp_path / "again.db", tmp_path / "out.db")
    assert counts(again) == counts(full)
    with Database(again) as db:
        (mesh,) = db.meshes()
        assert (mesh.name, mesh.origin, mesh.sha256) == ("out.db", "imported", found.sha256)
        assert (mesh.distinct, mesh.quads_read) == (statistics.patches, 0)
        pattern = db.pattern_class(4).pattern(0)
        assert pattern.origin == "imported"
        (occurrence,) = db.occurrences(pattern)
        assert occurrence.example == ()
        # And out once more: the same file, byte for byte.
        db.export_ddq(tmp_path / "third.db", digits=digits)
    assert (tmp_path / "third.db").read_bytes() == (tmp_path / "out.db").read_bytes()
    assert list(tmp_path.glob(".*")) == []


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(twins=st.lists(disks(most=16), min_size=1, max_size=6), seed=st.integers(0, 99))
def test_rows_of_any_disks_are_reduced_and_merged(
    twins: list[list[int]], seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("any")
    chance = random.Random(seed)
    rows = []
    expected: dict[int, list[int]] = {}
    for twin in twins:
        number = chance.randint(1, 9)
        clockwise = chance.random() < 0.5
        code = canonical_code(np.array(twin, np.int32))[0]
        digits = fewest_digits(len(code) // 4) + chance.randint(0, 3)
        rows.append(ddq._row(code, clockwise, number, digits))
        rooted = smallest_key(code, clockwise)[1]
        pattern_code, mirrored, _, _ = canonical_code(reduce_disk(rooted))
        held = expected.setdefault(Pattern.from_code(pattern_code).id, [0, 0])
        held[0] += number
        held[1] += number * mirrored
    db = imported(folder / "db.db", table(folder / "any.db", rows))
    assert counts(db) == [(i, n, m, n) for i, (n, m) in sorted(expected.items())]


def test_the_same_file_is_imported_once_and_can_be_taken_out(full: Path, tmp_path: Path) -> None:
    before = content(full)
    file = table(tmp_path / "t.db", [TRI, row_of(QuadMesh.from_quads(grid(2, 3)).twin, 7)])
    found = read_table(file)
    with Database(full, "write") as db:
        square = db.pattern_class(4).pattern(0)
        frequency = square.frequency
        assert db.import_ddq(found)[0] == "imported"
        assert db.import_ddq(found) == ("unchanged", 0)
        said = Provenance("they", None, "research")
        assert db.import_ddq(found, said) == ("updated", 0)
        assert db.import_ddq(found, Provenance("they")) == ("unchanged", 0)
        # A grid is one quad when it is reduced; meshes hold it too.
        assert db.pattern(square.name).frequency == frequency + 7
        assert db.pattern(square.name).origin == "learned"
        assert content(full) != before
        db.remove(["t.db"])
    assert content(full) == before


def test_an_imported_table_is_merged_and_packed(full: Path, tmp_path: Path) -> None:
    from patterndb.store.compact import load

    with Database(full, "write") as db:
        db.import_ddq(read_table(table(tmp_path / "t.db", [TRI])))
        load(db.compact(), tmp_path / "packed.db")
        with Database(tmp_path / "merged.db", "create") as merged:
            merged.merge(db)
    assert content(tmp_path / "packed.db") == content(tmp_path / "merged.db") == content(full)


def spoilt(**columns: object) -> tuple:
    row = dict(zip(ddq.COLUMNS, TRI, strict=True)) | columns
    return tuple(row.values())


BAD = {
    "no key": (spoilt(topology=None), "topology is NULL, not text"),
    "a blob": (spoilt(topology=b"12###21##"), "topology is a BLOB, not text"),
    "a number": (spoilt(topology=12), "topology is a number, not text"),
    "no faces": (spoilt(nFaces=0), "nFaces is 0"),
    "faces as text": (spoilt(nFaces="three"), "nFaces is text, not a whole number"),
    "a fraction": (spoilt(nVertices=7.5), "nVertices is a number, not a whole number"),
    "NULL": (spoilt(nConcaveCorners=None), "nConcaveCorners is NULL"),
    "other faces": (spoilt(nFaces=4), "which is not 1 to 16"),
    "vertices": (spoilt(nVertices=8), "nVertices is 8, but topology has 7"),
    "corners": (spoilt(nCorners=4), "nCorners is 4, but topology has 3"),
    "concave": (spoilt(nConcaveCorners=1), "nConcaveCorners is 1, but topology has 0"),
    "never": (spoilt(nOccurrences=0), "nOccurrences is 0"),
    "too often": (spoilt(nOccurrences=1 << 62), "nOccurrences is"),
    "no disk": (spoilt(topology="12###2###"), "named back"),
    "giant": (spoilt(topology="#" * (ddq.MAX_VALUE_BYTES + 1)), "more than 1048576 bytes"),
    "giant elsewhere": (spoilt(boundaryIDs="x" * (1 << 21)), "more than 1048576 bytes"),
}


def test_bad_rows_are_left_out_and_told(tmp_path: Path) -> None:
    rows = [row for row, _ in BAD.values()]
    file = table(tmp_path / "bad.db", [*rows[:8], TRI, *rows[8:]])
    change(
        file,
        "INSERT INTO patches SELECT CAST(x'ff2323' AS TEXT), boundaryIDs, singularities, 0, "
        "4, 1, 4, 1, 0 FROM patches WHERE rowid = 9",
    )
    found = read_table(file)
    words = [word for _, word in BAD.values()]
    assert (found.rows, found.refused) == (len(rows) + 2, len(rows) + 1)
    assert [r.rowid for r in found.told] == [i for i in range(1, len(rows) + 3) if i != 9]
    for refused, word in zip(found.told, [*words, "not UTF-8"], strict=True):
        assert word in refused.reason, refused
        assert len(refused.key) <= ddq.SHOWN
    assert found.learned.patches.tolist() == [[5, 0]]


def test_what_the_faces_tell_is_believed_where_irregular_vertices_are_miscounted(
    tmp_path: Path,
) -> None:
    found = read_table(table(tmp_path / "t.db", [spoilt(nSingularities=3, singularities=b"?")]))
    assert (found.refused, found.unlike, found.learned.distinct) == (0, 1, 5)


def test_many_refusals_are_counted_and_the_first_told(tmp_path: Path) -> None:
    rows = [spoilt(nFaces=0)] * (ddq.TOLD + 7)
    found = read_table(table(tmp_path / "t.db", [*rows, TRI]))
    assert (found.refused, len(found.told)) == (ddq.TOLD + 7, ddq.TOLD)


def no_table(path: Path) -> None:
    change(path, "CREATE TABLE other (a)")


def no_columns(path: Path) -> None:
    change(path, "CREATE TABLE Patches (topology TEXT, boundaryIDs, singularities, nFaces)")


def a_view(path: Path) -> None:
    table(path, [TRI])
    change(path, "ALTER TABLE patches RENAME TO t", "CREATE VIEW Patches AS SELECT * FROM t")


def without_rowid(path: Path) -> None:
    columns = ", ".join(ddq.COLUMNS[1:])
    change(path, f"CREATE TABLE Patches (topology TEXT PRIMARY KEY, {columns}) WITHOUT ROWID")


def hidden_rowid(path: Path) -> None:
    table(path, [TRI])
    change(path, "ALTER TABLE patches ADD COLUMN rowid TEXT")


def all_bad(path: Path) -> None:
    table(path, [spoilt(nFaces=9)] * 3)


def cut(path: Path) -> None:
    table(path, [row_of(QuadMesh.from_quads(grid(1, n)).twin, 1) for n in range(1, 60)])
    path.write_bytes(path.read_bytes()[:5000])


def in_use(path: Path) -> None:
    table(path, [TRI])
    path.with_name(path.name + "-wal").write_bytes(b"x" * 99)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: p.write_bytes(b"topology,boundaryIDs\n" * 99), "is not an SQLite file"),
        (lambda p: p.touch(), "is empty"),
        (lambda p: p.mkdir(), "is a directory"),
        (lambda p: Database(p, "create").close(), "patterndb merge"),
        (no_table, "has no table Patches"),
        (no_columns, "lacks the column nSingularities, nCorners, nVertices"),
        (a_view, "is no ordinary table"),
        (without_rowid, "has no rowid"),
        (hidden_rowid, "in place of its rowid"),
        (all_bad, "none of its 3 rows can be used; row 1: "),
        (cut, "damaged|none of its"),
        (in_use, "open in another program"),
    ],
)
def test_files_that_are_no_such_table(make, words: str, tmp_path: Path) -> None:
    path = tmp_path / "file.db"
    make(path)
    with pytest.raises(DatabaseError, match=words):
        read_table(path)


def test_nothing_to_import_or_export(tmp_path: Path) -> None:
    with pytest.raises(NotFoundError, match="no row"):
        read_table(table(tmp_path / "none.db", []))
    with (
        Database(tmp_path / "new.db", "create") as db,
        pytest.raises(NotFoundError, match="no pattern"),
    ):
        db.export_ddq(tmp_path / "out.db")
    with pytest.raises(FileNotFoundError):
        read_table(tmp_path / "gone.db")
    assert not (tmp_path / "out.db").exists()


def test_export_leaves_no_half_written_file(full: Path, tmp_path: Path) -> None:
    (tmp_path / "there.db").write_text("mine")

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with Database(full) as db:
        with pytest.raises(DatabaseError, match="already"):
            db.export_ddq(tmp_path / "there.db")
        with pytest.raises(DatabaseError, match="no folder"):
            db.export_ddq(tmp_path / "none" / "out.db")
        with pytest.raises(DatabaseError, match="digits do not do"):
            db.export_ddq(tmp_path / "out.db", digits=17)
        before = sorted(tmp_path.iterdir())
        with pytest.raises(KeyboardInterrupt):
            db.export_ddq(tmp_path / "out.db", progress=stop)
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "there.db").read_text() == "mine"


def test_patterns_that_were_only_used_are_not_exported(full: Path, tmp_path: Path) -> None:
    with Database(full, "write") as db:
        before = db.export_ddq(tmp_path / "before.db")
        pattern = db.pattern_class(5).pattern(0)
        db.remove([m.name for m in db.meshes()][1:])
        db.record_use(pattern)
        assert db.export_ddq(tmp_path / "after.db").patterns < before.patterns
        db.remove([m.name for m in db.meshes()])
        with pytest.raises(NotFoundError):
            db.export_ddq(tmp_path / "none.db")


def test_the_layout_is_the_authors(full: Path, tmp_path: Path) -> None:
    """Names and order of columns, and the index, as their program asks for them."""
    with Database(full) as db:
        db.export_ddq(tmp_path / "out.db", digits=16)
    out = sqlite3.connect(tmp_path / "out.db")
    names = [row[1] for row in out.execute("PRAGMA table_info(Patches)")]
    assert tuple(names) == ddq.COLUMNS
    rows = out.execute(
        f"SELECT {', '.join(ddq.COLUMNS)} FROM Patches INDEXED BY Patches_index "
        "WHERE nCorners = 4 ORDER BY nSingularities ASC, singularities ASC, nOccurrences DESC"
    ).fetchall()
    assert rows[0][:7] == ("#" * 48, "x0000-x0001-x0000-x0001", "", 0, 4, 1, 4)
