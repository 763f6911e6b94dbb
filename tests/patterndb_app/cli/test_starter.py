"""The starter database: what the verbs that ask use where no --db is given."""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path

import numpy as np
import pytest

import patterndb
import patterndb.store.starter
from patterndb.core.code import format_id
from patterndb.core.patternclass import PatternClass
from patterndb.errors import NotFoundError
from tests.support.cli.commandline import (
    assert_refused,
    content_hash,
    program,
    run,
    without_privileges,
)
from tests.support.fillchecks import check_fill
from tests.support.shared import CHECKOUT


@pytest.fixture
def cache(learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An installation whose starter is the learned database; the folder it is unpacked into."""
    package = tmp_path / "package"
    (package / "data").mkdir(parents=True)
    with patterndb.open(learned) as database:
        (package / "data" / patterndb.store.starter.PACKED_NAME).write_bytes(database.compact())
    monkeypatch.setattr(patterndb.store.starter, "files", lambda _: package)
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_merged_from_the_command_line(cache: Path, learned: Path, tmp_path: Path) -> None:
    db = tmp_path / "mine.db"
    assert_refused(run("merge", "--db", db), 2, "--starter")
    assert not db.exists()
    merged = run("merge", "--starter", "--db", db)
    assert merged.code == 0 and "5 meshes added" in merged.out
    assert content_hash(db) == content_hash(learned)
    assert run("diff", db, "--json").document()["alike"] is True


def test_asked_where_no_database_is_named(cache: Path, learned: Path, tmp_path: Path) -> None:
    asked = (
        ("meshes", "--json"),
        (
            "query",
            "--sides=3,5,4,6",
            "--limit=40",
            "--from-mesh=jug.obj",
            "--image",
            tmp_path / "q.svg",
        ),
        ("show", "--sides=3,5,4,6", "-o", tmp_path / "a.svg"),
        ("gallery", "--class=3", "-o", tmp_path / "b.svg"),
    )
    for verb in asked:
        result = run(*verb)
        assert (result.code, result.out) == (0, run(*verb, "--db", learned).out)
        assert "unpacking" not in result.err
    # They have kept what queries keep, but made no database.
    assert not list(cache.glob("*.db"))
    first = run("stats", "--json")
    assert first.document()["content_hash"] == content_hash(learned)
    assert first.err.startswith(f"unpacking the starter database into {cache} (once)\n")
    (unpacked,) = cache.glob("*.db")
    before = unpacked.read_bytes(), unpacked.stat().st_mtime_ns
    for verb in (
        ("stats",),
        ("meshes",),
        ("verify",),
        ("query", "--sides=3,5,4,6", "--obj", tmp_path / "fills"),
        ("show", "--sides=3,5,4,6", "-o", tmp_path / "a.svg"),
        ("gallery", "--class=3", "-o", tmp_path / "b.svg"),
    ):
        result = run(*verb)
        assert result.code == 0
        assert "unpacking" not in result.err
    # Not a byte of it has changed, and nothing lies beside it.
    assert list(cache.glob("*.db")) == [unpacked]
    assert (unpacked.read_bytes(), unpacked.stat().st_mtime_ns) == before
    # One that is not what was made is made again.
    data = bytearray(before[0])
    data[len(data) // 2] ^= 1
    for spoil in (
        lambda: unpacked.write_bytes(data),
        lambda: unpacked.with_suffix(".sha256").unlink(),
        lambda: unpacked.write_bytes(b""),
    ):
        spoil()
        result = run("stats", "--json")
        assert result.err.startswith("unpacking the starter database")
        assert result.out == first.out and unpacked.read_bytes() == before[0]


@pytest.mark.parametrize("verb", [("ingest", "a.obj"), ("merge", "a.db"), ("remove", "a.obj")])
def test_never_written(cache: Path, verb: tuple[str, ...]) -> None:
    assert_refused(run(*verb), 2, "Missing option '--db'")
    assert_refused(run("verify", "--repair", "a.db"), 2, "--repair needs --db")
    assert not cache.exists()


def test_cannot_be_changed_by_its_path_unless_named(cache: Path) -> None:
    assert run("stats").code == 0
    (unpacked,) = cache.glob("*.db")
    with patterndb.open() as database, pytest.raises(patterndb.PatternDBError):
        database.remove(["jug.obj"])
    assert len(run("meshes", "--db", unpacked, "--json").document()["meshes"]) == 5


def test_a_package_without_one(cache: Path, tmp_path: Path) -> None:
    (tmp_path / "package" / "data" / patterndb.store.starter.PACKED_NAME).unlink()
    assert_refused(run("stats"), 3, "no starter database", "--db")


def test_a_damaged_package(cache: Path, tmp_path: Path) -> None:
    packed = tmp_path / "package" / "data" / patterndb.store.starter.PACKED_NAME
    packed.write_bytes(packed.read_bytes()[:-100])
    result = run("stats")
    assert (result.code, result.out) == (3, "")
    assert "damaged" in result.err or "cut short" in result.err
    assert not list(cache.glob("*"))


def test_a_damaged_class(cache: Path, tmp_path: Path) -> None:
    packed = tmp_path / "package" / "data" / patterndb.store.starter.PACKED_NAME
    data = bytearray(packed.read_bytes())
    with patterndb.open() as database:
        _, begin, end = database._head.classes[4]  # type: ignore[attr-defined]
    data[(begin + end) // 2] ^= 255
    packed.write_bytes(data)
    assert_refused(run("query", "--sides=3,5,4,6"), 3, "damaged")


def test_answers_are_those_of_the_database_that_is_made_of_it(cache: Path, learned: Path) -> None:
    with patterndb.open() as packed, patterndb.open(learned) as database:
        assert packed.sides_histogram() == database.sides_histogram()
        assert packed.meshes() == database.meshes()
        assert packed.uses() == database.uses()
        for n_sides in (*database.sides_histogram(), 99):
            one, other = packed.pattern_class(n_sides), database.pattern_class(n_sides)
            for field in dataclasses.fields(PatternClass):
                a, b = getattr(one, field.name), getattr(other, field.name)
                if field.name == "codes":
                    a, b = list(a), list(b)
                elif field.name in {"cache", "tables"}:
                    # Only a database that can change keeps its arrays; tables come of queries.
                    continue
                assert type(a) is type(b) and np.array_equal(a, b), field.name
                assert not isinstance(a, np.ndarray) or a.dtype == b.dtype, field.name
            ids = np.r_[other.ids[::3], other.ids[:5] + 1]
            assert (packed.frequencies(ids) == database.frequencies(ids)).all()
            for meshes, licences in (
                (None, None),
                (["jug.obj", "dog.obj"], None),
                (["hand.obj"], None),
            ):
                found = packed.pattern_ids(n_sides, meshes, licences)
                assert (found == database.pattern_ids(n_sides, meshes, licences)).all()
            for number in other.ids[:3].tolist():
                name = format_id(number)
                assert packed.pattern(name).code.tolist() == database.pattern(name).code.tolist()
        assert (packed.pattern_ids(None) == database.pattern_ids(None)).all()
        some = ["hand.obj"]
        assert (packed.pattern_ids(None, some) == database.pattern_ids(None, some)).all()
        for name in ("03", "zz", "", "1234567890123456"):
            errors = []
            for source in (packed, database):
                with pytest.raises(NotFoundError) as caught:
                    source.pattern(name)
                errors.append(str(caught.value))
            assert errors[0] == errors[1]
    assert not list(cache.glob("*.db"))


def test_the_cache_is_below_a_file(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "file" / "cache"))
    assert_refused(run("stats"), 3, "no folder to unpack", "PATTERNDB_CACHE")


def test_the_real_one(pytestconfig: pytest.Config) -> None:
    packed = CHECKOUT / "patterndb" / "data" / patterndb.store.starter.PACKED_NAME
    before = packed.read_bytes()
    # Kept between test runs, as a user's cache is, for unpacking takes its time.
    assert pytestconfig.cache is not None
    cache = pytestconfig.cache.mkdir("starter")
    made_of = (CHECKOUT / "schema.sql").read_bytes() + before
    name = f"starter-{hashlib.sha256(made_of).hexdigest()[:16]}.db"
    environment = {"HOME": None, "PATTERNDB_CACHE": str(cache)}
    asked = ("query", "--sides=3,5,4,6", "--limit", 50, "--flat", "--json")
    first = program(*asked, environment=environment)
    assert (first.code, first.err) == (0, "")
    assert program("stats", environment=environment).code == 0
    # Once unpacked, it is read from a folder that no one may write.
    unpacked = cache / name
    stamp = unpacked.stat().st_mtime_ns
    unpacked.chmod(0o444)
    cache.chmod(0o555)
    try:
        again = program(*asked, environment=environment, before=without_privileges)
    finally:
        cache.chmod(0o755)
    assert (again.code, again.err) == (0, "")
    answers = [first.document(), again.document()]
    for answer in answers:
        del answer["seconds"]
    assert answers[0] == answers[1]
    listed = answers[0]["fills"]
    assert len(listed) == 50
    assert all(check_fill(answers[0]["sides"], fill)[1] == 0 for fill in listed)
    meshes = program("meshes", "--json", environment=environment).document()["meshes"]
    assert meshes and all(mesh["provenance"]["licence"] for mesh in meshes)
    assert unpacked.stat().st_mtime_ns == stamp
    assert packed.read_bytes() == before
