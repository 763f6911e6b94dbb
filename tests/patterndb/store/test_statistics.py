"""Statistics are the counts of the rows, whatever was written in any order."""

from __future__ import annotations

import random
import sqlite3
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ingest import ingest
from patterndb.errors import DatabaseError
from patterndb.store import Database, reading
from patterndb.store.records import Statistics
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
        assert db.sides() == list(told.by_sides)
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


def test_what_an_index_counts_is_the_same_without_the_rest(full: Path) -> None:
    with Database(full) as db:
        whole, told = db.statistics(), db.statistics(signatures=False)
    assert told == replace(whole, signatures=None, patterns_met=None)


def test_an_empty_database_counts_nothing(tmp_path: Path) -> None:
    Database(tmp_path / "empty.db", "create").close()
    told = check_counts(tmp_path / "empty.db")
    assert (told.patterns, told.signatures, told.by_sides) == (0, 0, {})


@pytest.mark.parametrize("at_once", [1, 7])
def test_signatures_are_counted_however_they_are_read(
    full: Path, monkeypatch: pytest.MonkeyPatch, at_once: int
) -> None:
    monkeypatch.setattr(reading, "SIGNATURES_AT_ONCE", at_once)
    check_counts(full)


def test_signatures_of_another_size_are_reported(full: Path) -> None:
    change(full, "UPDATE pattern SET signature = x'00' WHERE n_sides = 4")
    with Database(full) as db, pytest.raises(DatabaseError, match="verify"):
        db.statistics()


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
