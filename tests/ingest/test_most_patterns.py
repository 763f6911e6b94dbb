"""A limit of the patterns of a mesh: what is kept, and that it does not depend on the way there."""

from __future__ import annotations

import sqlite3
import threading
from pathlib import Path

import numpy as np
import pytest

from ingest import census, engines, ingest, learn, learning, read_mesh
from ingest.learning import keep_commonest
from patterndb.core.code import pattern_id
from patterndb.store import Database, Learned, LearningOptions, compact
from patterndb.store.recovery import recover_database
from tests.support.meshes import DOUBLET, beside, examples, star, write_obj

ALL = LearningOptions(4, 9, 14)
FEW = LearningOptions(4, 9, 14, most_patterns=12)


def counts_of(learned: Learned) -> dict[int, int]:
    """Patches by id of pattern."""
    ids = [pattern_id(c, n) for c, n in zip(learned.codes, learned.sides.tolist(), strict=True)]
    return dict(zip(ids, learned.patches.sum(axis=1).tolist(), strict=True))


@pytest.mark.parametrize("most", [1, 2, 7, 12, 40])
def test_the_commonest_patterns_are_kept(most: int) -> None:
    quads = read_mesh(examples()[0]).quads()[0]
    whole, cut = (learn(quads, LearningOptions(4, 9, 14, most_patterns=n)) for n in (0, most))
    everything, kept = counts_of(whole), counts_of(cut)
    assert len(kept) == most < len(everything)
    assert kept.items() <= everything.items()
    assert min(kept.values()) >= max(n for i, n in everything.items() if i not in kept)
    assert cut.left_out == len(everything) - most
    assert (cut.distinct, cut.basic, cut.side) == (whole.distinct, whole.basic, whole.side)
    # What is said of a pattern goes with it.
    rows = {row[0]: row[1:] for row in zip(whole.codes, whole.sides, whole.examples, strict=True)}
    for code, *said in zip(cut.codes, cut.sides, cut.examples, strict=True):
        assert rows[code] == tuple(said)


def test_nothing_is_left_out_of_fewer_patterns() -> None:
    whole = learn(np.array(star(3, 2), np.int32), ALL)
    assert keep_commonest(whole, len(whole.codes)) is whole
    assert keep_commonest(whole, 0) is whole


@pytest.mark.parametrize("jobs", [1, 2, 8])
@pytest.mark.parametrize("shard_quads", [40, 1 << 20])
def test_threads_shards_and_order_do_not_matter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: int, shard_quads: int
) -> None:
    with Database(tmp_path / "plain.db", "create") as plain:
        for path in examples():
            ingest(plain, [path], FEW, jobs=1)
        expected = plain.content_hash()
    monkeypatch.setattr(engines, "SMALLEST_SHARD", shard_quads)
    monkeypatch.setattr(engines, "SHARD_QUADS", shard_quads)
    monkeypatch.setattr(learning, "BASIC_RANGE", shard_quads)
    # No census is kept for the next task.
    monkeypatch.setattr(learning, "LARGEST_CENSUS", 0)
    with Database(tmp_path / "cut.db", "create") as cut:
        ingest(cut, examples()[::-1], FEW, jobs=jobs)
        assert cut.content_hash() == expected
        assert cut.verify() == []
        assert max(mesh.patterns for mesh in cut.meshes()) == FEW.most_patterns


