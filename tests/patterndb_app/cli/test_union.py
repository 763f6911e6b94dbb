"""--db given several times: one list, who holds each pattern, and where an accepted fill goes."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

import patterndb
from tests.support.cli.commandline import TINY, assert_refused, run
from tests.support.meshes import CUP, star, write_obj

SQUARE = {
    "sides": [[[0, 0], [3, 0]], [[3, 0], [3, 3]], [[3, 3], [0, 3]], [[0, 3], [0, 0]]],
    "lengths": [3, 3, 3, 3],
}


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    """Databases of a mesh each."""
    paths: list[Path] = []
    for name, quads in (("cup", CUP), ("star", star(5, 2))):
        mesh = write_obj(tmp_path / f"{name}.obj", quads)
        paths.append(tmp_path / f"{name}.db")
        assert run("ingest", mesh, "--db", paths[-1], *TINY).code == 0
    return paths[0], paths[1]


def test_a_query_tells_who_holds_each_pattern(two: tuple[Path, Path]) -> None:
    cup, stars = two
    asked = ("--sides", "3,4,3,4", "--limit", 6)
    found = run("query", *asked, "--db", cup, "--db", f"{stars}=2.5", "--json")
    assert found.code == 0
    fills = found.document()["fills"]
    with patterndb.open([cup, (stars, 2.5)]) as union:
        for fill in fills:
            held = (
                union.find_occurrences(union.pattern(fill["pattern"])) if fill["frequency"] else []
            )
            assert fill["databases"] == [one.to_json() for one in held]
        assert any(fill["databases"] for fill in fills)
    assert {one["weight"] for fill in fills for one in fill["databases"]} <= {1.0, 2.5}
    table = run("query", *asked, "--db", cup, "--db", stars).out.splitlines()
    assert " in " in table[0]
    assert any(str(stars) in line for line in table[1:])
    # One database tells nothing of the kind.
    alone = run("query", *asked, "--db", cup, "--json").document()
    assert all("databases" not in fill for fill in alone["fills"])


def test_every_way_to_ask_takes_several(two: tuple[Path, Path], tmp_path: Path) -> None:
    cup, stars = two
    both = ("--db", cup, "--db", stars)
    batch = tmp_path / "batch.jsonl"
    batch.write_text("3,3,3,3,4\n")
    answer = run("query", "--batch", batch, *both, "--limit", 2).document()
    assert all("databases" in fill for fill in answer["fills"])
    listed = run("list", *both, "--json", "--limit", 1000).document()["patterns"]
    alone = [run("list", "--db", db, "--json", "--limit", 1000).document() for db in two]
    names = [{one["pattern"] for one in document["patterns"]} for document in alone]
    assert {one["pattern"] for one in listed} == names[0] | names[1]
    assert run("export", tmp_path / "all.csv", *both).code == 0


def test_an_accepted_fill_goes_to_the_first_that_may_be_written(
    two: tuple[Path, Path], tmp_path: Path
) -> None:
    cup, stars = two
    boundary = tmp_path / "square.json"
    boundary.write_text(json.dumps(SQUARE))
    output = tmp_path / "fill.obj"
    asked = ("fill", boundary, "-o", output, "--record", "--db", ":starter:", "--db", stars)
    found = run(*asked, "--db", cup, "--json")
    assert found.code == 0
    assert f"recorded in {stars}: 1 use" in found.err
    assert "databases" in found.document()["fill"]
    with patterndb.open(stars) as one, patterndb.open(cup) as other:
        assert sum(one.uses().values()) == 1
        assert other.uses() == {}


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write every file")
def test_a_file_that_may_not_be_written_is_passed_over(
    two: tuple[Path, Path], tmp_path: Path
) -> None:
    cup, stars = two
    cup.chmod(0o444)
    with patterndb.open([cup, stars], "write") as union:
        assert union.find_writable().name == str(stars)


def test_wrong_usage_is_refused(two: tuple[Path, Path], tmp_path: Path) -> None:
    cup, _ = two
    for weight in ("0", "-1", "many", "inf"):
        refused = run("query", "--sides", "3,3,3,3", "--db", f"{cup}={weight}")
        assert refused.code == 2
        assert "weight above 0" in refused.err
    twice = run("query", "--sides", "3,3,3,3", "--db", cup, "--db", cup)
    assert_refused(twice, 3, "given twice")
    boundary = tmp_path / "square.json"
    boundary.write_text(json.dumps(SQUARE))
    starter = ("--db", ":starter:=2")
    nowhere = run("fill", boundary, "-o", tmp_path / "o.obj", "--record", *starter)
    assert_refused(nowhere, 3, "none of :starter: is open for writing")
    server = run("query", "--sides", "3,3", "--db", cup, "--db", cup, "--server", "http://x")
    assert server.code == 2


def test_a_file_with_an_equals_sign_is_that_file(two: tuple[Path, Path], tmp_path: Path) -> None:
    odd = tmp_path / "a=2"
    two[0].rename(odd)
    found = run("query", "--sides", "3,3,3,3", "--db", odd, "--json").document()
    assert all("databases" not in fill for fill in found["fills"])
    heavy = run("query", "--sides", "3,3,3,3", "--db", f"{odd}=2", "--json").document()
    assert {one["weight"] for fill in heavy["fills"] for one in fill["databases"]} == {2.0}
