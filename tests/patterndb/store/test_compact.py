"""The compact file: everything learned comes back, and nothing else is taken for one."""

from __future__ import annotations

import lzma
from pathlib import Path

import pytest

import patterndb
from ingest import ingest
from patterndb.errors import DatabaseError
from patterndb.store import LearningOptions, Provenance
from patterndb.store.compact import FORMAT, load
from tests.support.shared import CHECKOUT


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("compact") / "learned.db"
    with patterndb.open(path, "create") as database:
        for name, licence in (("jug.obj", None), ("hand.obj", "CC0-1.0")):
            ingest(
                database,
                [CHECKOUT / "examples" / name],
                LearningOptions(4, 6, 12),
                provenance=Provenance("Ötzi", None, licence),
            )
    return path


def test_comes_back_whole(learned: Path, tmp_path: Path) -> None:
    with patterndb.open(learned) as database:
        data = database.compact()
        statistics = database.statistics()
        meshes = database.meshes()
    load(data, tmp_path / "again.db")
    with patterndb.open(tmp_path / "again.db") as again:
        assert again.statistics() == statistics
        assert again.meshes() == meshes
        assert again.verify() == []
        assert again.compact() == data
    assert len(data) < learned.stat().st_size / 8


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda data: data[:-100], "cut short"),
        (lambda data: data + b"x", "cut short"),
        (lambda data: data[:-100] + bytes(100), "damaged"),
        (lambda data: b"SQLite format 3\0" + data, "not a compact database"),
        (lambda data: FORMAT, "cut short"),
        (lambda data: FORMAT + b"[\n", "cut short"),
        (lambda data: FORMAT + b'{"classes": [], "meshes": 0}\n', "damaged"),
        (lzma.compress, "not a compact database"),
    ],
)
def test_refuses_what_is_none(spoil, words: str, learned: Path, tmp_path: Path) -> None:
    with patterndb.open(learned) as database:
        data = database.compact()
    with pytest.raises(DatabaseError, match=words):
        load(spoil(data), tmp_path / "none.db")
    assert not (tmp_path / "none.db").exists()
