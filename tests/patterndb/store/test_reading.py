"""Asking: patterns by name, classes, meshes, occurrences and counts."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from ingest import ingest, learn, read_mesh
from patterndb.core.code import canonical_code, pattern_id
from patterndb.core.packing import pack, unpack
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import NotFoundError
from patterndb.store import Database
from patterndb.store.connection import atomic
from patterndb.store.writing import add_patterns
from tests.support.meshes import DOUBLET, write_obj
from tests.support.store.learnt import MESHES, OPTIONS


def all_patterns(db: Database) -> list[Pattern]:
    classes = [db.pattern_class(n) for n in db.sides_histogram()]
    return [c.pattern(row) for c in classes for row in range(len(c))]


def test_classes_are_those_of_the_codes_and_share_out_all_patterns(full: Path) -> None:
    with Database(full) as db:
        assert sum(db.sides_histogram().values()) == db.statistics().patterns > 10
        for n_sides, n in db.sides_histogram().items():
            found = db.pattern_class(n_sides)
            assert len(found) == n
            patterns = [found.pattern(row) for row in range(n)]
            expected = PatternClass.from_patterns(n_sides, patterns)
            for column in fields(PatternClass):
                ours, theirs = getattr(found, column.name), getattr(expected, column.name)
                if column.name == "codes":
                    assert ours == theirs
                elif column.name == "n_meshes":
                    # Patterns do not tell; the occurrences do.
                    assert ours.tolist() == [len(db.occurrences(p)) for p in patterns]
                elif column.name not in {"n_sides", "cache", "tables"}:
                    np.testing.assert_array_equal(ours, theirs, err_msg=column.name)
                    assert ours.dtype == theirs.dtype
        assert len(db.pattern_class(99)) == 0
        assert db.pattern_class(99).joins.shape == (0, 99, 99)


def test_a_class_is_read_anew_after_a_change(full: Path) -> None:
    with Database(full, "write") as db:
        before = db.pattern_class(4)
        assert db.pattern_class(4) is before
        db.remove(["grid.obj"])
        assert db.pattern_class(4).frequency.sum() < before.frequency.sum()


def test_every_pattern_is_found_by_its_name_and_by_the_first_digits_that_are_its_own(
    full: Path,
) -> None:
    with Database(full) as db:
        names = [p.name for p in all_patterns(db)]
        for pattern in all_patterns(db):
            name = pattern.name
            found = db.pattern(name)
            assert (found.id, found.frequency) == (pattern.id, pattern.frequency)
            assert db.pattern(f" {name.upper()} ").id == pattern.id
            length = next(
                n for n in range(1, 17) if sum(other.startswith(name[:n]) for other in names) == 1
            )
            assert db.pattern(name[:length]).id == pattern.id
            if length > 1:
                with pytest.raises(NotFoundError, match="more than one"):
                    db.pattern(name[: length - 1])


@pytest.mark.parametrize("name", ["", "  ", "xyz", "0" * 17, "-1", "0x04", "7f" * 8, "ff" * 8])
def test_what_names_no_pattern(full: Path, name: str) -> None:
    with Database(full) as db, pytest.raises(NotFoundError):
        db.pattern(name)


def test_occurrences_are_what_each_mesh_teaches(full: Path, files: dict[str, Path]) -> None:
    taught: dict[str, set[tuple[object, ...]]] = {}
    for path in files.values():
        learned = learn(read_mesh(path).quads()[0], OPTIONS)
        for code, sides, (own, mirrored), example in zip(
            learned.codes, learned.sides, learned.patches.tolist(), learned.examples, strict=True
        ):
            faces = tuple(np.cumsum(unpack(example)).tolist())
            taught.setdefault(f"{pattern_id(code, int(sides)):016x}", set()).add(
                (path.name, own + mirrored, mirrored, faces)
            )
    with Database(full) as db:
        for pattern in all_patterns(db):
            found = db.occurrences(pattern)
            rows = [(o.mesh, o.patches, o.mirrored_patches, o.example) for o in found]
            assert set(rows) == taught.pop(pattern.name)
            assert rows == sorted(rows, key=lambda r: (-r[1], r[0]))
            assert sum(o.patches for o in found) == pattern.frequency
    assert not taught


def test_statistics_count_what_is_there(full: Path) -> None:
    with Database(full) as db:
        patterns = all_patterns(db)
        statistics = db.statistics()
        met = 0
        for pattern in patterns:
            found = db.occurrences(pattern)
            mirrored = sum(o.mirrored_patches for o in found)
            met += (mirrored > 0) + (mirrored < sum(o.patches for o in found))
        assert statistics.patterns_met == met
        assert statistics.patterns_oriented == len(patterns) + sum(p.chiral for p in patterns)
        assert statistics.meshes == len(MESHES) == len(db.meshes())
        assert statistics.patches == sum(m.distinct for m in db.meshes())
        assert statistics.patches == sum(p.frequency for p in patterns)
        irregular = [p.n_irregular for p in patterns]
        assert statistics.by_irregular == {n: irregular.count(n) for n in sorted(set(irregular))}
        words = {n: len(np.unique(db.pattern_class(n).signature)) for n in db.sides_histogram()}
        assert statistics.signatures == sum(words.values())
        assert statistics.content_hash == db.content_hash()


def test_meshes_are_listed_by_name(full: Path) -> None:
    with Database(full) as db:
        meshes = db.meshes()
        assert [m.name for m in meshes] == sorted(f"{name}.obj" for name in MESHES)
        for mesh in meshes:
            patterns = [o for p in all_patterns(db) for o in db.occurrences(p)]
            own = [o.patches for o in patterns if o.mesh == mesh.name]
            assert (mesh.patterns, mesh.distinct) == (len(own), sum(own))


def test_a_name_of_two_meshes_is_not_removed(full: Path, tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    again = write_obj(tmp_path / "more" / "cup.obj", DOUBLET[::-1])
    with Database(full, "write") as db:
        ingest(db, [again], OPTIONS)
        with pytest.raises(NotFoundError, match="2 meshes are called"):
            db.remove(["cup.obj"])
        with pytest.raises(NotFoundError, match="no mesh 'cu'"):
            db.remove(["cu"])


def staircase(steps: int) -> list[list[int]]:
    """A strip of quads that turns at each: every boundary vertex but few is a corner."""
    quads: list[list[int]] = []
    places: dict[tuple[int, int], int] = {}
    for i in range(steps):
        x, y = (i + 1) // 2, i // 2
        around = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        quads.append([places.setdefault(p, len(places)) for p in around])
    return quads


def test_classes_of_very_many_sides_share_ids_and_are_told_apart(tmp_path: Path) -> None:
    patterns = [Pattern.from_disk(QuadMesh.from_quads(staircase(n)).twin) for n in (61, 62, 63, 64)]
    sides = [p.n_sides for p in patterns]
    assert sides[0] < 127 < sides[-1]
    assert len(set(sides)) == 4
    assert max(p.id >> 56 for p in patterns) == 127
    with Database(tmp_path / "wide.db", "create") as db:
        with atomic(db._connection) as connection:
            add_patterns(connection, [p.id for p in patterns], [pack(p.code) for p in patterns])
        # Sound, except that no mesh has these patterns until they are used.
        assert len(db.verify()) == len(patterns)
        assert all("occurs in no mesh" in finding for finding in db.verify())
        for pattern in patterns:
            db.record_use(pattern)
        assert db.verify() == []
        for pattern in patterns:
            found = db.pattern_class(pattern.n_sides)
            assert found.ids.tolist() == [pattern.id]
            assert found.corners.tolist() == [list(pattern.corners)]
            assert canonical_code(db.pattern(pattern.name).twin())[0].tolist() == (
                pattern.code.tolist()
            )


def test_statistics_of_an_empty_database(tmp_path: Path) -> None:
    with Database(tmp_path / "empty.db", "create") as db:
        told = db.statistics()
    assert (told.patterns, told.signatures, told.by_sides, told.by_irregular) == (0, 0, {}, {})
