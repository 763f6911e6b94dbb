"""Sums over rows: every write keeps them, and whatever else changes a row is found."""

from __future__ import annotations

from pathlib import Path

import pytest

from ingest import ingest
from patterndb.errors import DatabaseError
from patterndb.store import Database, Provenance, checksums, compact
from tests.support.store.learnt import OPTIONS, OTHER, change


def are_kept(db: Database) -> bool:
    return checksums.find_changed_tables(db._connection) == []


def test_every_way_to_write_keeps_the_sums(
    full: Path, files: dict[str, Path], tmp_path: Path
) -> None:
    with Database(full, "write") as db, Database(tmp_path / "other.db", "create") as other:
        assert are_kept(db) and are_kept(other)
        pattern = db.pattern_class(4).pattern(0)
        for _ in range(2):
            db.record_use(pattern, 2)
            assert are_kept(db)
        db.remove(["cup.obj", "grid.obj"])
        assert are_kept(db)
        ingest(db, [files["cup"]], OPTIONS, jobs=1)
        assert are_kept(db)
        # Taught anew, then said to come from elsewhere.
        ingest(db, [files["cup"]], OTHER, provenance=Provenance("x"), jobs=1)
        assert are_kept(db)
        ingest(db, [files["cup"]], OTHER, provenance=Provenance("y", None, "CC0"), jobs=1)
        assert are_kept(db)
        ingest(other, [files["cup"], files["star"]], OPTIONS, jobs=1)
        other.merge(db)
        assert are_kept(other)
        compact.load(other.compact(), tmp_path / "loaded.db")
    with Database(tmp_path / "loaded.db") as loaded:
        assert are_kept(loaded)


@pytest.mark.parametrize(
    ("table", "statement"),
    [
        # One example, as long as before.
        (
            "occurrence",
            "UPDATE occurrence SET example = CAST(x'07' || substr(example, 2) AS BLOB) "
            "WHERE pattern_id = (SELECT max(pattern_id) FROM occurrence "
            "WHERE substr(example, 1, 1) <> x'07')",
        ),
        ("mesh", "UPDATE mesh SET licence = 'mine'"),
        ("mesh", "UPDATE mesh SET quads_read = quads_read + 1 WHERE id = 1"),
        ("usage", "UPDATE usage SET uses = uses + 1"),
    ],
)
def test_what_nothing_else_tells_is_found(full: Path, table: str, statement: str) -> None:
    with Database(full, "write") as db:
        db.record_use(db.pattern_class(4).pattern(0))
    change(full, statement)
    with Database(full) as db:
        assert any(f"table {table}" in finding for finding in db.verify())


def test_a_file_without_sums_is_refused_when_it_is_written(full: Path) -> None:
    change(full, "DELETE FROM checksum")
    with Database(full, "write") as db:
        with pytest.raises(DatabaseError, match="no checksum"):
            db.remove(["cup.obj"])
        assert any("checksum" in finding for finding in db.verify())


def test_sums_do_not_depend_on_the_order_of_rows() -> None:
    rows = [(1, b"a", None), (2, "b", 0.5), (3, b"", "ä")]
    assert checksums.sum_rows(rows) == checksums.sum_rows(rows[::-1])
    assert checksums.sum_rows(rows) != checksums.sum_rows(rows[:2])
    assert checksums.sum_rows([(1, "1")]) != checksums.sum_rows([(1, b"1")])
