"""patterndb ingest: what it learns, what it leaves alone, what it refuses."""

from __future__ import annotations

import hashlib
import os
import shutil
from pathlib import Path

import pytest

from tests.support.cli.commandline import (
    SMALL,
    TINY,
    assert_refused,
    content_hash,
    mesh_names,
    program,
    run,
    write_obj,
)
from tests.support.shared import EXAMPLES

JUG = EXAMPLES / "jug.obj"
HAND = EXAMPLES / "hand.obj"

#: Keys of a mesh in the JSON document, and the types of their values.
ENTRY = {
    "name": str,
    "sha256": str,
    "outcome": str,
    "quads_read": int,
    "quads_used": int,
    "patches": dict,
    "patterns": int,
    "new_patterns": int,
    "left_out": int,
    "seconds": float,
}


def bad_file(path: Path) -> Path:
    path.write_text("v 0 0 zero\n")
    return path


def test_json_document(tmp_path: Path) -> None:
    document = run("ingest", JUG, "--db", tmp_path / "a.db", *TINY, "--json").document()
    assert {"meshes", "patterns", "seconds", "interrupted"} <= document.keys()
    assert document["interrupted"] is False
    (entry,) = document["meshes"]
    for key, kind in ENTRY.items():
        assert isinstance(entry[key], kind), key
    assert entry["name"] == "jug.obj"
    assert entry["sha256"] == hashlib.sha256(JUG.read_bytes()).hexdigest()
    assert entry["outcome"] == "learned"
    assert entry["quads_read"] == 432
    assert 0 < entry["quads_used"] <= entry["quads_read"]
    assert set(entry["patches"]) == {"basic", "side", "convex", "distinct"}
    assert entry["patches"]["basic"] == entry["patches"]["distinct"] > 0
    assert entry["patches"]["side"] == entry["patches"]["convex"] == 0
    assert entry["patterns"] == entry["new_patterns"] == document["patterns"] > 0


def test_text_says_what_was_learned(tmp_path: Path) -> None:
    db = tmp_path / "a.db"
    result = run("ingest", JUG, "--db", db, *TINY)
    assert result.code == 0
    assert result.out.startswith("1 of 1 mesh learned, ") and str(db) in result.out
    assert result.err.startswith("jug.obj: ") and result.err.endswith(" of them new\n")


def test_again_changes_nothing(tiny: Path) -> None:
    before, bytes_before = content_hash(tiny), tiny.read_bytes()
    document = run("ingest", HAND, JUG, "--db", tiny, *TINY, "--json").document()
    assert [m["outcome"] for m in document["meshes"]] == ["unchanged", "unchanged"]
    assert [m["new_patterns"] for m in document["meshes"]] == [0, 0]
    assert content_hash(tiny) == before
    assert tiny.read_bytes() == bytes_before


