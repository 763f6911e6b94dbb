"""patterndb list, export and diff; what databases hold in common is told exactly."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import patterndb
from ingest.formats import read_mesh
from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from tests.support.cli.commandline import TINY, assert_refused, content_hash, mesh_names, run
from tests.support.shared import CHECKOUT

JUG, DOG = (CHECKOUT / "examples" / name for name in ("jug.obj", "dog.obj"))


def ids_of(db: Path) -> set[str]:
    """The names of all patterns, from the classes themselves."""
    with patterndb.open(db) as database:
        return {
            f"{number:016x}"
            for n in database.sides_histogram()
            for number in database.pattern_class(n).ids.tolist()
        }


def listed(db: Path, *options: object) -> list[dict[str, Any]]:
    document = run("list", "--db", db, "--limit", 100_000, "--json", *options).document()
    assert document["truncated"] is False
    return document["patterns"]


class TestList:
    def test_everything(self, learned: Path) -> None:
        rows = listed(learned)
        assert {row["pattern"] for row in rows} == ids_of(learned)
        with patterndb.open(learned) as database:
            for row in rows[::7]:
                pattern = database.pattern(row["pattern"])
                assert row["frequency"] == pattern.frequency
                assert row["meshes"] == len(database.occurrences(pattern))

    def test_the_quads_are_the_patterns(self, learned: Path) -> None:
        for row in listed(learned)[::5]:
            twin = QuadMesh.from_quads(row["quads"]).twin
            assert Pattern.from_disk(twin).name == row["pattern"]
            assert len(row["quads"]) == row["n_quads"]
            disk = Disk.from_twin(twin)
            assert (disk.perimeter, disk.n_sides) == (row["boundary"], row["n_sides"])

    @pytest.mark.parametrize(
        ("option", "holds"),
        [
            (("--class", 5), lambda row: row["n_sides"] == 5),
            (("--convex",), lambda row: all(k == 1 for k in row["corners"])),
            (("--max-irregular", 2), lambda row: len(row["valences"]) <= 2),
            (("--max-quads", 6), lambda row: row["n_quads"] <= 6),
            (("--min-frequency", 9), lambda row: row["frequency"] >= 9),
            (("--valence", "3..5"), lambda row: all(3 <= v <= 5 for v in row["valences"])),
        ],
    )
    def test_a_choice_is_what_it_says(
        self, learned: Path, option: tuple[object, ...], holds: Callable[[dict[str, Any]], bool]
    ) -> None:
        rows = listed(learned)
        chosen = listed(learned, *option)
        assert chosen == [row for row in rows if holds(row)]
        assert 0 < len(chosen) < len(rows)

    def test_of_a_mesh(self, learned: Path) -> None:
        name = mesh_names(learned)[0]
        chosen = {row["pattern"] for row in listed(learned, "--from-mesh", name)}
        with patterndb.open(learned) as database:
            assert chosen == {
                row["pattern"]
                for row in listed(learned)
                if name in {o.mesh for o in database.occurrences(database.pattern(row["pattern"]))}
            }

    def test_the_text_agrees_and_says_that_there_are_more(self, learned: Path) -> None:
        result = run("list", "--db", learned, "--class", 4, "--limit", 3)
        assert result.code == 0 and "--limit" in result.err
        shown = [line.split()[0] for line in result.out.splitlines()[1:]]
        assert shown == [row["pattern"] for row in listed(learned, "--class", 4)[:3]]

    def test_nothing(self, learned: Path) -> None:
        assert_refused(run("list", "--db", learned, "--class", 77), 1, "no such pattern")


class TestExport:
    def test_lines(self, learned: Path, tmp_path: Path) -> None:
        result = run("export", tmp_path / "a.jsonl", "--db", learned)
        assert (result.code, result.out) == (0, "")
        lines = (tmp_path / "a.jsonl").read_text().splitlines()
        assert [json.loads(line) for line in lines] == listed(learned)

    def test_table(self, learned: Path, tmp_path: Path) -> None:
        run("export", tmp_path / "a.CSV", "--db", learned, "--class", 5)
        with (tmp_path / "a.CSV").open(newline="") as file:
            rows = list(csv.DictReader(file))
        wanted = listed(learned, "--class", 5)
        assert len(rows) == len(wanted) > 1
        for row, document in zip(rows, wanted, strict=True):
            assert row["pattern"] == document["pattern"]
            assert int(row["frequency"]) == document["frequency"]
            assert [int(v) for v in row["valences"].split()] == document["valences"]
            assert bool(int(row["chiral"])) == document["chiral"]
            label = [[int(c) for c in side.split()] for side in row["label"].split("|")]
            assert label == document["label"]

    def test_folder(self, learned: Path, tmp_path: Path) -> None:
        folder = tmp_path / "five"
        run("export", folder, "--db", learned, "--class", 5)
        names = {row["pattern"] for row in listed(learned, "--class", 5)}
        assert {path.stem for path in folder.iterdir()} == names
        for path in list(folder.iterdir())[:5]:
            quads, _ = read_mesh(path).quads()
            assert Pattern.from_disk(QuadMesh.from_quads(quads).twin).name == path.stem
        again = run("export", folder, "--db", learned, "--class", 5, "--limit", 1)
        assert f"{len(names) - 1} older files in {folder}" in again.err

    @pytest.mark.parametrize(
        ("name", "words"),
        [
            ("a.xlsx", (".jsonl", ".csv", "folder")),
            ("no/a.csv", ("no folder",)),
            ("file", ("is a file",)),
        ],
    )
    def test_refusals(
        self, learned: Path, tmp_path: Path, name: str, words: tuple[str, ...]
    ) -> None:
        (tmp_path / "file").write_text("kept")
        assert_refused(run("export", tmp_path / name, "--db", learned), 2, *words)
        assert [path.name for path in tmp_path.iterdir()] == ["file"]

    def test_nothing_is_no_file(self, learned: Path, tmp_path: Path) -> None:
        result = run("export", tmp_path / "a.csv", "--db", learned, "--class", 77)
        assert_refused(result, 1, "no such pattern")
        assert list(tmp_path.iterdir()) == []


class TestDiff:
    @pytest.fixture
    def databases(self, tmp_path: Path) -> tuple[Path, Path]:
        jug, dog = tmp_path / "jug.db", tmp_path / "dog.db"
        run("ingest", JUG, "--db", jug, *TINY)
        run("ingest", DOG, "--db", dog, "--basic", 5, "--side", 0, "--convex", 0)
        return jug, dog

    def test_what_only_one_holds(self, databases: tuple[Path, Path]) -> None:
        document = run("diff", *databases, "--json").document()
        jug, dog = map(ids_of, databases)
        assert document["alike"] is False
        assert [set(one["patterns"]) for one in document["alone"]] == [jug - dog, dog - jug]
        assert [one["meshes"] for one in document["alone"]] == [["jug.obj"], ["dog.obj"]]
        assert document["patterns_of_both"] == len(jug & dog)
        seen = [{row["pattern"]: row["frequency"] for row in listed(db)} for db in databases]
        assert set(document["recounted"]) == {
            name for name in jug & dog if seen[0][name] != seen[1][name]
        }
        said = run("diff", *databases).out
        assert f"jug.db alone: 1 mesh, {len(jug - dog)} pattern" in said and "  dog.obj" in said

    def test_alike(self, databases: tuple[Path, Path], tmp_path: Path) -> None:
        other = tmp_path / "other.db"
        run("merge", *databases, "--db", other)
        run("merge", databases[0], "--db", databases[1])
        assert content_hash(other) == content_hash(databases[1])
        document = run("diff", other, databases[1], "--json").document()
        assert document["alike"] and not document["recounted"] and not document["retaught"]
        assert not any(one["patterns"] or one["meshes"] for one in document["alone"])
        assert "hold the same" in run("diff", other, databases[1]).out

    def test_other_options(self, databases: tuple[Path, Path], tmp_path: Path) -> None:
        other = tmp_path / "other.db"
        run("ingest", JUG, "--db", other, "--basic", 5, "--side", 0, "--convex", 0)
        document = run("diff", databases[0], other, "--json").document()
        assert document["retaught"] == ["jug.obj"]
        assert "learned with different options" in run("diff", databases[0], other).out

    def test_refusals(self, tmp_path: Path) -> None:
        missing = tmp_path / "no.db"
        assert_refused(run("diff", missing, missing), 3, "no.db")
        assert_refused(run("diff"), 2, "Missing argument")
