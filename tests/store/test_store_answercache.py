"""Answers over all rows are kept while the content is the same, and no longer."""

from __future__ import annotations

from pathlib import Path

import pytest
from learnt import OTHER, learned

from patterndb.store import Database, answercache
from patterndb.store.connection import connect
from patterndb.store.contents import hash_content
from patterndb.store.records import Statistics
from patterndb.store.statistics import count_by_sides, read_statistics
from query import fills


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder in which all answers are kept, however fast they were had."""
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(answercache, "LEAST_SECONDS", 0.0)
    return tmp_path / "cache"


def ask_anew(path: Path) -> tuple[Statistics, dict[int, int]]:
    """What the rows say now."""
    connection = connect(path)
    try:
        told = read_statistics(connection, hash_content(connection))
        return told, count_by_sides(connection)
    finally:
        connection.close()


def ask(path: Path) -> tuple[Statistics, dict[int, int]]:
    with Database(path) as database:
        assert database.content_hash() == database.statistics().content_hash
        return database.statistics(), database.sides_histogram()


def test_answers_are_those_of_the_rows_after_every_change(
    full: Path, files: dict[str, Path]
) -> None:
    seen = [ask_anew(full)]
    assert ask(full) == ask(full) == seen[-1]
    with Database(full, "write") as database:
        database.remove(["stars.obj"])
    assert ask(full) == ask(full) == ask_anew(full)
    seen.append(ask_anew(full))
    learned(full, [files["stars"]], OTHER, "write")
    assert ask(full) == ask_anew(full)
    seen.append(ask_anew(full))
    with Database(full, "write") as database:
        held = set(database.pattern_class(4).ids.tolist())
        strange = next(
            fill.pattern
            for fill in fills(database, (3, 5, 4, 6), limit=None)
            if fill.pattern.id not in held and fill.pattern.n_sides == 4
        )
        database.record_use(strange)
    # A pattern that is there for its use alone is counted, and no part of the hash.
    assert ask(full) == ask_anew(full)
    assert ask(full)[0].patterns == seen[-1][0].patterns + 1
    assert ask(full)[0].content_hash == seen[-1][0].content_hash
    assert len({one.content_hash for one, _ in seen}) == 3


def test_kept_answers_are_had_without_a_look_at_the_rows(
    full: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = ask(full)

    def refuse(*_: object) -> None:
        raise AssertionError("the rows are read a second time")

    for name in ("hash_content", "read_statistics", "count_by_sides"):
        monkeypatch.setattr(answercache, name, refuse)
    assert ask(full) == expected


def test_what_is_answered_within_a_change_is_not_kept(full: Path, cache: Path) -> None:
    before = ask_anew(full)
    with (
        Database(full, "write") as database,
        pytest.raises(RuntimeError, match="taken back"),
        database._change() as connection,
    ):
        connection.execute("DELETE FROM occurrence")
        assert database.statistics().patterns_met == 0
        raise RuntimeError("all of it is taken back")
    assert not cache.exists()
    assert ask(full) == before


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "another"])
def test_a_damaged_answer_is_asked_anew(full: Path, cache: Path, damage: str) -> None:
    expected = ask(full)
    paths = sorted(cache.glob("*.json"))
    assert len(paths) == 2
    for path, other in zip(paths, paths[1:] + paths[:1], strict=True):
        whole = path.read_bytes()
        path.write_bytes(
            {
                "cut": whole[:-1],
                "flip": whole[:-3] + bytes([whole[-3] ^ 1]) + whole[-2:],
                "empty": b"",
                "another": other.read_bytes(),
            }[damage]
        )
    assert ask(full) == expected


def test_quick_answers_are_not_kept(
    full: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(answercache, "LEAST_SECONDS", 3600.0)
    ask(full)
    assert not cache.exists()
