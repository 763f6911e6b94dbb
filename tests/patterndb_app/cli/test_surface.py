"""patterndb surface: a network of curves in, its cycles and their surface out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing.networkfile import write_network
from tests.support.cli.commandline import assert_refused, run
from tests.support.shared import CHECKOUT
from tests.support.surfacing.networks import cube

#: Cycles of the cube as sets of its curves, which are numbered from 0.
FACES = {frozenset(cycle.curves) for cycle in cube().cycles}


@pytest.fixture
def with_cycles(tmp_path: Path) -> Path:
    path = tmp_path / "cube.json"
    write_network(path, cube())
    return path


@pytest.fixture
def bare(tmp_path: Path) -> Path:
    path = tmp_path / "bare.json"
    network = cube()
    write_network(path, CurveNetwork(network.curves, network.nodes))
    return path


def document(*args: object) -> dict[str, Any]:
    result = run("surface", *args, "--json")
    assert result.code == 0, result.err
    return result.document()


def faces(cycles: list[list[int]]) -> set[frozenset[int]]:
    return {frozenset(cycle) for cycle in cycles}


@pytest.mark.parametrize("method", ["chords", "area", "smooth", "quads"])
def test_writes_what_it_says(method: str, with_cycles: Path, tmp_path: Path, learned: Path) -> None:
    output = tmp_path / "out.obj"
    told = document(with_cycles, "-o", output, "--method", method, "--db", learned)
    assert faces(told["cycles"]) == FACES
    assert told["cycles_found"] is False
    assert told["output"] == str(output)
    mesh = read_mesh(output)
    assert mesh.n_faces == sum(patch["faces"] for patch in told["patches"])
    assert set(mesh.arities()) == ({4} if method == "quads" else {3})
    assert told["area"] == pytest.approx(6.0)
    for patch, cycle in zip(told["patches"], told["cycles"], strict=True):
        assert patch["cycle"] == cycle
        assert patch["method"] == method
        assert patch["note"] == ""
        assert patch["area"] == pytest.approx(1.0)
        assert patch["self_intersections"] == 0
        assert patch["pieces"] == 1 + patch["chosen"] == 1 + len(patch["chords"])
        assert patch["seconds"] >= 0
        if method == "chords":
            assert patch["subproblems"] >= 1
    # Neighbours share vertices: the file's mesh is closed as it stands.
    corners = mesh.corners.reshape(mesh.n_faces, -1)
    ahead = {(int(a), int(b)) for f in corners for a, b in zip(f, np.roll(f, -1), strict=True)}
    assert all((b, a) in ahead for a, b in ahead)
    groups = [line for line in output.read_text().splitlines() if line.startswith("g ")]
    assert groups == [f"g patch_{i}" for i in range(1, 7)]


def test_finds_cycles_where_the_file_has_none(bare: Path) -> None:
    told = document(bare, "--cycles-only")
    assert faces(told["cycles"]) == FACES
    assert told["cycles_found"] is True
    assert "patches" not in told


def test_finds_cycles_afresh_when_asked(tmp_path: Path) -> None:
    network = cube()
    path = tmp_path / "half.json"
    write_network(path, CurveNetwork(network.curves, network.nodes, network.cycles[:3]))
    assert len(document(path, "--cycles-only")["cycles"]) == 3
    assert faces(document(path, "--cycles-only", "--find-cycles")["cycles"]) == FACES


@pytest.mark.parametrize("given", [True, False])
def test_cycles_are_banned_and_kept(given: bool, with_cycles: Path, bare: Path) -> None:
    path = with_cycles if given else bare
    banned = sorted(min(FACES, key=sorted))
    walk = next(c for c in cube().cycles if set(c.curves) == set(banned))
    name = ",".join(map(str, walk.curves))
    told = document(path, "--cycles-only", "--ban", name)
    assert faces(told["cycles"]) == FACES - {frozenset(banned)}
    again = document(path, "--cycles-only", "--keep", name)
    assert faces(again["cycles"]) == FACES


@pytest.mark.parametrize("only", [True, False])
def test_what_stays_open_is_told(only: bool, bare: Path) -> None:
    network = cube()
    missing = network.cycles[2]
    name = ",".join(map(str, missing.curves))
    options = ["--ban", name, *(["--cycles-only"] if only else [])]
    told = document(bare, *options)
    (rim,) = told["open_rims"]
    assert rim["closed"] is True and set(rim["curves"]) == set(missing.curves)
    assert rim["length"] == pytest.approx(4.0)
    assert sorted(rim["nodes"]) == sorted(network.nodes[list(network.walk(missing))].tolist())
    assert told["bound_nothing"] == []
    said = run("surface", bare, *options).err
    assert "open rim of 4 curves, 4 long: " in said and "without a patch" not in said
    # With two neighbours banned, nothing bounds the curve between them.
    other = next(c for c in network.cycles if len({*c.curves} & {*missing.curves}) == 1)
    (shared,) = {*other.curves} & {*missing.curves}
    told = document(bare, *options, "--ban", ",".join(map(str, other.curves)))
    points = network.curves[shared].points
    assert told["bound_nothing"] == [
        {"curve": shared, "from": points[0].tolist(), "to": points[-1].tolist()}
    ]
    assert len(told["open_rims"]) == 1 and len(told["open_rims"][0]["curves"]) == 6


def test_alpha_makes_fewer_pieces_of_the_same_sub_problems(tmp_path: Path) -> None:
    t = np.linspace(0, 1, 60)
    rail = np.c_[4 * t, 0.3 * np.cos(4 * t), 0.3 * np.sin(4 * t)]
    other = np.c_[4 * t, -0.3 * np.cos(4 * t), -0.3 * np.sin(4 * t)]
    ring = np.concatenate([rail, other[::-1], rail[:1]])
    path = tmp_path / "ribbon.json"
    path.write_text(json.dumps({"curves": [{"id": "ribbon", "points": ring.tolist()}]}))
    pieces, problems = [], set()
    for alpha in (0, 0.1, 0.4, 2):
        made = document(path, "--alpha", alpha)
        assert made["method"] == "chords"  # the price of chords says that there are to be some
        (patch,) = made["patches"]
        pieces.append(patch["pieces"])
        problems.add(patch["subproblems"])
    assert pieces == sorted(pieces, reverse=True)
    assert pieces[0] > pieces[-1] == 1
    assert len(problems) == 1
    assert document(path, "--any-chord")["method"] == "chords"
    assert document(path)["patches"][0]["method"] == "smooth"
    assert document(path, "--alpha", 2, "--method", "smooth")["method"] == "smooth"


def test_the_table_names_the_method_of_every_patch(with_cycles: Path) -> None:
    result = run("surface", with_cycles)
    assert result.code == 0
    head, *rows = result.out.splitlines()
    assert head.split()[:4] == ["patch", "method", "candidates", "chosen"]
    assert [row.split()[:2] for row in rows] == [[str(i), "smooth"] for i in range(1, 7)]
    assert "6 patches" in result.err


def test_no_cycle_is_nothing_found(tmp_path: Path) -> None:
    path = tmp_path / "open.json"
    path.write_text(json.dumps({"curves": [{"points": [[0, 0, 0], [1, 0, 0], [1, 1, 1]]}]}))
    result = run("surface", path)
    assert result.code == 1
    assert "no closed cycle" in result.err
    assert result.out == ""


def test_slips_are_refused(with_cycles: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.obj"
    assert_refused(run("surface", with_cycles, "--cycles-only", "-o", output), 2, "leave -o out")
    assert_refused(run("surface", with_cycles, "--ban", "0,,1"), 2, "curve ids")
    assert_refused(run("surface", with_cycles, "--ban", "0,99"), 3, "99")
    assert_refused(run("surface", with_cycles, "--spacing", "0"), 2, "spacing")
    assert_refused(run("surface", with_cycles, "--alpha", "-1"), 2, "alpha")
    broken = tmp_path / "broken.json"
    broken.write_text('{"curves": [{"points": [[0, 0, 0], [1, "x", 0]]}]}')
    assert_refused(run("surface", broken), 3, "curves[0].points[1][1]")
    assert not output.exists()


def test_smooth_patches_are_faired_across_curves() -> None:
    teacup = CHECKOUT / "examples" / "networks" / "teacup.json"
    plain, fair = document(teacup), document(teacup, "--fair")
    assert (plain["fair"], fair["fair"]) == (False, True)
    assert fair["cycles"] == plain["cycles"]
    assert any(note.startswith("faired across ") for note in fair["notes"])
    assert [p["faces"] for p in plain["patches"]] == [p["faces"] for p in fair["patches"]]
    for slip in (("--method", "chords"), ("--alpha", 0.2), ("--any-chord",)):
        assert_refused(run("surface", teacup, "--fair", *slip), 2, "--fair", "leave")


def test_flat_faces_are_as_few_triangles_as_can_be(with_cycles: Path, tmp_path: Path) -> None:
    for extra in ((), ("--spacing", "0.05")):
        told = document(with_cycles, "-o", tmp_path / "cube.obj", *extra)
        assert [patch["faces"] for patch in told["patches"]] == [2] * 6
    assert read_mesh(tmp_path / "cube.obj").n_faces == 12


def count_stl(path: Path) -> int:
    return int(np.frombuffer(path.read_bytes(), "<u4", 1, 80)[0])


def test_writes_what_printers_read(with_cycles: Path, bare: Path, tmp_path: Path) -> None:
    told = document(with_cycles, "-o", tmp_path / "cube.stl")
    assert (told["closed"], told["thickness"]) == (True, None)
    assert count_stl(tmp_path / "cube.stl") == 12
    told = document(with_cycles, "-o", tmp_path / "shell.stl", "--thickness", "0.1")
    assert (told["closed"], told["thickness"]) == (True, 0.1)
    assert count_stl(tmp_path / "shell.stl") == 24
    network = cube()
    write_network(bare, CurveNetwork(network.curves, network.nodes, network.cycles[:3]))
    result = run("surface", bare, "-o", tmp_path / "open.3mf")
    assert "the surface is open; --thickness" in result.err
    told = document(bare, "-o", tmp_path / "solid.3mf", "--thickness", "0.1")
    assert told["closed"] is True
    assert (tmp_path / "solid.3mf").read_bytes()[:2] == b"PK"


def test_a_thickness_needs_a_file_and_a_surface(with_cycles: Path, tmp_path: Path) -> None:
    assert run("surface", with_cycles, "--thickness", "1").code == 2
    args = ("--cycles-only", "--thickness", "1", "-o", tmp_path / "a.stl")
    assert run("surface", with_cycles, *args).code == 2
    assert run("surface", with_cycles, "-o", tmp_path / "a.gltf").code == 2


def test_half_a_box_becomes_a_whole_one(tmp_path: Path) -> None:
    """Nine edges of a box: those across the plane end on it, or nearly."""
    lines = []
    for y in (0, 1):
        for z in (0, 1):
            lines.append([[0.002 * y, y, z], [1, y, z]])
        lines.append([[1, y, 0], [1, y, 1]])
    lines += [[[1, 0, z], [1, 1, z]] for z in (0, 1)]
    path = tmp_path / "half.json"
    path.write_text(json.dumps({"curves": [{"points": line} for line in lines]}))
    whole = tmp_path / "whole.stl"
    for given in (("--mirror",), ("--mirror", "x"), ("--mirror", "1,0,0,0"), ("--mirror=x=0",)):
        told = document(path, "-o", whole, *given)
        assert len(told["cycles"]) == 6
        assert told["closed"] is True
        assert any("mirrored in the plane x = 0" in note for note in told["notes"])
    assert run("surface", path, "--mirror", "w").code == 2
    assert_refused(run("surface", path, "--mirror", "x=0.5"), 3, "beyond the plane")


def test_what_is_upright_may_be_chosen(with_cycles: Path, tmp_path: Path) -> None:
    from patterndb_app.cli.surface import UPRIGHT_NAMES
    from viewer.surfacing.state import UPRIGHT, look_from

    assert set(UPRIGHT_NAMES) == set(UPRIGHT)
    pictures = []
    for up in UPRIGHT_NAMES:
        toward, upright = look_from(up)
        assert upright.tolist() == [
            ("xyz".index(up[-1]) == k) * (-1.0) ** ("-" in up) for k in range(3)
        ]
        assert toward @ upright == pytest.approx(0.42)
        assert np.linalg.det(np.array(UPRIGHT[up], float)) == pytest.approx(1.0)
        run("surface", with_cycles, "--picture", tmp_path / "cube.png", "--up", up)
        pictures.append((tmp_path / "cube.png").read_bytes())
    assert len(set(pictures)) == len(UPRIGHT_NAMES)


def test_irregular_vertices_and_turned_corners_are_counted(
    with_cycles: Path, tmp_path: Path, learned: Path
) -> None:
    args = (with_cycles, "--method", "quads", "--db", learned)
    told = document(*args)
    # The corners of a cube have three quads each.
    assert told["quads"] == {"irregular": 8, "turned_corners": 0}
    assert all(patch["turned_corners"] == 0 for patch in told["patches"])
    result = run("surface", *args)
    assert "8 irregular vertices inside, 0 quads with a turned corner" in result.err
    assert document(with_cycles)["quads"] is None
