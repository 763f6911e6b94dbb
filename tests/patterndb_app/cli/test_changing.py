"""patterndb merge and remove."""

from __future__ import annotations

import json
import shutil
import sqlite3
from pathlib import Path

import pytest

from tests.support.cli.commandline import TINY, assert_refused, content_hash, mesh_names, run
from tests.support.shared import EXAMPLES

JUG = EXAMPLES / "jug.obj"
HAND = EXAMPLES / "hand.obj"


@pytest.fixture
def jug(tmp_path: Path) -> Path:
    assert run("ingest", JUG, "--db", tmp_path / "jug.db", *TINY).code == 0
    return tmp_path / "jug.db"


@pytest.fixture
def hand(tmp_path: Path) -> Path:
    assert run("ingest", HAND, "--db", tmp_path / "hand.db", *TINY).code == 0
    return tmp_path / "hand.db"


class TestMerge:
    def test_is_as_ingesting_all(self, tiny: Path, jug: Path, hand: Path, tmp_path: Path) -> None:
        both = tmp_path / "both.db"
        document = run("merge", hand, jug, "--db", both, "--json").document()
        assert document == {"added": 2, "replaced": 0, "unchanged": 0, "patterns": 3}
        assert content_hash(both) == content_hash(tiny)
        assert run("verify", "--db", both).code == 0

    def test_again_changes_nothing(self, tiny: Path, jug: Path) -> None:
        before = content_hash(tiny)
        document = run("merge", jug, "--db", tiny, "--json").document()
        assert (document["added"], document["replaced"], document["unchanged"]) == (0, 0, 1)
        assert content_hash(tiny) == before

    def test_then_remove_leads_back(self, jug: Path, hand: Path) -> None:
        before = content_hash(jug)
        assert run("merge", hand, "--db", jug).code == 0
        assert run("remove", "hand.obj", "--db", jug).code == 0
        assert content_hash(jug) == before

    def test_other_options_are_taken_from_the_other(self, tiny: Path, tmp_path: Path) -> None:
        other = tmp_path / "other.db"
        assert run("ingest", JUG, "--db", other, "--basic", 2, *TINY[2:]).code == 0
        document = run("merge", other, "--db", tiny, "--json").document()
        assert (document["added"], document["replaced"]) == (0, 1)
        rows = run("meshes", "--db", tiny, "--json").document()["meshes"]
        assert {row["name"]: row["options"]["basic"] for row in rows} == {
            "hand.obj": 3,
            "jug.obj": 2,
        }

    def test_text(self, jug: Path, tmp_path: Path) -> None:
        result = run("merge", jug, "--db", tmp_path / "a.db")
        assert result.out.startswith("1 mesh added, 0 replaced, 0 there before; 3 patterns in ")
        assert result.err == ""

    def test_refuses_itself(self, jug: Path, tmp_path: Path) -> None:
        before = jug.read_bytes()
        assert_refused(run("merge", jug, "--db", jug), 3, "into itself")
        (tmp_path / "link.db").symlink_to(jug)
        assert_refused(run("merge", tmp_path / "link.db", "--db", jug), 3, "into itself")
        assert jug.read_bytes() == before

    @pytest.mark.parametrize("kind", ["missing", "folder", "text"])
    def test_a_bad_one_changes_nothing(self, jug: Path, tmp_path: Path, kind: str) -> None:
        bad = tmp_path / "bad.db"
        if kind == "folder":
            bad.mkdir()
        if kind == "text":
            bad.write_text("no database")
        ours = tmp_path / "ours.db"
        assert_refused(run("merge", jug, bad, "--db", ours), 3, "bad.db")
        assert not ours.exists()

    def test_needs_names(self, jug: Path) -> None:
        assert_refused(run("merge", "--db", jug), 2, "OTHER")
        assert_refused(run("merge", jug), 2, "--db")


