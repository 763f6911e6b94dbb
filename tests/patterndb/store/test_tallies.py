"""The counts that every write keeps are those of the rows, whatever was written in any order."""

from __future__ import annotations

import random
import sqlite3
from collections import Counter
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ingest import ingest
from patterndb.errors import DatabaseError
from patterndb.store import Database, tallies
from patterndb.store.columns import read_in_parts
from patterndb.store.connection import atomic
from patterndb.store.records import Statistics
from patterndb.store.tallies import _take_out, tally_anew
from patterndb.store.writing import remove_meshes
from query import fills
from tests.support.store.learnt import MESHES, OPTIONS, OTHER, change, learned, write_meshes


def count_rows(path: Path) -> Statistics:
    """Statistics as the rows of patterns, occurrences and meshes have them, one by one."""
    held = sqlite3.connect(path)
    patterns = held.execute(
        "SELECT id, n_sides, n_irregular, chiral, signature FROM pattern"
    ).fetchall()
    met = {
        (number, mirrored)
        for number, patches, of_mirrored in held.execute(
            "SELECT pattern_id, patches, mirrored_patches FROM occurrence"
        )
        for mirrored, count in ((False, patches - of_mirrored), (True, of_mirrored))
        if count
    }
    meshes = held.execute("SELECT distinct_patches FROM mesh").fetchall()
    held.close()
    with Database(path) as db:
        content_hash = db.content_hash()
    return Statistics(
        patterns=len(patterns),
        patterns_oriented=len(patterns) + sum(row[3] for row in patterns),
        patterns_met=len(met),
        by_sides=dict(sorted(Counter(row[1] for row in patterns).items())),
        by_irregular=dict(sorted(Counter(row[2] for row in patterns).items())),
        signatures=len({row[4] for row in patterns}),
        meshes=len(meshes),
        patches=sum(row[0] for row in meshes),
        content_hash=content_hash,
    )


def check_counts(path: Path) -> Statistics:
    """The statistics of a sound database, which are those of its rows."""
    with Database(path) as db:
        assert db.verify() == []
        told = db.statistics()
        assert db.sides_histogram() == told.by_sides
    assert told == count_rows(path)
    return told


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return write_meshes(tmp_path_factory.mktemp("meshes"))


