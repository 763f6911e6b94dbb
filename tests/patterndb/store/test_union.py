"""Several databases asked as one: the lists of a merged database, weights, holders, and uses."""

from __future__ import annotations

import random
import shutil
from dataclasses import fields as dataclass_fields
from pathlib import Path

import numpy as np
import pytest

import patterndb
from patterndb.core.patternclass import PatternClass
from patterndb.errors import DatabaseError, NotFoundError
from patterndb.store import Database, DatabaseUnion
from patterndb.store.union import UnionMember
from query import Boundary, Fill, fills
from tests.support.store.learnt import OPTIONS, OTHER, learned, rows


@pytest.fixture
def halves(tmp_path: Path, files: dict[str, Path]) -> tuple[Path, Path]:
    """Two databases that share a mesh, which the second has learned with other options."""
    first = learned(tmp_path / "first.db", [files["cup"], files["star"], files["grid"]])
    second = learned(tmp_path / "second.db", [files["stars"], files["pair"], files["fine"]])
    learned(second, [files["star"]], OTHER, "write")
    return first, second


def merged(into: Path, other: Path) -> Path:
    """A copy of the second database into which the first is merged: its meshes win."""
    copy = Path(shutil.copy(other, into.with_name("merged.db")))
    with Database(copy, "write") as db, Database(into) as first:
        db.merge(first)
    return copy


def assert_same_class(one: PatternClass, other: PatternClass) -> None:
    """Signatures may be numbered otherwise: what they stand for is compared."""
    for field in dataclass_fields(PatternClass):
        if field.name in ("signature", "lengths", "joins", "cache"):
            continue
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == theirs.dtype, field.name
            assert np.array_equal(mine, theirs), field.name
        else:
            assert list(mine) == list(theirs) if field.name == "codes" else mine == theirs
    assert np.array_equal(one.lengths[one.signature], other.lengths[other.signature])
    assert np.array_equal(one.joins[one.signature], other.joins[other.signature])
    assert len(np.unique(one.signature)) == len(one.lengths)


def listed(source: Database | DatabaseUnion, boundary: Boundary, order: str) -> list[object]:
    found = fills(source, boundary, limit=25, order=order)
    return [(f.to_json(), f.pattern.code.tolist()) for f in found]


def test_classes_are_those_of_the_merged_database(halves: tuple[Path, Path]) -> None:
    with patterndb.open(list(halves)) as union, Database(merged(*halves)) as whole:
        assert isinstance(union, DatabaseUnion)
        assert union.sides_histogram() == whole.sides_histogram()
        assert [(m.name, m.sha256) for m in union.meshes()] == [
            (m.name, m.sha256) for m in whole.meshes()
        ]
        every = []
        for n_sides in whole.sides_histogram():
            assert_same_class(union.pattern_class(n_sides), whole.pattern_class(n_sides))
            every += whole.pattern_class(n_sides).ids.tolist()
        ids = np.array([*every, 7], np.int64)
        assert np.array_equal(union.frequencies(ids), whole.frequencies(ids))
        assert union.uses() == {}


def test_random_queries_list_the_same_as_the_merged_database(halves: tuple[Path, Path]) -> None:
    chance = random.Random(5)
    with patterndb.open(list(halves)) as union, Database(merged(*halves)) as whole:
        listings = 0
        for number in range(40):
            lengths = [chance.randint(2, 6) for _ in range(chance.randint(3, 5))]
            lengths[0] += sum(lengths) % 2
            order = ("artist", "regular")[number % 2]
            found = listed(union, Boundary(lengths), order)
            assert found == listed(whole, Boundary(lengths), order)
            listings += len(found)
        assert listings > 400


def test_what_was_loaded_is_kept_until_one_of_them_changes(
    halves: tuple[Path, Path], files: dict[str, Path]
) -> None:
    first, second = halves
    with patterndb.open([first, second]) as union:
        before = union.pattern_class(4)
        assert union.pattern_class(4) is before
        # By another program.
        with Database(second, "write") as other:
            other.remove(["stars.obj"])
        after = union.pattern_class(4)
        assert after is not before
        with Database(merged(first, second)) as whole:
            assert_same_class(after, whole.pattern_class(4))


