"""Recorded uses: what they count, what they keep alive, and what they leave as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ingest import ingest
from patterndb.core.code import canonical_code
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store import Database
from patterndb.store.compact import load
from tests.support.meshes import grid, star
from tests.support.store.learnt import OPTIONS, change, content, learned, rows


def pattern_of(quads: list[list[int]], origin: str) -> Pattern:
    code = canonical_code(QuadMesh.from_quads(quads).twin)[0]
    return Pattern.from_code(code, origin=origin)


#: In no mesh of the tests.
UNMET = pattern_of(star(11), "family")


def origin_of(db: Database, pattern: Pattern) -> str:
    found = db.pattern_class(pattern.n_sides)
    row = int(np.flatnonzero(found.ids == pattern.id)[0])
    assert db.pattern(pattern.name).origin == found.pattern(row).origin
    return found.pattern(row).origin


def test_uses_are_counted_by_pattern_and_by_code(full: Path) -> None:
    before = content(full)
    with Database(full, "write") as db:
        first = db.pattern_class(4).pattern(0)
        assert db.uses() == {}
        assert db.record_use(first) == 1
        assert db.record_use(first.code, 4) == 5
        assert db.record_use(UNMET, 2) == 2
        assert db.uses() == {first.id: 5, UNMET.id: 2}
        for n_sides in db.sides_histogram():
            found = db.pattern_class(n_sides)
            assert found.uses.dtype == np.int64
            assert found.uses.tolist() == [db.uses().get(i, 0) for i in found.ids.tolist()]
    # What was learned is what it was, and the database sound.
    assert content(full) == before


def test_only_the_class_of_the_pattern_is_read_anew(full: Path) -> None:
    with Database(full, "write") as db:
        four, three = db.pattern_class(4), db.pattern_class(3)
        db.record_use(four.pattern(0))
        assert db.pattern_class(3) is three
        assert db.pattern_class(4) is not four


@pytest.mark.parametrize("origin", ["family", "constructed", "imported", "learned"])
def test_a_pattern_that_is_not_there_comes_with_its_origin(full: Path, origin: str) -> None:
    before = content(full)
    pattern = pattern_of(star(11), origin)
    with Database(full, "write") as db:
        db.record_use(pattern)
        assert origin_of(db, pattern) == origin
        assert db.pattern(pattern.name).frequency == 0
        assert db.occurrences(pattern) == []
        # Used again as something else, it stays what it was.
        db.record_use(pattern_of(star(11), "constructed"))
        assert origin_of(db, pattern) == origin
    assert content(full) == before


def test_what_is_learned_after_it_was_used_is_learned_while_it_is_there(
    tmp_path: Path, files: dict[str, Path]
) -> None:
    path = learned(tmp_path / "used.db", [files["cup"]])
    with Database(path, "write") as db, Database(learned(tmp_path / "s.db", [files["star"]])) as s:
        mine = {int(i) for n in db.sides_histogram() for i in db.pattern_class(n).ids}
        theirs = [s.pattern_class(n).pattern(0) for n in s.sides_histogram()]
        pattern = next(p for p in theirs if p.id not in mine)
        db.record_use(Pattern.from_code(pattern.code, origin="constructed"))
        assert origin_of(db, pattern) == "constructed"
        ingest(db, [files["star"]], OPTIONS)
        assert origin_of(db, pattern) == "learned"
        db.remove(["star.obj"])
        # As if the mesh had never been; what was used stays.
        assert origin_of(db, pattern) == "constructed"
        assert db.uses() == {pattern.id: 1}
        assert db.verify() == []
    assert content(path) == content(learned(tmp_path / "without.db", [files["cup"]]))


def test_a_used_pattern_outlives_its_mesh(full: Path, files: dict[str, Path]) -> None:
    with Database(full, "write") as db:
        pattern = db.pattern_class(5).pattern(0)
        db.record_use(pattern, 3)
        db.remove([f"{name}.obj" for name in files])
        assert db.sides_histogram() == {5: 1}
        assert (db.uses(), origin_of(db, pattern)) == ({pattern.id: 3}, "learned")
        assert db.verify() == []
    change(full, "DELETE FROM usage")
    with Database(full) as db:
        (finding,) = db.verify()
        assert "was never used" in finding


def test_merging_and_packing_leave_uses_out(full: Path, tmp_path: Path) -> None:
    before = content(full)
    with Database(full, "write") as db:
        db.record_use(UNMET)
        db.record_use(db.pattern_class(4).pattern(0), 7)
        data = db.compact()
        with Database(tmp_path / "merged.db", "create") as merged:
            merged.merge(db)
            assert merged.uses() == {}
    load(data, tmp_path / "packed.db")
    for name in ("merged.db", "packed.db"):
        assert content(tmp_path / name) == before
        assert rows(tmp_path / name, "usage") == []


def test_what_is_refused_changes_nothing(full: Path) -> None:
    bytes_before = full.read_bytes()
    reducible = canonical_code(QuadMesh.from_quads(grid(2, 2)).twin)[0]
    with Database(full, "write") as db:
        for count in (0, -1, 1 << 41):
            with pytest.raises(ValueError, match="count must lie in"):
                db.record_use(UNMET, count)
        with pytest.raises(ValueError, match="origin"):
            db.record_use(pattern_of(star(11), "dreamt"))
        for code in (reducible, np.array([9, 0, 0, 0], np.uint16)):
            with pytest.raises(InvalidCodeError):
                db.record_use(code)
        assert db.uses() == {}
    assert full.read_bytes() == bytes_before


def test_a_database_that_is_only_read_says_what_to_do(full: Path) -> None:
    with Database(full) as db, pytest.raises(DatabaseError, match="--db FILE"):
        db.record_use(UNMET)
    with Database(full, immutable=True) as db, pytest.raises(DatabaseError, match="copy it"):
        db.record_use(UNMET)
