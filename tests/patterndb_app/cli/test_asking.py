"""patterndb stats, meshes, query and verify on a sound database."""

from __future__ import annotations

import sqlite3
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb_app.cli.text import WIDTH
from tests.support.cli.commandline import Result, assert_refused, run

#: Keys of a fill in the JSON document, and the types of their values.
FILL = {
    "pattern": str,
    "origin": str,
    "frequency": int,
    "widths": list,
    "rotation": int,
    "mirrored": bool,
    "n_irregular": int,
    "n_irregular_boundary": int,
    "strict": bool,
    "flow_distance": type(None),
    "n_vertices": int,
    "quads": list,
    "sides": list,
}

#: Options under which a query is all about patterns that were learned.
LEARNED = ("--strict", "--learned-only", "--order", "regular")


def query(db: Path, sides: str, *options: object) -> Result:
    return run("query", "--sides", sides, "--db", db, *options)


class TestStats:
    def test_json(self, learned: Path) -> None:
        document = run("stats", "--db", learned, "--json").document()
        assert document["meshes"] == 5
        assert document["patterns"] <= document["patterns_oriented"] <= 2 * document["patterns"]
        for key in ("by_sides", "by_irregular"):
            assert all(k.isdigit() and v > 0 for k, v in document[key].items())
            assert sum(document[key].values()) == document["patterns"]
        assert {str(n) for n in range(9)} <= document["by_sides"].keys()
        assert len(bytes.fromhex(document["content_hash"])) == 32

    def test_text_agrees(self, learned: Path) -> None:
        document = run("stats", "--db", learned, "--json").document()
        result = run("stats", "--db", learned)
        assert result.err == ""
        first, second, third, *rest = result.out.splitlines()
        assert first.startswith(f"{document['patterns']} patterns, ")
        assert second.startswith("5 meshes, ")
        assert third == f"content {document['content_hash']}"
        pairs = [tuple(line.split()) for line in rest if line.strip()[:1].isdigit()]
        expected = [*document["by_sides"].items(), *document["by_irregular"].items()]
        assert pairs == [(k, str(v)) for k, v in expected]


class TestMeshes:
    def test_json(self, learned: Path) -> None:
        rows = run("meshes", "--db", learned, "--json").document()["meshes"]
        assert [row["name"] for row in rows] == sorted(row["name"] for row in rows)
        for row in rows:
            assert len(row["sha256"]) == 64
            assert row["options"] == {
                "basic": 5,
                "side": 8,
                "convex": 16,
                "prepare": True,
                "most_patterns": 0,
            }
            assert row["left_out"] == 0
            assert row["provenance"] == {"author": None, "source": None, "licence": None}
            assert 0 < row["patterns"] <= row["distinct"]

    def test_text_has_a_line_for_each(self, learned: Path) -> None:
        head, *lines = run("meshes", "--db", learned).out.splitlines()
        assert head.split()[:4] == ["mesh", "quads", "patches", "patterns"]
        assert [line.split()[0] for line in lines] == [
            f"{name}.obj" for name in ("dog", "drop", "hand", "head", "jug")
        ]
        assert len({len(line.rsplit("  ", 1)[0]) for line in lines}) == 1


