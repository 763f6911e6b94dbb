"""patterndb fill: a boundary and strokes from JSON, a placed fill as OBJ."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import patterndb
from ingest.formats import read_mesh
from patterndb.errors import InvalidBoundaryError
from query.boundaryfile import parse_boundary, read_boundary, read_strokes
from tests.support.cli.commandline import assert_refused, run

#: An L on a slope: six sides, one reflex corner.
CORNERS = [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]

#: A square of irrational corners, so that numbers have all their digits.
SQUARE = (np.array([[0, 0, 0], [3, 0, 0], [3, 3, 1], [0, 3, 1]]) / np.pi).tolist()


def sides(corners: list[list[float]]) -> list[list[list[float]]]:
    return [[a, b] for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def square(**more: Any) -> dict[str, Any]:
    return {"sides": sides(SQUARE), "lengths": [4, 4, 4, 4]} | more


def write(folder: Path, document: object, name: str = "boundary.json") -> Path:
    path = folder / name
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


class TestFill:
    def test_writes_what_it_says(self, learned: Path, tmp_path: Path) -> None:
        boundary = write(tmp_path, square())
        output = tmp_path / "fill.obj"
        result = run("fill", boundary, "--db", learned, "-o", output, "--json")
        assert result.code == 0, result.err
        document = result.document()
        mesh = read_mesh(output)
        quads, _ = mesh.quads()
        assert quads.tolist() == document["fill"]["quads"]
        assert len(mesh.points) == document["fill"]["n_vertices"]
        asked, _ = read_boundary(boundary)
        # Bit for bit: the file holds every digit.
        assert (mesh.points[:16] == asked.points).all()
        assert document["flipped"] == [] and document["strokes"] == []
        assert document["at_rest"] is True and document["region_share"] is None
        assert "written" in result.err and "quads" in result.err
        valence = np.bincount(quads.ravel())
        inner = [v for v in range(16, len(valence)) if valence[v] != 4]
        assert document["irregular"] == inner

    def test_vertices_that_are_given_are_not_placed_anew(
        self, learned: Path, tmp_path: Path
    ) -> None:
        """Bit for bit, however unequal their distances, for polylines and for a closed side."""
        chance = np.random.default_rng(3)
        ring = np.array(SQUARE)
        drawn = []
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            t = np.sort(chance.uniform(0.0, 1.0, 3))[:, None]
            drawn.append([a.tolist(), *(a * (1 - t) + b * t).tolist(), b.tolist()])
        flat = [point for side in drawn for point in side[:-1]]
        documents = [
            {"sides": drawn, "vertices": True},
            {"sides": drawn, "vertices": True, "lengths": [4, 4, 4, 4]},
            {"sides": [flat], "vertices": True, "corners": []},
        ]
        for number, document in enumerate(documents):
            output = tmp_path / f"{number}.obj"
            given = write(tmp_path, document)
            result = run("fill", given, "--db", learned, "-o", output)
            assert result.code == 0, result.err
            assert read_mesh(output).points[:16].tolist() == flat
        # Placed anew, they are elsewhere.
        apart = write(tmp_path, {"sides": drawn, "lengths": [4, 4, 4, 4]})
        assert not np.array_equal(read_boundary(apart)[0].points, flat)

    def test_ranks_differ(self, learned: Path, tmp_path: Path) -> None:
        boundary = write(tmp_path, square())
        found = set()
        for rank in (1, 2, 3):
            output = tmp_path / f"{rank}.obj"
            assert run("fill", boundary, "--rank", rank, "--db", learned, "-o", output).code == 0
            found.add(output.read_text())
        assert len(found) == 3

    def test_an_accepted_fill_is_recorded(self, db: Path, tmp_path: Path) -> None:
        boundary = write(tmp_path, square())
        output = tmp_path / "fill.obj"
        for uses in (1, 2):
            result = run("fill", boundary, "--db", db, "--record", "--json", "-o", output)
            assert result.code == 0, result.err
            name = result.document()["fill"]["pattern"]
            assert f"recorded: {uses} use" in result.err
        with patterndb.open(db) as database:
            assert database.uses() == {int(name, 16): 2}
        assert_refused(run("fill", boundary, "--record", "-o", output), 2, "--db")

    def test_filters_are_those_of_query(self, learned: Path, tmp_path: Path) -> None:
        boundary = write(tmp_path, square())
        output = tmp_path / "fill.obj"
        wanted = ("--rank", 2, "--strict", "--learned-only", "--order", "small")
        result = run("fill", boundary, *wanted, "--db", learned, "--json", "-o", output)
        placed = result.document()["fill"]
        asked = ("query", "--sides", "4,4,4,4", "--db", learned, "--json", *wanted[2:])
        assert run(*asked).document()["fills"][1]["n_irregular"] == placed["n_irregular"]
        assert placed["strict"] and placed["origin"] == "learned"

    def test_on_a_surface_with_strokes(self, learned: Path, tmp_path: Path) -> None:
        n = 25
        u, v = np.meshgrid(np.linspace(-3, 3, n), np.linspace(-3, 3, n), indexing="ij")
        height = 0.3 * np.cos(u) * np.cos(v)
        lines = [
            f"v {x} {y} {z}" for x, y, z in zip(u.ravel(), v.ravel(), height.ravel(), strict=True)
        ]
        at = (np.arange(n - 1)[:, None] * n + np.arange(n - 1) + 1).ravel()
        lines += [f"f {i} {i + n} {i + n + 1} {i + 1}" for i in at.tolist()]
        surface = write(tmp_path, "\n".join(lines), "surface.obj")

        def on(points: list[list[float]]) -> list[list[float]]:
            return [[x, y, 0.3 * np.cos(x) * np.cos(y)] for x, y in points]

        t = np.linspace(0, 1, 20)
        around = [[-2, -2], [2, -2], [2, 2], [-2, 2], [-2, -2]]
        drawn = [on((np.outer(1 - t, a) + np.outer(t, b)).tolist()) for a, b in pairwise(around)]
        stroke = on(np.stack([0.5 * np.sin(np.pi * t), 4 * t - 2], axis=1).tolist())
        boundary = write(tmp_path, {"sides": drawn, "lengths": [5] * 4})
        strokes = write(tmp_path, {"strokes": [stroke]}, "strokes.json")
        output = tmp_path / "fill.obj"
        options = (
            "--surface",
            surface,
            "--strokes",
            strokes,
            "--db",
            learned,
            "--json",
            "--tolerance",
            0,
        )
        result = run("fill", boundary, *options, "-o", output)
        assert result.code == 0, result.err
        document = result.document()
        assert document["flipped"] == [] and document["off_surface"] < 1e-9
        assert 0.3 < document["region_share"] < 0.6
        (told,) = document["strokes"]
        assert told["mean_after"] < 0.5 * told["mean_before"]
        assert "stroke 1: mean distance" in result.err and "% of it" in result.err

    def test_no_such_rank(self, learned: Path, tmp_path: Path) -> None:
        output = tmp_path / "fill.obj"
        boundary = write(tmp_path, square())
        refused = run(
            "fill", boundary, "--rank", 100000, "--max-irregular", 0, "--db", learned, "-o", output
        )
        assert_refused(refused, 1, "there is no fill 100000, only")
        assert not output.exists()

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (["-o", "fill.png"], "must end in .obj"),
            (["-o", "nowhere/fill.obj"], "no folder nowhere"),
            (["-o", "fill.obj", "--rank", "0"], "--rank"),
            ([], "--output"),
        ],
    )
    def test_usage(self, options: list[str], words: str, tmp_path: Path) -> None:
        assert_refused(run("fill", write(tmp_path, square()), *options), 2, words)

    def test_missing_files(self, learned: Path, tmp_path: Path) -> None:
        output = tmp_path / "fill.obj"
        missing = tmp_path / "none.json"
        assert_refused(run("fill", missing, "-o", output), 3, "none.json", "No such file")
        boundary = write(tmp_path, square())
        surface = ("--surface", tmp_path / "none.obj")
        refused = run("fill", boundary, *surface, "--db", learned, "-o", output)
        assert_refused(refused, 3, "none.obj")


class TestBoundaryFile:
    def test_all_entries(self, tmp_path: Path) -> None:
        kinds = ["c", "convex", "c", "r", "c", "c"]
        loop = {"points": [[1, 1, 0], [1, 2, 0], [0.5, 1, 0]], "loop": True}
        document = {
            "sides": sides(CORNERS),
            "edge_length": 1.0,
            "corners": kinds,
            "strokes": [[[0.5, 0], [0.5, 4]], loop, {"points": [[0, 1, 0], [4, 1, 0]]}],
        }
        boundary, strokes = read_boundary(write(tmp_path, document))
        assert boundary.lengths == (4, 2, 2, 2, 2, 4)
        assert boundary.corners == ("convex",) * 3 + ("reflex",) + ("convex",) * 2
        assert boundary.points is not None and boundary.points[3].tolist() == [3.0, 0.0, 0.0]
        assert [stroke.is_loop for stroke in strokes] == [False, True, False]
        assert (strokes[0].start, strokes[0].end) == ((0, 0), (4, 1))
        more = write(tmp_path, [loop], "more.json")
        assert [stroke.is_loop for stroke in read_strokes(more, boundary)] == [True]

    def test_one_closed_side(self) -> None:
        turn = 2 * np.pi * np.arange(40) / 40
        ring = np.stack([np.cos(turn), np.sin(turn)], axis=1).tolist()
        boundary, strokes = parse_boundary(
            json.dumps({"sides": [ring], "corners": [], "lengths": [12]})
        )
        assert boundary.n_sides == 0 and boundary.lengths == (12,) and strokes == []

    @pytest.mark.parametrize(
        ("document", "words"),
        [
            ("{", ["line 1, column 2", "not JSON"]),
            ('{"sides": [], "sides": []}', ['"sides" is there twice']),
            ('{"sides": [[[NaN, 0, 0], [1, 0, 0]]]}', ["NaN", "finite"]),
            ("[" * 100_000, ["deeper"]),
            ("9" * 10_000, ["not JSON that can be read"]),
            ([1, 2], ["a list is not an object"]),
            ({"lengths": [4]}, ['"sides" is missing']),
            (square(colour="red"), ["colour: there is no such entry", "edge_length"]),
            ({"sides": sides(SQUARE)}, ["either", "neither"]),
            (square(edge_length=1), ["either", "are both"]),
            (square(lengths=[4, 4, 4]), ["3", "4"]),
            (square(lengths=[4, 4, 4, 5]), ["perimeter 17 is odd"]),
            (square(lengths=[4, 4.5, 4, 4]), ["lengths[1]: 4.5 is not a whole number"]),
            (square(lengths=[4, True, 4, 4]), ["lengths[1]: true"]),
            (square(lengths=[4, 0, 4, 4]), ["side 1 has length 0"]),
            (square(corners=["c", "x", "c", "c"]), ['corners[1]: "x" is not "convex"']),
            (square(corners="cccc"), ["corners:", "not a list"]),
            ({"sides": 7, "edge_length": 1}, ["sides: 7 is not a list"]),
            ({"sides": sides(SQUARE)}, ['say "vertices": true']),
            (square(vertices=1), ["vertices: 1 is not true or false"]),
            (square(vertices=True), ["lengths[0]: 4 edges", "give 1, or leave lengths out"]),
            (square(vertices=True, lengths=[1, 1]), ["lengths are 2", "4 sides", "leave them out"]),
            (
                {"sides": sides(SQUARE), "vertices": True, "edge_length": 1},
                ["edge_length would place vertices anew", "leave one of the two out"],
            ),
            (
                {"sides": sides(SQUARE[:3]), "vertices": True},
                ["the perimeter 3 is odd", "change one side by 1"],
            ),
            (square(sides=[[[0, 0, 0]]]), ["sides[0]", "two points or more"]),
            (square(sides=[[[0, 0, 0], [1, 0]], [[1, 0], 5]]), ["sides[1][1]: 5", "[x, y, z]"]),
            (square(sides=[[[0, 0, 0], [1, 0, "a"]]]), ['sides[0][1][2]: "a"', "a number"]),
            (square(sides=[[[0, 0, 0], [1, 0, 10**400]]]), ["sides[0][1][2]", "finite"]),
            (square(sides=sides(SQUARE)[:3]), ["side 2 ends", "where side 0 begins"]),
            (square(strokes=[[[0, 0, 0]]]), ["strokes[0]", "two points"]),
            (square(strokes=[{"loop": False}]), ["strokes[0]", '"points" is missing']),
            (square(strokes=[{"points": [], "closed": 1}]), ["strokes[0].closed"]),
            (square(strokes=[{"points": [[0, 0], [1, 1]], "loop": 1}]), ["strokes[0].loop: 1"]),
            (square(strokes=[[[0.1, 0, 0], [0.1, 0.1, 0]]]), ["strokes[0]", "loop"]),
        ],
        ids=lambda value: str(value)[:40] if isinstance(value, list) else "",
    )
    def test_refusals(self, document: object, words: list[str], tmp_path: Path) -> None:
        path = write(tmp_path, document)
        with pytest.raises(InvalidBoundaryError) as caught:
            read_boundary(path)
        for word in (str(path), *words):
            assert word in str(caught.value)
        assert_refused(run("fill", path, "-o", tmp_path / "fill.obj"), 3, *words)

    def test_bytes_that_are_no_text(self, tmp_path: Path) -> None:
        path = tmp_path / "boundary.json"
        path.write_bytes(b'{"sides": "\xff"}')
        with pytest.raises(InvalidBoundaryError, match="not UTF-8"):
            read_boundary(path)
