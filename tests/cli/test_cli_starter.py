"""The starter database: what the verbs that ask use where no --db is given."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import pytest
from commandline import assert_refused, content_hash, program, run, without_privileges
from shared import CHECKOUT, SHARED

import patterndb
import patterndb.store.starter
from patterndb.store.migrations import SCHEMA_VERSION


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
    first = run("stats", "--json")
    assert first.document()["content_hash"] == content_hash(learned)
    assert first.err == f"unpacking the starter database into {cache} (once)\n"
    (unpacked,) = cache.iterdir()
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
    assert list(cache.iterdir()) == [unpacked]
    assert (unpacked.read_bytes(), unpacked.stat().st_mtime_ns) == before


@pytest.mark.parametrize("verb", [("ingest", "a.obj"), ("merge", "a.db"), ("remove", "a.obj")])
def test_never_written(cache: Path, verb: tuple[str, ...]) -> None:
    assert_refused(run(*verb), 2, "Missing option '--db'")
    assert_refused(run("verify", "--migrate"), 2, "--migrate needs --db")
    assert not cache.exists()


def test_cannot_be_changed_by_its_path_unless_named(cache: Path) -> None:
    assert run("stats").code == 0
    (unpacked,) = cache.iterdir()
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
    assert "damaged" in result.err
    assert list(cache.iterdir()) == []


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
    name = f"starter-{hashlib.sha256(before).hexdigest()[:16]}-{SCHEMA_VERSION}.db"
    environment = {"HOME": None, "PATTERNDB_CACHE": str(cache)}
    asked = ("query", "--sides=3,5,4,6", "--limit", 50, "--json")
    talk = (
        "" if (cache / name).exists() else f"unpacking the starter database into {cache} (once)\n"
    )
    first = program(*asked, environment=environment)
    assert (first.code, first.err) == (0, talk)
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
    checked = subprocess.run(
        [sys.executable, SHARED / "oracle" / "check_fill.py"],
        input=first.out,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(checked.stdout)["strict"] == len(answers[0]["fills"]) == 50
    meshes = program("meshes", "--json", environment=environment).document()["meshes"]
    assert meshes and all(mesh["provenance"]["licence"] for mesh in meshes)
    assert unpacked.stat().st_mtime_ns == stamp
    assert packed.read_bytes() == before
