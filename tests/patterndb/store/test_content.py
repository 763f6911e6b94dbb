"""What a database holds depends on its meshes alone: not on order, repetition or what was there."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import pytest

from ingest import ingest
from patterndb.errors import DatabaseError
from patterndb.store import Database, LearningOptions, Provenance, writing
from patterndb.store.reading import sum_occurrences
from patterndb.store.records import OccurrenceRow
from patterndb.store.writing import insert_mesh
from tests.support.store.learnt import MESHES, OPTIONS, OTHER, change, content, learned, rows


def test_ingesting_again_changes_no_byte(full: Path, files: dict[str, Path]) -> None:
    before = full.read_bytes()
    with Database(full, "write") as db:
        report = ingest(db, list(files.values()), OPTIONS)
        assert {m.outcome for m in report.meshes} == {"unchanged"}
        assert {m.new_patterns for m in report.meshes} == {0}
    assert full.read_bytes() == before


def test_other_options_replace(full: Path, files: dict[str, Path], tmp_path: Path) -> None:
    with Database(full, "write") as db:
        report = ingest(db, [files["star"], files["fine"]], OTHER)
        assert [m.outcome for m in report.meshes] == ["replaced", "replaced"]
    rest = [f for name, f in files.items() if name not in ("star", "fine")]
    expected = learned(tmp_path / "expected.db", rest)
    learned(expected, [files["fine"], files["star"]], OTHER, "write")
    assert content(full) == content(expected)


def test_the_order_of_meshes_does_not_matter(tmp_path: Path, files: dict[str, Path]) -> None:
    names = ["cup", "star", "pair"]
    contents = {
        content(learned(tmp_path / f"{i}.db", [files[n] for n in order]))
        for i, order in enumerate(itertools.permutations(names))
    }
    assert len(contents) == 1
    for i in range(6):
        # Patterns have the same rows whenever they came.
        assert rows(tmp_path / f"{i}.db", "pattern") == rows(tmp_path / "0.db", "pattern")


def test_every_part_of_the_content_has_its_own_hash(tmp_path: Path, files: dict[str, Path]) -> None:
    sets = [c for n in range(4) for c in itertools.combinations(["cup", "star", "pair"], n)]
    contents = [
        content(learned(tmp_path / f"{'-'.join(c)}.db", [files[n] for n in c])) for c in sets
    ]
    contents.append(content(learned(tmp_path / "other.db", [files["cup"]], OTHER)))
    told = learned(tmp_path / "told.db", [files["cup"]])
    with Database(told, "write") as db:
        ingest(db, [files["cup"]], OPTIONS, provenance=Provenance(author="someone"))
    contents.append(content(told))
    assert len(set(contents)) == len(contents)


@pytest.mark.parametrize("gone", [["cup"], ["star", "fine"], list(MESHES)])
def test_after_removal_it_is_as_if_the_mesh_had_never_been(
    full: Path, files: dict[str, Path], tmp_path: Path, gone: list[str]
) -> None:
    without = learned(tmp_path / "without.db", [f for n, f in files.items() if n not in gone])
    with Database(full, "write") as db:
        before = db.statistics()
        removed = db.remove([f"{n}.obj" for n in gone])
        after = db.statistics()
    assert removed == (len(gone), before.patterns - after.patterns)
    assert content(full) == content(without)
    assert rows(full, "pattern") == rows(without, "pattern")


def test_a_mesh_is_removed_by_the_digits_of_its_hash(full: Path) -> None:
    with Database(full, "write") as db:
        mesh = next(m for m in db.meshes() if m.name == "star.obj")
        assert db.remove([mesh.sha256[:8], mesh.sha256.upper()])[0] == 1
        assert "star.obj" not in [m.name for m in db.meshes()]


SPLITS = [
    pytest.param(["cup", "star"], ["grid", "pair"], id="apart"),
    pytest.param(["cup", "star", "stars"], ["stars", "fine", "star"], id="overlapping"),
    pytest.param([], ["cup"], id="into an empty one"),
    pytest.param(["cup"], [], id="an empty one"),
    pytest.param(["cup", "fine"], ["cup", "fine"], id="the same"),
]


@pytest.mark.parametrize("at_once", [3, writing.WRITTEN_AT_ONCE])
@pytest.mark.parametrize(("ours", "theirs"), SPLITS)
def test_merging_is_ingesting_both(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    files: dict[str, Path],
    ours: list[str],
    theirs: list[str],
    at_once: int,
) -> None:
    monkeypatch.setattr(writing, "WRITTEN_AT_ONCE", at_once)
    a = learned(tmp_path / "a.db", [files[n] for n in ours])
    b = learned(tmp_path / "b.db", [files[n] for n in theirs])
    theirs_before = b.read_bytes()
    both = learned(tmp_path / "both.db", [files[n] for n in [*ours, *theirs]])
    with Database(a, "write") as db, Database(b) as other:
        common = len(set(ours) & set(theirs))
        assert db.merge(other) == (len(theirs) - common, 0, common)
        assert db.merge(other) == (0, 0, len(theirs))
    assert content(a) == content(both)
    assert b.read_bytes() == theirs_before
    # And the other way round.
    again = learned(tmp_path / "again.db", [files[n] for n in ours])
    with Database(b, "write") as db, Database(again) as other:
        db.merge(other)
    assert content(b) == content(both)


def test_merging_replaces_what_was_learned_with_other_options(
    tmp_path: Path, files: dict[str, Path]
) -> None:
    a = learned(tmp_path / "a.db", [files["cup"], files["star"], files["grid"]])
    b = learned(tmp_path / "b.db", [files["star"], files["fine"]], OTHER)
    both = learned(tmp_path / "both.db", [files["cup"], files["grid"]])
    learned(both, [files["star"], files["fine"]], OTHER, "write")
    with Database(a, "write") as db, Database(b) as other:
        assert db.merge(other) == (1, 1, 0)
    assert content(a) == content(both)


def test_a_database_is_not_merged_into_itself(full: Path) -> None:
    with (
        Database(full, "write") as db,
        Database(full) as same,
        pytest.raises(DatabaseError, match="into itself"),
    ):
        db.merge(same)


def test_frequencies_are_the_sums_of_patches(full: Path) -> None:
    with Database(full, "write") as db:
        for gone in ([], ["fine.obj"], ["cup.obj", "star.obj"]):
            db.remove(gone)
            sums: dict[int, int] = {}
            execute = db._connection.execute
            for pattern, patches in execute("SELECT pattern_id, patches FROM occurrence"):
                sums[pattern] = sums.get(pattern, 0) + patches
            assert dict(execute("SELECT id, frequency FROM counted_pattern").fetchall()) == sums
            for n_sides in db.sides_histogram():
                found = db.pattern_class(n_sides)
                assert found.frequency.tolist() == [sums[i] for i in found.ids.tolist()]


def test_the_same_options_are_kept(tmp_path: Path, files: dict[str, Path]) -> None:
    options = LearningOptions(3, 0, 9, prepare=True)
    path = learned(tmp_path / "one.db", [files["fine"]], options)
    with Database(path) as db:
        (mesh,) = db.meshes()
        assert mesh.options == options
        assert db.find_mesh(mesh.sha256) == mesh
        assert db.find_mesh("00" * 32) is None


def count_changed(path: Path) -> int:
    """Findings of meshes whose occurrences are not those that were written."""
    with Database(path) as db:
        return sum("occurrence_sum" in finding for finding in db.verify())


def test_an_example_that_changed_is_found(full: Path) -> None:
    assert count_changed(full) == 0
    # One example, as long as before.
    change(
        full,
        "UPDATE occurrence SET example = CAST(x'07' || substr(example, 2) AS BLOB) "
        "WHERE pattern_id = (SELECT max(pattern_id) FROM occurrence "
        "WHERE substr(example, 1, 1) <> x'07')",
    )
    assert count_changed(full) == 1


def test_sums_do_not_depend_on_the_order_of_rows_or_on_the_mesh() -> None:
    rows = [OccurrenceRow(number, 1, number + 1, 0, bytes([number])) for number in range(5)]
    others = [row._replace(mesh_id=2) for row in rows]
    assert sum_occurrences(rows) == sum_occurrences(others[::-1])
    assert sum_occurrences(rows[2:], sum_occurrences(rows[:2])) == sum_occurrences(rows)
    assert sum_occurrences(rows) != sum_occurrences(rows[:2])


def test_columns_of_a_mesh_are_those_of_the_schema(full: Path) -> None:
    """A new column of mesh is one in schema.sql, a field of Mesh, and a row here that uses it."""
    with Database(full) as db:
        columns = {row[1] for row in db._connection.execute("PRAGMA table_info(mesh)")}
        meshes = db.meshes()
    mesh = replace(
        meshes[0], sha256="07" * 32, provenance=Provenance("a", "b", "c"), left_out=3, patterns=0
    )
    assert mesh.to_columns().keys() == columns - {"id", "occurrence_sum"}
    with Database(full, "write") as db, db._change() as connection:
        insert_mesh(connection, mesh, bytes(16))
        assert db.find_mesh(mesh.sha256) == mesh