def test_a_weight_multiplies_what_its_database_counts(halves: tuple[Path, Path]) -> None:
    first, second = halves
    with (
        patterndb.open([(first, 1.0), (second, 3.0)]) as heavy,
        patterndb.open([(first, 0.25)]) as light,
        patterndb.open([first, second]) as plain,
        Database(first) as one,
    ):
        for n_sides in plain.sides_histogram():
            ids = plain.pattern_class(n_sides).ids
            own, both = one.frequencies(ids), plain.frequencies(ids)
            weighed = heavy.pattern_class(n_sides)
            expected = dict(zip(ids.tolist(), (own + 3 * (both - own)).tolist(), strict=True))
            assert dict(zip(weighed.ids.tolist(), weighed.frequency.tolist(), strict=True)) == (
                expected
            )
            assert np.array_equal(heavy.frequencies(weighed.ids), weighed.frequency)
            # The default order goes by the sums.
            keys = list(zip(weighed.n_irregular, -weighed.frequency, weighed.ids, strict=True))
            assert keys == sorted(keys)
            # Half a patch is a patch: what was seen stays seen.
            quarter = light.frequencies(ids)
            assert np.array_equal(quarter, np.where(own > 0, np.maximum(np.rint(own / 4), 1), 0))


def test_holders_tell_databases_and_meshes(halves: tuple[Path, Path]) -> None:
    first, second = halves
    with patterndb.open([first, (second, 2.0)]) as union:
        for n_sides in union.sides_histogram():
            patterns = union.pattern_class(n_sides)
            for row in range(len(patterns)):
                pattern = patterns.pattern(row)
                holders = union.find_occurrences(pattern)
                assert holders
                for holder in holders:
                    path = Path(holder.database)
                    assert holder.weight == (1.0 if path == first else 2.0)
                    with Database(path) as db:
                        met = db.occurrences(pattern)
                    assert set(holder.meshes) == {one.mesh for one in met}
                    assert holder.patches == sum(one.patches for one in met)
    unknown = next(fills(Database(first), (9, 9, 9, 9, 9, 9, 8), origins=["family"])).pattern
    with patterndb.open([first, second]) as union:
        assert union.find_occurrences(unknown) == []


def test_the_starter_and_a_database_of_ones_own(
    tmp_path: Path, files: dict[str, Path], source: Database
) -> None:
    own = learned(tmp_path / "own.db", list(files.values()))
    with patterndb.open([":starter:", own]) as union, Database(own) as mine:
        for n_sides in (3, 5):
            theirs = source.pattern_class(n_sides)
            ids = np.union1d(theirs.ids, mine.pattern_class(n_sides).ids)
            united = union.pattern_class(n_sides)
            assert np.array_equal(np.sort(united.ids), ids)
            total = source.frequencies(united.ids) + mine.frequencies(united.ids)
            assert np.array_equal(united.frequency, total)
            pattern = mine.pattern_class(n_sides).pattern(0)
            assert {holder.database for holder in union.find_occurrences(pattern)} >= {str(own)}
            common = np.intersect1d(theirs.ids, mine.pattern_class(n_sides).ids)
            if len(common):
                held = union.find_occurrences(union.pattern(f"{int(common[0]):016x}"))
                assert [holder.database for holder in held] == [":starter:", str(own)]
                assert held[0].patches == source.frequencies(common[:1])[0]
        with pytest.raises(DatabaseError, match="none of :starter:"):
            union.record_use(pattern)


def test_a_mesh_that_the_starter_has_counts_once() -> None:
    """Beside its own SQLite file every mesh is known already."""
    with patterndb.open() as starter:
        starter.content_hash()
        file = starter.path
        assert file.suffix == ".db"
        hashes = [mesh.sha256 for mesh in starter.meshes()[:3]]
        with Database(file) as unpacked, patterndb.open([None, file]) as union:
            held = unpacked.pattern_class(3)
            for ids in (held.ids[::-1], np.array([5, held.ids[0]])):
                for mine, theirs in zip(
                    starter.count_in_meshes(ids, hashes),
                    unpacked.count_in_meshes(ids, hashes),
                    strict=True,
                ):
                    assert mine.dtype == theirs.dtype
                    assert np.array_equal(mine, theirs)
                    assert mine[-1] > 0 or len(ids) > 2
            for number in held.ids[:5].tolist():
                assert starter.count_by_mesh(number) == unpacked.count_by_mesh(number)
            assert starter.count_by_mesh(5) == {}
            assert_same_class(union.pattern_class(3), held)