@pytest.fixture(scope="module")
def others(files: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Databases to be merged: of the same meshes, with the same options and with others."""
    folder = tmp_path_factory.mktemp("others")
    return [
        learned(folder / "some.db", [files["cup"], files["stars"]]),
        learned(folder / "less.db", [files["star"], files["fine"]], OTHER),
    ]


@settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    steps=st.lists(
        st.one_of(
            st.tuples(st.just("learn"), st.sampled_from(sorted(MESHES)), st.booleans()),
            st.tuples(st.just("remove"), st.sets(st.sampled_from(sorted(MESHES)), min_size=1)),
            st.tuples(st.just("merge"), st.integers(0, 1)),
            st.tuples(st.just("use"), st.integers(0, 40)),
        ),
        min_size=3,
        max_size=9,
    )
)
def test_counts_are_those_of_the_rows_after_every_change(
    steps: list[tuple[object, ...]],
    files: dict[str, Path],
    others: list[Path],
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    path = tmp_path_factory.mktemp("kept") / "kept.db"
    learned(path, [files["grid"]])
    for what, *with_ in steps:
        with Database(path, "write") as db:
            if what == "learn":
                name, fewer = with_
                ingest(db, [files[str(name)]], OTHER if fewer else OPTIONS, jobs=1)
            elif what == "remove":
                names = {f"{name}.obj" for name in with_[0]}  # type: ignore[attr-defined]
                db.remove([mesh.name for mesh in db.meshes() if mesh.name in names])
            elif what == "merge":
                with Database(others[int(with_[0])]) as other:  # type: ignore[call-overload]
                    db.merge(other)
            else:
                number = int(with_[0])  # type: ignore[call-overload]
                listed = list(fills(db, (3, 5, 4, 6), limit=number + 1))
                db.record_use(listed[number % len(listed)].pattern)
        check_counts(path)


def test_a_pattern_that_was_only_used_is_counted(full: Path) -> None:
    before = check_counts(full)
    with Database(full, "write") as db:
        held = set(db.pattern_class(4).ids.tolist())
        strange = next(
            fill.pattern
            for fill in fills(db, (3, 5, 4, 6), limit=None)
            if fill.pattern.id not in held and fill.pattern.n_sides == 4
        )
        db.record_use(strange)
    after = check_counts(full)
    assert after.patterns == before.patterns + 1
    assert after.patterns_met == before.patterns_met
    assert after.content_hash == before.content_hash


def test_counts_are_taken_back_with_a_change(full: Path) -> None:
    before = check_counts(full)
    with (
        Database(full, "write") as db,
        pytest.raises(RuntimeError, match="taken back"),
        db._change() as connection,
    ):
        remove_meshes(connection, [row[0] for row in connection.execute("SELECT id FROM mesh")])
        assert db.statistics().patterns == 0
        raise RuntimeError("all of it is taken back")
    assert check_counts(full) == before


@pytest.mark.parametrize("at_once", [1, 2, 7, 50_000])
def test_counts_anew_are_those_that_were_kept(
    full: Path, monkeypatch: pytest.MonkeyPatch, at_once: int
) -> None:
    monkeypatch.setattr(tallies, "COUNTED_AT_ONCE", at_once)
    with Database(full, "write") as db:
        db.remove(["star.obj"])
    before = check_counts(full)
    with Database(full, "write") as db, atomic(db._connection) as connection:
        tally_anew(connection)
    assert check_counts(full) == before


def test_an_empty_database_counts_nothing(tmp_path: Path) -> None:
    Database(tmp_path / "empty.db", "create").close()
    told = check_counts(tmp_path / "empty.db")
    assert (told.patterns, told.signatures, told.by_sides) == (0, 0, {})


CHANGED = {
    "count": ("UPDATE tally SET patterns = patterns + 1 WHERE chiral = 0", "tally of patterns"),
    "no count": ("DELETE FROM tally", "tally of patterns"),
    "signature": ("UPDATE signature SET hashes = zeroblob(length(hashes))", "the signatures"),
    "signatures gone": ("DELETE FROM signature WHERE n_sides = 4", "the signatures"),
    "signature of another class": ("UPDATE signature SET n_sides = 99", "the signatures"),
    "handednesses": ("UPDATE handedness SET met = met + 1", "handednesses that were met"),
    "no handednesses": ("DELETE FROM handedness", "tallies cannot be read to the end"),
}


@pytest.mark.parametrize("name", CHANGED)
def test_counts_that_are_not_of_the_rows_are_found(full: Path, name: str) -> None:
    statement, words = CHANGED[name]
    change(full, statement)
    with Database(full) as db:
        (finding,) = db.verify()
    assert words in finding


@pytest.mark.parametrize("hashes", ["x'00'", "zeroblob(9)", "x''"])
def test_signatures_that_are_none_are_told(full: Path, hashes: str) -> None:
    change(full, "PRAGMA ignore_check_constraints = ON", f"UPDATE signature SET hashes = {hashes}")
    with Database(full) as db:
        assert db.verify() != []
        with pytest.raises(DatabaseError, match="counts that it keeps"):
            db.statistics()


@pytest.mark.parametrize(
    "statement",
    ["DELETE FROM tally", "UPDATE signature SET hashes = zeroblob(8)", "DELETE FROM handedness"],
)
def test_a_change_that_the_counts_do_not_fit_is_refused(full: Path, statement: str) -> None:
    change(full, statement)
    before = full.read_bytes()
    with (
        Database(full, "write") as db,
        pytest.raises(DatabaseError, match="counts that it keeps of its patterns are not of these"),
    ):
        db.remove(["stars.obj"])
    assert full.read_bytes() == before


NUMBERS = arrays(np.uint64, st.integers(0, 30), elements=st.integers(0, 8))


@given(left=NUMBERS, gone=NUMBERS)
def test_numbers_are_taken_out_as_often_as_they_are_given(
    left: np.ndarray, gone: np.ndarray
) -> None:
    held = np.sort(np.concatenate([left, gone]))
    found = _take_out(held, np.sort(gone))
    np.testing.assert_array_equal(found, np.sort(left))


@given(held=NUMBERS, gone=NUMBERS)
def test_numbers_that_are_not_there_cannot_be_taken_out(held: np.ndarray, gone: np.ndarray) -> None:
    if Counter(gone.tolist()) <= Counter(held.tolist()):
        _take_out(np.sort(held), np.sort(gone))
    else:
        with pytest.raises(DatabaseError, match="counts"):
            _take_out(np.sort(held), np.sort(gone))


class DisorderedRows:
    """A connection to a table in which a search for later ids finds the same rows again."""

    def execute(self, *_: object) -> DisorderedRows:
        return self

    def fetchall(self) -> list[tuple[int, str]]:
        return [(5, "a"), (9, "b")]


def test_reading_in_parts_ends_at_ids_that_do_not_ascend() -> None:
    parts = read_in_parts(cast("sqlite3.Connection", DisorderedRows()), "SELECT id", 2)
    assert next(parts) == [(5, "a"), (9, "b")]
    with pytest.raises(DatabaseError, match=r"stands after 0*9"):
        next(parts)


PAGE = 4096


@pytest.mark.parametrize("seed", range(12))
def test_a_page_over_another_is_found(full: Path, seed: int) -> None:
    sound = full.read_bytes()
    other = full.with_name("other.db")
    chance = random.Random(seed)
    a, b = chance.sample(range(1, len(sound) // PAGE), 2)
    spoilt = bytearray(sound)
    spoilt[b * PAGE : (b + 1) * PAGE] = sound[a * PAGE : (a + 1) * PAGE]
    other.write_bytes(spoilt)
    try:
        with Database(other) as db:
            assert db.verify()
    except DatabaseError:
        pass
