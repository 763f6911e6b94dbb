"""Large classes are kept as mapped arrays, and what is mapped equals what would be loaded."""

from __future__ import annotations

import gc
import sqlite3
import subprocess
import sys
import weakref
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from patterndb.core.code import format_id
from patterndb.core.packing import PackedRows
from patterndb.core.patternclass import ClassPart, PatternClass
from patterndb.errors import DatabaseError
from patterndb.store import Database, classes
from patterndb.store.classes import load_class
from patterndb.store.connection import connect
from patterndb.system.mappedarrays import FOLDER, MAGIC, ArrayCache
from patterndb.system.progress import describe_progress
from query import fills
from query.listing.table import get_strict_table
from tests.support.store.learnt import OTHER, learned

SIDES = (3, 4, 5, 6, 8)


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder in which all classes are kept, however small: the folder of their files."""
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(classes, "LEAST_KEPT", 1)
    return tmp_path / "cache" / FOLDER


def load(path: Path, n_sides: int) -> PatternClass:
    connection = connect(path)
    try:
        return load_class(connection, n_sides)
    finally:
        connection.close()


def list_differences(one: PatternClass, other: PatternClass) -> Iterator[str]:
    """The fields in which two classes differ; types of arrays count."""
    assert list(one.codes) == list(other.codes)
    for name in PatternClass.__dataclass_fields__:
        mine, theirs = getattr(one, name), getattr(other, name)
        if isinstance(mine, np.ndarray) and not (
            mine.dtype == theirs.dtype
            and mine.shape == theirs.shape
            and np.array_equal(mine, theirs)
            # Kernels are compiled for such.
            and theirs.flags.writeable
            and theirs.flags.aligned
        ):
            yield name


def test_what_is_mapped_equals_what_is_loaded(full: Path, kept: Path) -> None:
    for _ in range(2):
        with Database(full) as database:
            for n in SIDES:
                mapped = database.pattern_class(n)
                assert isinstance(mapped.codes, PackedRows)
                assert list(list_differences(load(full, n), mapped)) == []
    assert len(list(kept.glob("*class*"))) == len(SIDES)


@pytest.mark.parametrize("at_once", [1, 7, 50])
def test_parts_make_the_class_that_one_makes(
    full: Path, at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = {n: load(full, n) for n in SIDES}
    shares: list[str | None] = []

    def describe(*args: object) -> ClassPart:
        shares.append(describe_progress())
        return make_part(*args)  # pyright: ignore[reportArgumentType]

    make_part = classes._make_part  # pyright: ignore[reportPrivateUsage]
    monkeypatch.setattr(classes, "_make_part", describe)
    monkeypatch.setattr(classes, "READ_AT_ONCE", at_once)
    for n, one in whole.items():
        shares.clear()
        assert list(list_differences(one, load(full, n))) == []
        assert len(shares) == -(-len(one) // at_once)
        assert all(share and f"of {n} sides" in share for share in shares)
        assert describe_progress() is None


def test_a_damaged_row_of_a_later_part_is_told(
    full: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(classes, "READ_AT_ONCE", 1)
    path = tmp_path / "damaged.db"
    path.write_bytes(full.read_bytes())
    with sqlite3.connect(path) as connection:
        (number,) = connection.execute(
            "SELECT id FROM pattern WHERE n_sides = 5 ORDER BY id DESC LIMIT 1"
        ).fetchone()
        connection.execute("UPDATE pattern SET n_quads = n_quads + 1 WHERE id = ?", (number,))
    connection.close()
    with pytest.raises(DatabaseError, match=f"{format_id(number)} is damaged: n_quads"):
        load(path, 5)
    assert describe_progress() is None


def test_a_second_handle_reads_no_rows(
    full: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Database(full) as database:
        first = database.pattern_class(4)

    def refuse(*_: object) -> PatternClass:
        raise AssertionError("the class is loaded a second time")

    monkeypatch.setattr(classes, "load_class", refuse)
    with Database(full) as database:
        assert database.pattern_class(4).ids.tolist() == first.ids.tolist()


def test_handles_of_one_process_have_one_class_and_its_tables(full: Path, kept: Path) -> None:
    with Database(full) as one, Database(full) as other:
        for n_sides in SIDES:
            assert one.pattern_class(n_sides) is other.pattern_class(n_sides)
        five = one.pattern_class(5)
        assert get_strict_table(five) is get_strict_table(other.pattern_class(5))
        pattern = five.pattern(0)
        with Database(full, "write") as writer:
            mine = writer.pattern_class(5)
            assert mine is five
            writer.record_use(pattern)
            used = writer.pattern_class(5)
            # Uses are no part of the key: only who has seen the same ones shares the class.
            assert used is not five
            assert used.uses[0] == five.uses[0] + 1
            assert other.pattern_class(5) is used
        with Database(full, "write") as writer:
            writer.remove([writer.meshes()[0].name])
            left = writer.pattern_class(5)
        assert left is not used
        assert other.pattern_class(5) is left
        assert not list(list_differences(load(full, 5), left))


@pytest.mark.parametrize("least", [1, 1 << 20], ids=["mapped", "loaded"])
def test_a_class_is_forgotten_with_the_last_handle(
    full: Path, kept: Path, monkeypatch: pytest.MonkeyPatch, least: int
) -> None:
    monkeypatch.setattr(classes, "LEAST_KEPT", least)
    with Database(full) as database:
        held = weakref.ref(database.pattern_class(5))
        assert list(fills(database, (4, 4, 4, 4, 4), limit=3))
        assert fills(database, (4, 4, 4, 4, 4)).feasible_patterns
        assert held() is not None
    del database
    gc.collect()
    assert held() is None


def test_the_same_fills_come_of_mapped_classes_in_another_process(full: Path, kept: Path) -> None:
    ask = (
        "import sys; from patterndb.store import Database, classes; from query import fills\n"
        "classes.LEAST_KEPT = 1\n"
        "with Database(sys.argv[1]) as db:\n"
        "    print([f.key for s in ((3, 4, 5), (4, 4, 4, 4), (3, 3, 2, 2, 4)) "
        "for f in fills(db, s, limit=40)])"
    ).replace("f.key", "(f.pattern.id, f.quads.tolist())")
    answers = [
        subprocess.run(
            [sys.executable, "-c", ask, str(full)], check=True, capture_output=True, text=True
        ).stdout
        for _ in range(2)
    ]
    assert answers[0] == answers[1] != ""
    assert list(kept.glob("*-systems-*"))
    loaded = [
        (fill.pattern.id, fill.quads.tolist())
        for sides in ((3, 4, 5), (4, 4, 4, 4), (3, 3, 2, 2, 4))
        for fill in fills(load(full, len(sides)), sides, limit=40)
    ]
    assert loaded
    with Database(full) as database:
        assert (
            str(
                [
                    (fill.pattern.id, fill.quads.tolist())
                    for sides in ((3, 4, 5), (4, 4, 4, 4), (3, 3, 2, 2, 4))
                    for fill in fills(database, sides, limit=40)
                ]
            )
            == answers[0].strip()
        )


def test_what_a_database_learns_or_loses_makes_its_arrays_stale(
    full: Path, kept: Path, files: dict[str, Path]
) -> None:
    with Database(full) as database:
        before = database.pattern_class(4)
    with Database(full, "write") as database:
        database.remove(["stars.obj"])
    with Database(full) as database:
        after = database.pattern_class(4)
        assert after.frequency.sum() < before.frequency.sum()
    assert list(list_differences(load(full, 4), after)) == []
    learned(full, [files["stars"]], OTHER, "write")
    with Database(full) as database:
        again = database.pattern_class(4)
    assert list(list_differences(load(full, 4), again)) == []
    # Of one database and class the last state is kept, and no other.
    assert len(list(kept.glob("*-4-class-*"))) == 1


def test_uses_are_read_and_not_kept(full: Path, kept: Path) -> None:
    with Database(full, "write") as database:
        pattern = database.pattern_class(4).pattern(1)
        made = {path.name: path.stat().st_ino for path in kept.glob("*class*")}
        database.record_use(pattern, 3)
        used = database.pattern_class(4)
    assert used.uses.tolist() == load(full, 4).uses.tolist()
    assert used.uses[1] == 3
    assert {path.name: path.stat().st_ino for path in kept.glob("*class*")} == made


def test_a_pattern_that_is_there_for_its_uses_is_in_the_arrays(full: Path, kept: Path) -> None:
    with Database(full, "write") as database:
        held = set(database.pattern_class(4).ids.tolist())
        strange = next(
            fill.pattern
            for fill in fills(database, (3, 5, 4, 6), limit=None)
            if fill.pattern.id not in held and fill.pattern.n_sides == 4
        )
        database.record_use(strange)
    with Database(full) as database:
        after = database.pattern_class(4)
    assert set(after.ids.tolist()) == held | {strange.id}
    assert list(list_differences(load(full, 4), after)) == []


@pytest.mark.parametrize("damage", ["cut", "head", "body", "empty", "foreign", "key", "longer"])
def test_a_damaged_or_foreign_file_is_made_anew(full: Path, kept: Path, damage: str) -> None:
    with Database(full) as database:
        database.pattern_class(5)
        database.pattern_class(6)
    (path,) = kept.glob("*-5-class-*")
    whole = path.read_bytes()
    (other,) = kept.glob("*-6-class-*")
    changed = {
        "cut": whole[: len(whole) // 2],
        "head": whole.replace(b'"ids"', b'"idz"', 1),
        "body": whole[:-200] + bytes([whole[-200] ^ 1]) + whole[-199:],
        "empty": b"",
        "foreign": MAGIC + b"{}\n" + whole,
        "key": other.read_bytes(),
        "longer": whole + bytes(64),
    }[damage]
    path.unlink()
    path.write_bytes(changed)
    with Database(full) as database:
        assert list(list_differences(load(full, 5), database.pattern_class(5))) == []
    assert path.read_bytes() == whole


def test_another_database_of_the_same_content_has_its_own_arrays(
    full: Path, kept: Path, tmp_path: Path
) -> None:
    # Whoever gives a file away could have put any sums into it.
    copy = tmp_path / "copy.db"
    copy.write_bytes(full.read_bytes())
    for path in (full, copy):
        with Database(path) as database:
            database.pattern_class(4)
    assert len(list(kept.glob("*-4-class-*"))) == 2


def test_a_cache_folder_that_cannot_be_written_does_no_harm(
    full: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "no folder"
    file.write_text("")
    monkeypatch.setenv("PATTERNDB_CACHE", str(file))
    monkeypatch.setattr(classes, "LEAST_KEPT", 1)
    with Database(full) as database:
        assert list(list_differences(load(full, 4), database.pattern_class(4))) == []


def test_writing_to_mapped_arrays_changes_neither_file_nor_other_processes(
    full: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forget() -> None:
        """Know as little of this process's classes as another process does."""
        monkeypatch.setattr(classes, "_MAPPED", weakref.WeakValueDictionary())

    with Database(full) as one, Database(full) as other:
        one.pattern_class(4)
        mine = one.pattern_class(4)
        forget()
        theirs = other.pattern_class(4)
        before = theirs.ids.copy()
        mine.ids[:] = 0
        assert theirs.ids.tolist() == before.tolist()
    forget()
    with Database(full) as database:
        assert database.pattern_class(4).ids.tolist() == before.tolist()


def test_a_cache_drops_what_was_not_used_for_longest(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("patterndb.system.mappedarrays.MOST_BYTES", 20_000)
    caches = [ArrayCache(f"source {k}", "key") for k in range(5)]
    for cache in caches:
        assert cache.keep("numbers", {"numbers": np.arange(1000)})
    found = [cache.find("numbers") is not None for cache in caches]
    assert found == [False, False, False, True, True]


def test_packed_rows_are_the_rows() -> None:
    rows = [b"one", b"", b"three", b"\x00\xff"]
    packed = PackedRows.of(rows)
    assert list(packed) == rows
    assert packed[-1] == rows[-1]
    assert packed[1:3] == rows[1:3]
    for wrong in (4, -5):
        with pytest.raises(IndexError, match="4 rows"):
            packed[wrong]