@pytest.mark.parametrize("most", [2, 16, 256])
def test_maps_that_only_save_work_may_forget(monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    """Readings and ways to build a patch that had to go are worked out again: the same is learned,
    also by the next mesh with what is left of the census."""
    meshes = [read_mesh(path).quads()[0] for path in examples()]

    def learn_all() -> list[Learned]:
        monkeypatch.setattr(learning, "_local", threading.local())
        return [learn(quads, ALL, shard_quads=200) for quads in meshes]

    expected = learn_all()
    monkeypatch.setattr(learning, "new_census", lambda: census.new_census(1, most))
    for mine, theirs in zip(learn_all(), expected, strict=True):
        assert counts_of(mine) == counts_of(theirs)
        assert (mine.basic, mine.side, mine.convex) == (theirs.basic, theirs.side, theirs.convex)
        assert dict(zip(mine.codes, mine.examples, strict=True)) == dict(
            zip(theirs.codes, theirs.examples, strict=True)
        )
    (kept,) = vars(learning._local).values()
    assert len(kept.reading_keys) == most < kept.used[0]


def test_the_limit_belongs_to_what_was_learned(tmp_path: Path) -> None:
    """The same command changes nothing; another limit replaces."""
    files = [
        write_obj(tmp_path / "stars.obj", beside(star(5, 2), star(3, 3))),
        write_obj(tmp_path / "pair.obj", DOUBLET),
    ]
    with Database(tmp_path / "a.db", "create") as db:
        first = ingest(db, files, FEW).meshes
        assert [mesh.left_out > 0 for mesh in first] == [True, False]
        few = db.content_hash()
        again = ingest(db, files, FEW).meshes
        assert [mesh.outcome for mesh in again] == ["unchanged", "unchanged"]
        assert [mesh.left_out for mesh in again] == [mesh.left_out for mesh in first]
        assert [m.options for m in db.meshes()] == [FEW, FEW]
        assert {m.outcome for m in ingest(db, files, ALL).meshes} == {"replaced"}
        assert db.verify() == []
        with Database(tmp_path / "b.db", "create") as plain:
            ingest(plain, files, ALL)
            assert db.content_hash() == plain.content_hash()
        ingest(db, files, FEW)
        assert db.content_hash() == few != plain_hash(tmp_path / "b.db")


def plain_hash(path: Path) -> str:
    with Database(path) as db:
        return db.content_hash()


@pytest.fixture
def cut(tmp_path: Path) -> Path:
    with Database(tmp_path / "cut.db", "create") as db:
        ingest(db, examples()[:2], FEW)
    return tmp_path / "cut.db"


def test_a_limit_goes_where_the_mesh_goes(tmp_path: Path, cut: Path) -> None:
    with Database(cut) as db, Database(tmp_path / "merged.db", "create") as merged:
        expected, meshes = db.content_hash(), db.meshes()
        assert merged.merge(db) == (2, 0, 0)
        assert merged.merge(db) == (0, 0, 2)
        assert merged.content_hash() == expected
        compact.load(db.compact(), tmp_path / "loaded.db")
    assert recover_database(cut, tmp_path / "saved.db").is_whole
    for name in ("merged", "loaded", "saved"):
        with Database(tmp_path / f"{name}.db") as db:
            assert db.verify() == []
            assert db.content_hash() == expected
            assert db.meshes() == meshes


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("UPDATE mesh SET patterns_left_out = 0 WHERE id = 1", "patches in its patterns"),
        ("UPDATE mesh SET patterns_left_out = distinct_patches WHERE id = 1", "patches in its"),
        ("UPDATE mesh SET pattern_limit = 0 WHERE id = 1", "had no limit"),
        ("UPDATE mesh SET pattern_limit = 11 WHERE id = 1", "more than its limit"),
        ("UPDATE mesh SET pattern_limit = 1 << 50 WHERE id = 1", "cannot be read"),
    ],
)
def test_verify_knows_what_a_limit_means(cut: Path, statement: str, words: str) -> None:
    with sqlite3.connect(cut) as connection:
        connection.execute(statement)
    connection.close()
    with Database(cut) as db:
        assert any(words in finding for finding in db.verify()), db.verify()


@pytest.mark.parametrize("most", [-1, (1 << 40) + 1])
def test_a_limit_that_is_none_is_refused(most: int) -> None:
    with pytest.raises(ValueError, match="0 keeps all"):
        LearningOptions(most_patterns=most)