class TestRemove:
    def test_and_ingest_lead_back(self, db: Path) -> None:
        before = content_hash(db)
        names = mesh_names(db)
        options = run("meshes", "--db", db, "--json").document()["meshes"][0]["options"]
        document = run("remove", "jug.obj", "--db", db, "--json").document()
        assert document["meshes"] == 1
        assert document["patterns"] > 0 and document["patterns_removed"] >= 0
        assert mesh_names(db) == [name for name in names if name != "jug.obj"]
        assert run("verify", "--db", db).code == 0
        limits = [f"--{name}={options[name]}" for name in ("basic", "side", "convex")]
        assert run("ingest", JUG, "--db", db, *limits).code == 0
        assert content_hash(db) == before

    def test_by_hash_and_several(self, tiny: Path) -> None:
        rows = run("meshes", "--db", tiny, "--json").document()["meshes"]
        result = run("remove", rows[0]["sha256"][:8], rows[1]["name"], "--db", tiny)
        assert result.code == 0
        assert result.out.startswith("2 meshes and 3 patterns removed; 0 patterns left")
        assert mesh_names(tiny) == []

    def test_unknown_names_change_nothing(self, tiny: Path) -> None:
        before = content_hash(tiny)
        result = run("remove", "jug.obj", "cup.obj", "--db", tiny)
        assert_refused(result, 1, "'cup.obj'", "patterndb meshes")
        assert content_hash(tiny) == before

    def test_a_name_that_two_meshes_have(self, tiny: Path, tmp_path: Path) -> None:
        (tmp_path / "x").mkdir()
        other = shutil.copy(EXAMPLES / "dog.obj", tmp_path / "x" / "jug.obj")
        assert run("ingest", other, "--db", tiny, *TINY).code == 0
        assert_refused(run("remove", "jug.obj", "--db", tiny), 1, "2 meshes", "SHA-256")
        assert len(mesh_names(tiny)) == 3

    def test_does_not_make_a_database(self, tmp_path: Path) -> None:
        assert_refused(run("remove", "a.obj", "--db", tmp_path / "a.db"), 3, "no database")
        assert not (tmp_path / "a.db").exists()

    def test_the_starter_cannot_be_changed(self, tiny: Path) -> None:
        assert_refused(run("remove", "a.obj"), 2, "--db")
        assert_refused(run("remove", "a.obj", "--db", ":starter:"), 2, "merge --starter")
        assert_refused(run("merge", tiny, "--db", ":starter:"), 2, "merge --starter")
        assert not Path(":starter:").exists()


def test_the_starter_has_its_name_wherever_a_database_is_read() -> None:
    assert run("stats", "--db", ":starter:", "--json").out == run("stats", "--json").out
    assert run("diff", ":starter:", ":starter:").code == 0


def test_json_is_one_line_of_ascii(tmp_path: Path) -> None:
    mesh = shutil.copy(JUG, tmp_path / "jüg.obj")
    result = run("ingest", mesh, "--db", tmp_path / "a.db", *TINY, "--author", "Ådä", "--json")
    assert result.out.isascii()
    assert json.loads(result.out)["meshes"][0]["name"] == "jüg.obj"


class TestRepair:
    def test_saves_all_of_a_sound_database(self, tiny: Path, tmp_path: Path) -> None:
        saved = tmp_path / "saved.db"
        document = run("verify", "--db", tiny, "--repair", saved, "--json").document()
        assert document["ok"] is True
        assert document["saved"]["mesh"] == 2
        assert content_hash(saved) == content_hash(tiny)

    def test_tells_what_is_lost(self, tiny: Path, tmp_path: Path) -> None:
        connection = sqlite3.connect(tiny)
        connection.execute("UPDATE mesh SET distinct_patches = 1 WHERE name = 'jug.obj'")
        connection.commit()
        connection.close()
        saved = tmp_path / "saved.db"
        told = run("verify", "--db", tiny, "--repair", saved)
        assert told.code == 3
        assert "incomplete: jug.obj" in told.out
        assert run("verify", "--db", saved).code == 0

    def test_needs_a_new_file(self, tiny: Path) -> None:
        assert_refused(run("verify", "--db", tiny, "--repair", tiny), 3, "there already")
        assert run("verify", "--repair", tiny).code == 2