def test_ids_are_chosen_by_meshes_of_any_of_them(halves: tuple[Path, Path]) -> None:
    with patterndb.open(list(halves)) as union, Database(merged(*halves)) as whole:
        for meshes in (["cup.obj"], ["pair.obj", "star.obj"], None):
            for n_sides in (None, 4):
                assert np.array_equal(
                    union.pattern_ids(n_sides, meshes), whole.pattern_ids(n_sides, meshes)
                )
        with pytest.raises(NotFoundError, match=r"no mesh 'cap\.obj' \(did you mean 'cup\.obj'\?"):
            union.pattern_ids(4, ["cap.obj"])
        name = whole.pattern_class(4).pattern(0).name
        assert union.pattern(name) == whole.pattern(name)
        with pytest.raises(NotFoundError, match="more than one"):
            union.pattern(name[:2])


def first_fill(source: DatabaseUnion) -> Fill:
    return next(fills(source, (3, 3, 3, 3)))


def test_an_accepted_fill_goes_to_the_first_that_is_writable(halves: tuple[Path, Path]) -> None:
    first, second = halves
    with patterndb.open([None, first, second], "write") as union:
        fill = first_fill(union)
        assert union.find_writable().name == str(first)
        assert union.record_use(fill.pattern) == 1
        assert union.record_use(fill.pattern, 2) == 3
        used = union.pattern_class(4)
        assert used.uses[used.ids == fill.pattern.id].tolist() == [3]
        assert union.uses() == {fill.pattern.id: 3}
    assert rows(first, "usage")
    assert rows(second, "usage") == []


def test_uses_of_all_are_added(halves: tuple[Path, Path]) -> None:
    pattern = Database(halves[0]).pattern_class(4).pattern(0)
    for path, count in zip(halves, (2, 3), strict=True):
        with Database(path, "write") as db:
            db.record_use(pattern, count)
    with patterndb.open(list(halves)) as union:
        held = union.pattern_class(4)
        assert held.uses[held.ids == pattern.id].tolist() == [5]
        with pytest.raises(DatabaseError, match="open for writing"):
            union.record_use(pattern)


def test_what_cannot_be_a_union_is_refused(halves: tuple[Path, Path], tmp_path: Path) -> None:
    first, _ = halves
    with pytest.raises(DatabaseError, match="given twice"):
        patterndb.open([first, first.parent / "." / first.name])
    with pytest.raises(DatabaseError, match="there is no database"):
        patterndb.open([first, tmp_path / "none.db"])
    for weight in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="above 0"):
            patterndb.open([(first, weight)])
    with pytest.raises(ValueError, match="at least one"):
        patterndb.open([])
    with pytest.raises(ValueError, match="read or to write"):
        patterndb.open([first], "create")
    with pytest.raises(DatabaseError, match="starter database is never written"):
        patterndb.open([None], "write")


def test_two_patterns_of_one_id_are_refused(
    halves: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Database(halves[0]) as one, Database(halves[1]) as two:
        fours = two.pattern_class(4)
        swapped = [*fours.codes[1:], fours.codes[0]]
        broken = PatternClass(
            **{
                field.name: swapped if field.name == "codes" else getattr(fours, field.name)
                for field in dataclass_fields(PatternClass)
            }
        )
        monkeypatch.setattr(two, "pattern_class", lambda n_sides: broken)
        union = DatabaseUnion([UnionMember(one, "one"), UnionMember(two, "two")])
        with pytest.raises(DatabaseError, match="collide"):
            union.pattern_class(4)


def test_no_file_is_made(halves: tuple[Path, Path]) -> None:
    folder = halves[0].parent
    before = sorted(path.name for path in folder.iterdir())
    with patterndb.open(list(halves)) as union:
        list(fills(union, (3, 4, 3, 4, 4), limit=5))
        assert sorted(path.name for path in folder.iterdir()) == before


def test_the_options_are_those_of_the_first(halves: tuple[Path, Path]) -> None:
    assert OPTIONS != OTHER
    for one, other in (halves, halves[::-1]):
        with patterndb.open([one, other]) as union, Database(one) as first:
            mine = {mesh.sha256: mesh.options for mesh in first.meshes()}
            for mesh in union.meshes():
                assert mesh.options == mine.get(mesh.sha256, mesh.options)