class TestQuery:
    @pytest.mark.parametrize("options", [(), LEARNED], ids=["default", "learned"])
    def test_json(self, learned: Path, options: tuple[str, ...]) -> None:
        document = query(learned, "3,5,4,6", "--json", "--flat", *options).document()
        assert document["sides"] == [3, 5, 4, 6]
        assert document["corners"] == ["convex"] * 4
        assert isinstance(document["seconds"], float)
        assert document["truncated"] is True
        assert document["stopped"] is None and document["reason"] is None
        assert len(document["fills"]) == 20
        for fill in document["fills"]:
            assert fill.keys() == FILL.keys()
            for key, kind in FILL.items():
                assert type(fill[key]) is kind, key
            assert [len(side) - 1 for side in fill["sides"]] == [3, 5, 4, 6]
            assert fill["origin"] in ("learned", "family", "constructed")
            assert (fill["frequency"] > 0) == (fill["origin"] == "learned")
            assert len(fill["pattern"]) == 16
            assert fill["strict"] == (fill["n_irregular_boundary"] == 0)
            assert min(fill["widths"]) >= 1
            assert {v for quad in fill["quads"] for v in quad} == set(range(fill["n_vertices"]))
        irregular = [fill["n_irregular"] for fill in document["fills"]]
        assert irregular[0] == min(irregular)
        if options:
            assert irregular == sorted(irregular)
            assert {(f["origin"], f["strict"]) for f in document["fills"]} == {("learned", True)}

    @pytest.mark.parametrize("sides", ["3,5,4,6", "2,1,3,4", "2,2", "1,1,1,1,1,1"])
    def test_text_agrees(self, learned: Path, sides: str) -> None:
        document = query(learned, sides, "--json", "--flat").document()
        result = query(learned, sides, "--flat")
        head, *lines = result.out.splitlines()
        assert head.split() == [
            "rank",
            "pattern",
            "irregular",
            "quads",
            "origin",
            "seen",
            "turned",
            "widths",
        ]
        for rank, (line, fill) in enumerate(zip(lines, document["fills"], strict=True), 1):
            words = line.replace(",", "").split()
            at_boundary = fill["n_irregular_boundary"]
            turned = [str(fill["rotation"]), *(["mirrored"] if fill["mirrored"] else [])]
            expected = [
                str(rank),
                fill["pattern"],
                str(fill["n_irregular"]),
                *(f"({at_boundary} on boundary)".split() if at_boundary else []),
                str(len(fill["quads"])),
                fill["origin"],
                str(fill["frequency"]),
                *turned,
                *map(str, fill["widths"]),
            ]
            if words[-1].endswith("…"):
                # A long line is cut within its widths.
                assert len(line) == WIDTH
                words.pop()
                expected = expected[: len(words)]
            assert words == expected
        feasible = document["feasible_patterns"]
        assert f"{feasible} learned pattern{'' if feasible == 1 else 's'} fit" in result.err
        assert ("more fills" in result.err) == document["truncated"]

    @pytest.mark.parametrize("sides", ["3,5,4,6", "2,1,3,4", "2,2", "1,1,1,1,1,1"])
    @pytest.mark.parametrize("order", ["artist", "small"])
    def test_text_shows_different_patterns_and_counts_the_rest(
        self, learned: Path, sides: str, order: str
    ) -> None:
        """The first of each pattern in the flat list, and how many more there are, up to 25."""
        asked = (sides, "--order", order)
        everything = query(learned, *asked, "--json", "--flat", "--limit", 2000).document()["fills"]
        result = query(learned, *asked, "--limit", 8)
        head, *lines = result.out.splitlines()
        folded = query(learned, *asked, "--limit", 8, "--json").document()["fills"]
        names = [line.split()[1] for line in lines]
        assert names == [fill["pattern"] for fill in folded]
        counts = Counter(_names(everything))
        assert len(set(names)) == len(names) == min(8, len(counts))
        if order == "artist":
            assert names == list(counts)[:8]
        assert ("variants" in head.split()) == any(fill["variants"] for fill in folded)
        for line, fill in zip(lines, folded, strict=True):
            more = fill["variants"]
            if len(everything) < 2000:
                assert more == min(counts[fill["pattern"]] - 1, 25)
            assert (f" +{more}" in line) == (more > 0)
            opened = query(learned, *asked, "--json", "--pattern", fill["pattern"]).document()
            assert min(len(opened["fills"]), 20) == min(more + 1, 20)
            assert set(_names(opened["fills"])) == {fill["pattern"]}
        assert ("more patterns" in result.err) == (len(counts) > 8)

    def test_folded_goes_without_what_asks_for_more_of_a_pattern(self, learned: Path) -> None:
        for other in (("--pattern", "05"), ("--per-pattern", "2")):
            assert_refused(query(learned, "3,5,4,6", "--folded", *other), 2, "leave --pattern")
        assert_refused(query(learned, "3,5,4,6", "--pattern", "fffffff"), 1, "fffffff")

    def test_limits_take_the_first(self, learned: Path) -> None:
        asked = ("3,5,4,6", "--json", "--flat", *LEARNED)
        everything = query(learned, *asked, "--limit", 10000).document()
        assert everything["truncated"] is False
        names = _names(everything["fills"])
        assert len(set(names)) == everything["feasible_patterns"]
        assert max(Counter(names).values()) > 4
        some = query(learned, *asked, "--limit", 7).document()
        assert some["fills"] == everything["fills"][:7]
        assert some["truncated"] is True
        assert some["feasible_patterns"] == everything["feasible_patterns"]
        for most in (1, 4):
            of_each = query(learned, *asked, "--limit", 10000, "--per-pattern", most).document()
            assert of_each["fills"] == _first_of_each(everything["fills"], most)
            assert of_each["truncated"] is True
        all_of_each = query(learned, *asked, "--limit", 10000, "--per-pattern", 0).document()
        assert all_of_each["fills"] == everything["fills"]

    @pytest.mark.parametrize("order", ["artist", "regular"])
    def test_limits_take_the_first_of_all_kinds(self, learned: Path, order: str) -> None:
        asked = ("2,3,3,4", "--json", "--flat", "--order", order)
        everything = query(learned, *asked, "--limit", 10000).document()
        assert everything["truncated"] is False
        assert {fill["origin"] for fill in everything["fills"]} >= {"learned", "family"}
        for limit in (1, 2, 7, 60, len(everything["fills"])):
            some = query(learned, *asked, "--limit", limit).document()
            assert some["fills"] == everything["fills"][:limit]
            assert some["truncated"] is (limit < len(everything["fills"]))

    @pytest.mark.parametrize("options", [(), LEARNED], ids=["default", "learned"])
    def test_max_irregular(self, learned: Path, options: tuple[str, ...]) -> None:
        asked = ("2,3,3,4", "--limit", 10000, "--json", "--flat", *options)
        everything = query(learned, *asked).document()["fills"]
        for most in range(6):
            result = query(learned, *asked, "--max-irregular", most)
            kept = result.document()["fills"]
            assert kept == [fill for fill in everything if fill["n_irregular"] <= most]
            assert result.code == (0 if kept else 1)

    @pytest.mark.parametrize(
        ("valence", "allowed"), [("3..5", {3, 4, 5}), ("5", {5}), ("4..6", {4, 5, 6})]
    )
    def test_valence(self, learned: Path, valence: str, allowed: set[int]) -> None:
        asked = ("4,4,3,3,4", "--limit", 1000, "--json", "--flat", *LEARNED)
        everything = query(learned, *asked).document()["fills"]
        kept = query(learned, *asked, "--valence", valence).document()["fills"]
        assert kept == [fill for fill in everything if _valences(fill) <= allowed]
        assert 0 < len(kept) < len(everything)

    @pytest.mark.parametrize("options", [("--limit", "5"), LEARNED], ids=["default", "learned"])
    def test_the_other_solver_says_the_same(self, learned: Path, options: tuple[str, ...]) -> None:
        answers = [
            query(learned, "3,2,3,4", "--json", "--flat", "--solver", solver, *options).document()
            for solver in ("kernel", "cp-sat")
        ]
        for answer in answers:
            del answer["seconds"]
        assert answers[0] == answers[1]
        assert answers[0]["fills"]

    def test_closed_is_one_side_without_a_corner(self, learned: Path) -> None:
        document = query(learned, "8", "--closed", "--json", "--flat", *LEARNED).document()
        assert document["sides"] == [8] and document["corners"] == []
        assert document["fills"]
        for fill in document["fills"]:
            assert len(fill["sides"]) == 1 and len(fill["sides"][0]) == 9
            assert fill["sides"][0][0] == fill["sides"][0][-1]
        with_a_corner = query(learned, "8", "--json", "--flat", *LEARNED).document()
        assert with_a_corner["fills"]
        assert not set(_names(with_a_corner["fills"])) & set(_names(document["fills"]))

    @pytest.mark.parametrize("sides", ["2,2", "1,1,1,1,1,1", ",".join(["2"] * 40)])
    def test_no_fill(self, learned: Path, sides: str) -> None:
        result = query(learned, sides, "--json", "--strict", "--learned-only")
        document = result.document()
        assert result.code == 1
        assert document["fills"] == [] and document["feasible_patterns"] == 0
        assert document["truncated"] is False
        assert f"no fill: {document['reason']}" in result.err
        text = query(learned, sides, "--strict", "--learned-only")
        assert_refused(text, 1, "no fill: ")
        # Relaxed, there always is one.
        relaxed = query(learned, sides, "--json")
        assert relaxed.code == 0 and relaxed.document()["fills"]

    def test_no_fill_writes_no_files(self, learned: Path, tmp_path: Path) -> None:
        wanted = ("--obj", tmp_path / "fills", "--image", tmp_path / "fills.png")
        assert query(learned, "2,2", "--strict", *wanted).code == 1
        assert list(tmp_path.iterdir()) == []

    def test_files_of_an_earlier_run_are_named(self, learned: Path, tmp_path: Path) -> None:
        folder, image = tmp_path / "fills", tmp_path / "sheet.svg"
        first = query(learned, "3,5,4,6", "--limit=3", "--obj", folder)
        assert "older" not in first.err
        (tmp_path / "sheet-7.svg").write_text("")
        (tmp_path / "sheet-of-mine.svg").write_text("")
        again = query(learned, "3,5,4,6", "--limit=1", "--obj", folder, "--image", image)
        assert again.code == 0
        assert f"2 older files in {folder}, not of these: fill-002.obj, fill-003.obj" in again.err
        assert f"1 older file in {tmp_path}, not of these: sheet-7.svg;" in again.err
        assert len(list(folder.iterdir())) == 3

    def test_obj_files_hold_the_quads(self, learned: Path, tmp_path: Path) -> None:
        folder = tmp_path / "deep" / "fills"
        result = query(learned, "3,5,4,6", "--json", "--obj", folder)
        fills = result.document()["fills"]
        assert f"written: {len(fills)} files in {folder}" in result.err
        paths = sorted(folder.iterdir())
        assert [path.name for path in paths] == [f"fill-{k:03}.obj" for k in range(1, 21)]
        for path, fill in zip(paths, fills, strict=True):
            mesh = read_mesh(path)
            quads, faces = mesh.quads()
            assert quads.tolist() == fill["quads"]
            assert faces.tolist() == list(range(len(quads)))
            assert mesh.points.shape == (fill["n_vertices"], 3)
            corners = mesh.points[quads][..., :2]
            step = np.roll(corners, -1, axis=1) - corners
            turns = step[..., 0] * np.roll(step, -1, axis=1)[..., 1]
            turns -= step[..., 1] * np.roll(step, -1, axis=1)[..., 0]
            assert (turns.sum(axis=1) > 0).all(), "quads run clockwise in the plane"

    def test_long_sides_are_answered_whole(self, learned: Path) -> None:
        document = query(learned, "300,300,300,300", "--limit", 1, "--json").document()
        assert len(document["fills"][0]["quads"]) == 90_000