def test_order_and_jobs_do_not_matter(tiny: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.db"
    for mesh in (HAND, JUG):
        assert run("ingest", mesh, "--db", other, *TINY, "--jobs", 1).code == 0
    assert content_hash(other) == content_hash(tiny)


def test_a_limit_of_patterns_says_where_it_cut(tmp_path: Path) -> None:
    db = tmp_path / "a.db"
    limit = ("--db", db, *TINY, "--most-patterns", 2)
    first = run("ingest", JUG, *limit)
    assert first.code == 0
    assert ", 2 patterns, 2 of them new; " in first.err
    assert first.err.endswith(" rarer ones left out\n")
    assert "1 mesh has more than 2 patterns, " in first.out
    again = run("ingest", JUG, *limit)
    assert "jug.obj: unchanged; " in again.err and " had been left out" in again.err
    (entry,) = run("ingest", JUG, *limit, "--json").document()["meshes"]
    assert entry["patterns"] == 2
    assert f"{entry['left_out']:,} rarer ones left out" in first.err
    (row,) = run("meshes", "--db", db, "--json").document()["meshes"]
    assert row["options"]["most_patterns"] == 2
    assert row["left_out"] == entry["left_out"] > 0
    assert "2 of " in run("meshes", "--db", db).out


def test_other_options_replace(tiny: Path) -> None:
    before = content_hash(tiny)
    document = run("ingest", JUG, "--db", tiny, "--basic", 2, *TINY[2:], "--json").document()
    assert document["meshes"][0]["outcome"] == "replaced"
    assert content_hash(tiny) != before
    assert run("ingest", JUG, "--db", tiny, *TINY).code == 0
    assert content_hash(tiny) == before


def test_no_prepare_uses_all_quads(tmp_path: Path) -> None:
    document = run(
        "ingest", JUG, "--db", tmp_path / "a.db", *TINY, "--no-prepare", "--json"
    ).document()
    assert document["meshes"][0]["quads_used"] == document["meshes"][0]["quads_read"]


def test_provenance_is_kept_and_can_be_added(tiny: Path) -> None:
    said = ("--author", "Ada", "--licence", "CC0-1.0", "--source", "https://example.org/jug")
    document = run("ingest", JUG, "--db", tiny, *TINY, *said, "--json").document()
    assert document["meshes"][0]["outcome"] == "updated"
    rows = run("meshes", "--db", tiny, "--json").document()["meshes"]
    kept = {row["name"]: row["provenance"] for row in rows}
    assert kept["jug.obj"] == {
        "author": "Ada",
        "licence": "CC0-1.0",
        "source": "https://example.org/jug",
    }
    assert set(kept["hand.obj"].values()) == {None}
    assert "CC0-1.0, Ada, https://example.org/jug" in run("meshes", "--db", tiny).out
    # The other spelling, and nothing said leaves what is there.
    assert run("ingest", JUG, "--db", tiny, *TINY, "--license", "MIT").code == 0
    rows = run("meshes", "--db", tiny, "--json").document()["meshes"]
    assert rows[1]["provenance"]["licence"] == "MIT"
    assert rows[1]["provenance"]["author"] == "Ada"


class TestFolders:
    def test_takes_the_meshes_below(self, tmp_path: Path) -> None:
        folder = tmp_path / "meshes"
        for path in ("a.obj", "deep/er/b.OBJ", ".hidden.obj", ".git/c.obj", "readme.txt"):
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(HAND if path == "a.obj" else JUG, folder / path)
        result = run("ingest", folder, "--db", tmp_path / "a.db", *TINY)
        assert result.code == 0
        assert mesh_names(tmp_path / "a.db") == ["a.obj", "b.OBJ"]
        assert f"{folder}: 1 other file left out" in result.err

    @pytest.mark.parametrize("inside", [[], ["readme.txt"], [".hidden.obj"]])
    def test_without_a_mesh(self, tmp_path: Path, inside: list[str]) -> None:
        folder = tmp_path / "meshes"
        folder.mkdir()
        for name in inside:
            shutil.copy(JUG, folder / name)
        result = run("ingest", folder, "--db", tmp_path / "a.db")
        assert_refused(result, 3, str(folder), "no mesh in this folder", ".obj .ply")
        assert not (tmp_path / "a.db").exists()

    def test_a_name_that_is_no_text(self, tmp_path: Path) -> None:
        folder = tmp_path / "meshes"
        folder.mkdir()
        shutil.copy(JUG, os.fsencode(folder) + b"/\xff.obj")
        result = run("ingest", folder, "--db", tmp_path / "a.db", *TINY)
        assert_refused(result, 3, "not UTF-8", "rename")


@pytest.mark.parametrize(
    "name", ["with space.obj", "jüg ☃ 壺.obj", "-.obj", "a'b\"c;.obj", "%s?mode=ro#.obj", "x" * 250]
)
def test_strange_names(tmp_path: Path, name: str) -> None:
    if not name.endswith(".obj"):
        name += ".obj"
    mesh = Path(shutil.copy(JUG, tmp_path / name))
    db = tmp_path / f"{name[:200]}.db"
    assert run("ingest", mesh, "--db", db, *TINY).code == 0
    assert mesh_names(db) == [name]
    assert run("verify", "--db", db).code == 0
    assert run("remove", "--db", db, "--", name).code == 0


def test_control_characters_do_not_reach_the_terminal(tmp_path: Path) -> None:
    name = "two\nlines \x1b[31m.obj"
    mesh = Path(shutil.copy(JUG, tmp_path / name))
    db = tmp_path / "a.db"
    learned = run("ingest", mesh, "--db", db, *TINY)
    listed = run("meshes", "--db", db)
    assert "two\\nlines \\x1b[31m.obj" in learned.err
    assert "two\\nlines \\x1b[31m.obj" in listed.out
    assert "\x1b" not in learned.err + listed.out
    assert mesh_names(db) == [name]


def test_the_same_bytes_twice(tmp_path: Path) -> None:
    twin = Path(shutil.copy(JUG, tmp_path / "twin.obj"))
    db = tmp_path / "a.db"
    document = run("ingest", JUG, twin, JUG, "--db", db, *TINY, "--json").document()
    outcomes = [m["outcome"] for m in document["meshes"]]
    assert outcomes == ["learned", "unchanged", "unchanged"]
    assert mesh_names(db) == ["jug.obj"]


def test_a_mesh_without_quads(tmp_path: Path) -> None:
    mesh = write_obj(tmp_path / "triangle.obj", [[0, 1, 2]])
    db = tmp_path / "a.db"
    result = run("ingest", mesh, "--db", db, *TINY)
    assert_refused(result, 1, "holds no quads")
    assert not db.exists()
    # Beside others it is told, and leaves no row.
    result = run("ingest", mesh, JUG, "--db", db, *TINY)
    assert result.code == 0
    assert "triangle.obj: no quads" in result.err and "1 of 2 meshes learned" in result.out
    assert mesh_names(db) == ["jug.obj"]
    document = run("ingest", mesh, JUG, "--db", db, *TINY, "--json").document()
    assert [m["outcome"] for m in document["meshes"]] == ["no quads", "unchanged"]
    # A database that is there stays as it was.
    before = db.read_bytes()
    result = run("ingest", mesh, "--db", db, *TINY)
    assert result.code == 1 and "holds no quads" in result.err
    assert db.read_bytes() == before


def test_tables_without_rows_still_read(tmp_path: Path) -> None:
    db = tmp_path / "a.db"
    run("ingest", JUG, "--db", db, *TINY)
    run("remove", "jug.obj", "--db", db)
    assert run("stats", "--db", db).out.startswith("0 patterns, 0 with mirror images\n0 meshes, ")


def test_bad_files_are_left_out_where_that_is_asked(tmp_path: Path) -> None:
    folder, db = tmp_path / "meshes", tmp_path / "a.db"
    folder.mkdir()
    shutil.copy(JUG, folder)
    for name in ("cut.obj", "b.ply"):
        (folder / name).write_text("v 0 0 0\nf 1 2 3 4\n")
    result = run("ingest", folder, "--db", db, *TINY)
    assert_refused(result, 3, "cut.obj", "b.ply", "--skip-bad")
    assert not db.exists()
    result = run("ingest", folder, "--db", db, *TINY, "--skip-bad")
    assert result.code == 3
    assert "1 of 3 meshes learned" in result.out
    *_, said, one, other = result.err.splitlines()
    assert said.startswith("2 files left out") and "b.ply" in one and "cut.obj:2" in other
    assert mesh_names(db) == ["jug.obj"]
    skipped = run("ingest", folder, "--db", db, *TINY, "--skip-bad", "--json").document()["skipped"]
    assert [Path(entry["file"]).name for entry in skipped] == ["b.ply", "cut.obj"]


class TestRefusals:
    def test_no_mesh(self) -> None:
        assert_refused(run("ingest", "--db", "a.db"), 2, "Missing argument", "MESH")

    def test_no_database(self) -> None:
        assert_refused(run("ingest", JUG), 2, "Missing option", "--db")

    def test_missing_file(self, tmp_path: Path) -> None:
        result = run("ingest", tmp_path / "gone.obj", "--db", tmp_path / "a.db")
        assert_refused(result, 3, "gone.obj", "No such file")

    def test_stl_with_the_reason(self, tmp_path: Path) -> None:
        mesh = tmp_path / "a.stl"
        mesh.write_text("solid a\nendsolid a\n")
        result = run("ingest", mesh, "--db", tmp_path / "a.db")
        assert_refused(result, 3, "a.stl", "triangles only", "OBJ")

    def test_line_and_token(self, tmp_path: Path) -> None:
        result = run("ingest", bad_file(tmp_path / "bad.obj"), "--db", tmp_path / "a.db")
        assert_refused(result, 3, f"{tmp_path / 'bad.obj'}:1: ", "'zero'")

    def test_all_bad_files_at_once_and_nothing_learned(self, tiny: Path, tmp_path: Path) -> None:
        before = content_hash(tiny)
        bad = [bad_file(tmp_path / "one.obj"), tmp_path / "two.stl", EXAMPLES / "dog.obj"]
        bad[1].write_text("solid")
        result = run("ingest", *bad, "--db", tiny, *TINY)
        assert_refused(result, 3, "2 of 3 files", "nothing was ingested", "one.obj:1", "two.stl")
        assert content_hash(tiny) == before

    @pytest.mark.parametrize("json", [(), ("--json",)])
    def test_all_modes_off(self, tmp_path: Path, json: tuple[str, ...]) -> None:
        off = ("--basic", 0, "--side", 0, "--convex", 0)
        result = run("ingest", JUG, "--db", tmp_path / "a.db", *off, *json)
        assert_refused(result, 2, "all modes are switched off")
        assert not (tmp_path / "a.db").exists()

    @pytest.mark.parametrize("limit", ["--basic", "--side", "--convex"])
    def test_limit_out_of_range(self, tmp_path: Path, limit: str) -> None:
        for value in (-1, 4097, 10**30, "many", "2.5", "nan"):
            result = run("ingest", JUG, "--db", tmp_path / "a.db", limit, value)
            assert_refused(result, 2, limit[2:])
        assert not (tmp_path / "a.db").exists()

    def test_jobs_and_bytes_out_of_range(self, tmp_path: Path) -> None:
        for option, value in (("--jobs", 0), ("--jobs", 10**6), ("--max-bytes", 0)):
            assert_refused(run("ingest", JUG, "--db", tmp_path / "a.db", option, value), 2, option)

    def test_file_over_the_limit(self, tmp_path: Path) -> None:
        result = run("ingest", JUG, "--db", tmp_path / "a.db", "--max-bytes", 100)
        assert_refused(result, 3, "jug.obj", "over the limit of 100")

    def test_empty_names(self, tmp_path: Path) -> None:
        # As an unset shell variable leaves them: "" is not the present folder.
        assert_refused(run("ingest", "", "--db", tmp_path / "a.db"), 2, "the name is empty")
        assert_refused(run("ingest", JUG, "--db", ""), 2, "the name is empty")

    def test_database_is_a_folder_or_lies_in_none(self, tmp_path: Path) -> None:
        assert_refused(run("ingest", JUG, "--db", tmp_path, *TINY), 3, "is a directory")
        lost = tmp_path / "no" / "a.db"
        assert_refused(run("ingest", JUG, "--db", lost, *TINY), 3, "there is no folder")

    def test_database_is_another_file(self, tmp_path: Path) -> None:
        other = tmp_path / "letter.db"
        other.write_text("Dear Ada, " * 1000)
        result = run("ingest", JUG, "--db", other, *TINY)
        assert_refused(result, 3, "not an SQLite file")
        assert other.read_text() == "Dear Ada, " * 1000


def test_an_empty_file_becomes_a_database(tmp_path: Path) -> None:
    db = tmp_path / "a.db"
    db.touch()
    assert run("ingest", JUG, "--db", db, *TINY).code == 0
    assert run("verify", "--db", db).code == 0


def test_the_help_names_every_format_of_the_registry() -> None:
    from ingest.formats import list_format_names

    for verb in ("ingest", "features"):
        assert f"({list_format_names()})" in run(verb, "--help").out.replace("\n ", "")


class TestScheduler:
    def test_processes_learn_what_threads_learn(self, tmp_path: Path) -> None:
        documents: list[object] = []
        for name, more in (("threads", ()), ("processes", ("--scheduler", "local:1"))):
            db = tmp_path / f"{name}.db"
            done = program("ingest", JUG, "--db", db, *SMALL, "--json", *more)
            assert done.code == 0, done.err
            document = done.document()
            for entry in document["meshes"]:
                del entry["seconds"]
            documents.append({**document, "seconds": 0})
        assert documents[0] == documents[1]
        assert content_hash(tmp_path / "threads.db") == content_hash(tmp_path / "processes.db")

    @pytest.mark.parametrize("text", ["local", "local:0", "10.0.0.5:8786", "http://a"])
    def test_what_is_no_scheduler_is_refused_at_once(self, tmp_path: Path, text: str) -> None:
        db = tmp_path / "a.db"
        refused = run("ingest", JUG, "--db", db, "--scheduler", text)
        assert_refused(refused, 2, "is no scheduler", "local:4")
        assert not db.exists()

    def test_jobs_are_not_those_of_workers(self, tmp_path: Path) -> None:
        more = ("--scheduler", "local:1", "--jobs", 2)
        refused = run("ingest", JUG, "--db", tmp_path / "a.db", *more)
        assert_refused(refused, 2, "--jobs is about threads here")

    def test_a_cluster_that_is_not_there_leaves_the_database_as_it_was(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("ingest.cluster.PATIENCE", 0.5)
        db = tmp_path / "a.db"
        assert run("ingest", JUG, "--db", db, *TINY).code == 0
        before = content_hash(db)
        more = ("--scheduler", "tcp://127.0.0.1:9")
        refused = run("ingest", HAND, "--db", db, *TINY, *more)
        assert_refused(refused, 3, "no Dask scheduler answers at tcp://127.0.0.1:9")
        assert content_hash(db) == before
        fresh = tmp_path / "fresh.db"
        assert run("ingest", HAND, "--db", fresh, *TINY, *more).code == 3
        assert not fresh.exists()