def _names(fills: list[dict[str, str]]) -> list[str]:
    return [fill["pattern"] for fill in fills]


def _first_of_each(fills: list[dict[str, str]], most: int) -> list[dict[str, str]]:
    """The fills, but of each pattern only so many."""
    seen: Counter[str] = Counter()
    kept: list[dict[str, str]] = []
    for fill in fills:
        seen[fill["pattern"]] += 1
        if seen[fill["pattern"]] <= most:
            kept.append(fill)
    return kept


def _valences(fill: dict[str, list[list[int]]]) -> set[int]:
    """Of the irregular vertices within."""
    counts = np.bincount(np.ravel(fill["quads"]))
    border = {v for side in fill["sides"] for v in side}
    return {int(n) for v, n in enumerate(counts) if v not in border} - {4}


class TestVerify:
    def test_sound(self, learned: Path) -> None:
        result = run("verify", "--db", learned)
        assert (result.code, result.out) == (0, "")
        assert result.err == f"{learned}: sound\n"
        assert run("verify", "--db", learned, "--json").document() == {"ok": True, "findings": []}

    def test_tells_what_is_wrong(self, db: Path) -> None:
        with sqlite3.connect(db) as connection:
            connection.execute("UPDATE mesh SET basic_patches = distinct_patches + 1")
            connection.execute("UPDATE pattern SET n_irregular = 99 WHERE n_sides = 3")
        connection.close()
        result = run("verify", "--db", db)
        assert result.code == 3
        assert "by modes" in result.out and "columns" in result.out
        assert result.err.endswith(" findings\n")
        document = run("verify", "--db", db, "--json").document()
        assert document == {"ok": False, "findings": result.out.splitlines()}
