"""patterndb holes: holes listed, filled, welded and drawn; what cannot be filled is told."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ingest.formats import read_mesh, write_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb_app.cli import EXIT_BAD_INPUT, EXIT_NOTHING, EXIT_USAGE
from query.holes import MeshTopology, find_holes
from query.holes.symmetry import prepare_twins
from tests.support.cli.commandline import assert_refused, run
from tests.support.shared import CHECKOUT

HEAD = CHECKOUT / "docs" / "meshes" / "head.obj"

#: A vertex of each of the head's holes: on the nose, on a cheek, at the neck.
NOSE, CHEEK, NECK = 36, 475, 390


def check_document(hole: dict[str, Any], mesh: PolygonMesh) -> None:
    """The fills of a document are disks on the loop, in numbers of the mesh."""
    loop, first = hole["loop"], len(mesh.points)
    assert len(hole["corners"]) == len(loop) and hole["fills"] and hole["seconds"] >= 0
    for fill in hole["fills"]:
        quads = np.array(fill["quads"])
        assert quads.shape[1] == 4 and np.array(fill["points"]).reshape(-1, 3).shape[1] == 3
        new = set(range(first, first + len(fill["points"])))
        assert set(quads.ravel().tolist()) == set(loop) | new
        assert {"pattern", "origin", "score", "n_irregular", "flipped"} <= set(fill)
        half = {(int(q[k]), int(q[(k + 1) % 4])) for q in quads for k in range(4)}
        assert len(half) == 4 * len(quads)
        rim = {(a, b) for a, b in half if (b, a) not in half}
        assert rim == set(zip(loop, [*loop[1:], loop[0]], strict=True))
    corners = np.bincount(np.array(hole["fills"][0]["quads"]).ravel(), minlength=first)[loop]
    assert corners.tolist() == hole["corners"]


def test_holes_are_listed(learned: Path) -> None:
    result = run("holes", HEAD)
    lines = result.out.splitlines()
    assert result.code == 0 and [line.split()[0] for line in lines[1:]] == ["16", "18", "36"]
    assert [int(line.split()[-1]) for line in lines[1:]] == [NOSE, CHEEK, NECK]
    holes = run("holes", HEAD, "--json").document()["holes"]
    assert [(len(h["loop"]), h["edges"]) for h in holes] == [(16, 16), (18, 18), (36, 36)]
    assert holes[0]["length"] > 0 and len(holes[0]["centre"]) == 3


def test_a_hole_is_filled_and_welded(learned: Path, tmp_path: Path) -> None:
    output = tmp_path / "filled.obj"
    result = run("holes", HEAD, "--loop", NOSE, "-o", output, "--db", learned, "--json")
    assert result.code == 0 and f"written: {output}" in result.err
    document = result.document()
    old, new = read_mesh(HEAD), read_mesh(output)
    (hole,) = document["holes"]
    assert document["mesh"] == str(HEAD) and hole["twin"] is False
    check_document(hole, old)
    assert new.points[: len(old.points)].tobytes() == old.points.tobytes()
    assert list(islice(new.faces(), old.n_faces)) == old.faces()
    best = hole["fills"][0]
    assert new.faces()[old.n_faces :] == best["quads"]
    assert np.allclose(new.points[len(old.points) :], best["points"])
    assert [len(h) for h in find_holes(new)] == [18, 36]


def test_ranks_are_the_list(learned: Path, tmp_path: Path) -> None:
    (hole,) = run("holes", HEAD, "--loop", NOSE, "--db", learned, "--json").document()["holes"]
    output = tmp_path / "third.obj"
    assert run("holes", HEAD, "--loop", NOSE, "--rank", 3, "-o", output, "--db", learned).code == 0
    old, new = read_mesh(HEAD), read_mesh(output)
    assert new.faces()[old.n_faces :] == hole["fills"][2]["quads"]
    table = run("holes", HEAD, "--loop", NOSE, "--limit", 3, "--db", learned)
    rows = [line.split() for line in table.out.splitlines()[1:]]
    assert [row[1] for row in rows] == [fill["pattern"] for fill in hole["fills"][:3]]


def test_the_other_cheek_is_copied(learned: Path, tmp_path: Path) -> None:
    arguments = ("holes", HEAD, "--loop", CHEEK, "--db", learned)
    (hole,) = run(*arguments, "--json").document()["holes"]
    first = hole["fills"][0]
    assert hole["twin"] is True and (first["pattern"], first["score"]) == ("twin", None)
    check_document(hole, read_mesh(HEAD))
    (hole,) = run(*arguments, "--json", "--no-twin").document()["holes"]
    assert hole["twin"] is False and hole["fills"][0]["origin"] != "twin"
    assert "a mirror twin" in run(*arguments, "-o", tmp_path / "a.obj").err


def test_all_holes_are_filled(learned: Path, tmp_path: Path) -> None:
    output, picture = tmp_path / "closed.ply", tmp_path / "closed.png"
    result = run("holes", HEAD, "--all", "-o", output, "--picture", picture, "--db", learned)
    assert result.code == 0 and picture.read_bytes().startswith(b"\x89PNG")
    assert find_holes(read_mesh(output)) == [] and result.err.count("hole of") == 3


def test_mirrored_holes_are_filled_alike(learned: Path, tmp_path: Path) -> None:
    topology = MeshTopology.of(read_mesh(HEAD))
    points, faces = topology.mesh.points, topology.mesh.faces()
    cheek = next(hole for hole in find_holes(topology) if CHEEK in hole.loop)
    # What lies on the other cheek where this one has its hole goes, too.
    found = prepare_twins(topology).find(cheek)
    assert found is not None
    there = np.concatenate([cheek.points, found[1]]) * [-1.0, 1.0, 1.0]
    gone = np.linalg.norm(points[:, None] - there, axis=2).argmin(axis=0)
    kept = [face for face in faces if not np.isin(face, gone).all()]
    assert len(kept) == len(faces) - len(found[0])
    both, output = tmp_path / "both.obj", tmp_path / "closed.obj"
    write_mesh(both, PolygonMesh.from_faces(points, kept))
    result = run("holes", both, "--all", "-o", output, "--db", learned)
    assert result.code == 0 and result.err.count("a mirror twin") == 1
    alone = run("holes", both, "--all", "--no-twin", "-o", output, "--db", learned)
    assert alone.code == 0 and "a mirror twin" not in alone.err


def test_several_holes_are_named(learned: Path, tmp_path: Path) -> None:
    output = tmp_path / "two.obj"
    names = [str(hole.loop[0]) for hole in find_holes(read_mesh(HEAD))]
    asked = [word for name in (names[0], names[1], names[0]) for word in ("--loop", name)]
    result = run("holes", HEAD, *asked, "-o", output, "--db", learned)
    assert result.code == 0 and result.err.count("hole of") == 2
    left = find_holes(read_mesh(output))
    assert [str(hole.loop[0]) for hole in left] == names[2:]


def test_faces_are_made_anew(learned: Path, tmp_path: Path) -> None:
    old = read_mesh(HEAD)
    topology = MeshTopology.of(old)
    at = int(topology.start[300])
    faces = sorted({300, *(int(topology.face[topology.twin[at + k]]) for k in range(4))})
    text = ",".join(map(str, faces))
    output = tmp_path / "anew.obj"
    result = run("holes", HEAD, "--faces", text, "-o", output, "--db", learned, "--json")
    (hole,) = result.document()["holes"]
    check_document(hole, old)
    new = read_mesh(output)
    assert new.n_faces == old.n_faces - len(faces) + len(hole["fills"][0]["quads"])
    assert len(find_holes(new)) == 3


def test_strands_and_corners_as_asked(learned: Path) -> None:
    loop = run("holes", HEAD, "--json").document()["holes"][0]["loop"]
    arguments = ("holes", HEAD, "--loop", NOSE, "--db", learned, "--json")
    (hole,) = run(*arguments, "--flow", f"{loop[1]}-{loop[9]}", "--limit", 2).document()["holes"]
    check_document(hole, read_mesh(HEAD))
    (hole,) = run(*arguments, "--corners", f"{loop[1]}:1,{loop[2]}:2").document()["holes"]
    assert hole["corners"][1:3] == [1, 2]
    (hole,) = run(*arguments, "--flow", "loop", "--limit", 1).document()["holes"]
    assert hole["fills"]


def test_corners_that_no_fill_has_are_named(tmp_path: Path) -> None:
    cube = tmp_path / "cube.obj"
    points = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    sides = [(4, 3, 2, 1), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    lines += [f"f {' '.join(map(str, side))}" for side in sides]
    cube.write_text("\n".join((*lines, "")))
    # Two corners next to each other belong to one quad, which is the whole lid.
    result = run("holes", cube, "--loop", "4", "--corners", "4:1,5:1,6:1,7:2")
    assert result.code == 1 and "--corners" in result.err and "fix fewer corners" in result.err
    assert run("holes", cube, "--loop", "4", "--corners", "4:1,5:1,6:1,7:1").code == 0


def test_batches_are_answered_line_by_line(learned: Path, tmp_path: Path) -> None:
    mesh = tmp_path / "head.obj"
    mesh.write_bytes(HEAD.read_bytes())
    lines = [
        json.dumps({"mesh": "head.obj", "loop": [NOSE], "case": 7}),
        "",
        json.dumps({"mesh": "head.obj", "faces": [300, 301]}),
        json.dumps({"mesh": "head.obj", "loop": [99999]}),
        json.dumps({"mesh": "nowhere.obj", "loop": [1]}),
        json.dumps({"loop": [1]}),
        "[",
    ]
    batch = tmp_path / "questions.jsonl"
    batch.write_text("\n".join(lines))
    result = run("holes", "--batch", batch, "--limit", 3, "--db", learned)
    rows = [json.loads(line) for line in result.out.splitlines()]
    assert result.code == EXIT_BAD_INPUT and [row["line"] for row in rows] == [1, 3, 4, 5, 6, 7]
    for row in rows[:2]:
        check_document(row["holes"][0], read_mesh(mesh))
        assert len(row["holes"][0]["fills"]) == 3
    for row, word in zip(rows[2:], ("99999", "nowhere", "mesh", "JSON"), strict=True):
        assert word in row["error"]
    assert "6 questions" in result.err


def write_tube(path: Path, n: int) -> Path:
    """A tube of n quads around, one high."""
    at = 2 * np.pi * np.arange(n) / n
    ring = np.stack([np.cos(at), np.sin(at)], axis=1)
    points = np.vstack([np.c_[ring, np.full(n, z)] for z in (0.0, 1.0)])
    faces = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    write_mesh(path, PolygonMesh.from_faces(points, faces))
    return path


def test_the_shape_of_fills_is_chosen(learned: Path, tmp_path: Path) -> None:
    tube, out = write_tube(tmp_path / "tube.obj", 12), tmp_path / "out.obj"
    asked = ("holes", tube, "--loop", 12, "-o", out, "--db", learned)
    heights: list[float] = []
    for options in ((), ("--shape", "flat"), ("--shape", "smooth", "--tension", 1)):
        result = run(*asked, *options)
        assert result.code == 0 and (", flat," in result.err) == (len(heights) < 2)
        heights.append(float(read_mesh(out).points[:, 2].max()))
    assert run(*asked, "--shape", "smooth").code == 0
    heights.append(float(read_mesh(out).points[:, 2].max()))
    # A membrane does not leave the plane either.
    np.testing.assert_allclose(heights[:3], 1.0, atol=1e-9)
    assert heights[3] > 1.2
    batch = tmp_path / "questions.jsonl"
    lines = [{"mesh": "tube.obj", "loop": [12]}, {"mesh": "tube.obj", "loop": [12], "ngon": False}]
    batch.write_text("\n".join(json.dumps(line) for line in lines))
    result = run("holes", "--batch", batch, "--ngon", "--db", learned)
    one, other = (json.loads(line)["holes"][0]["fills"] for line in result.out.splitlines())
    assert len(one) == 1 and sorted(one[0]["ngon"]) == list(range(12, 24))
    assert len(other) > 1 and other[0]["ngon"] is None and other[0]["flat"]


def test_ngons_close_odd_holes(learned: Path, tmp_path: Path) -> None:
    tube, out = write_tube(tmp_path / "tube.obj", 7), tmp_path / "out.obj"
    refused = run("holes", tube, "--loop", 7, "-o", out, "--db", learned)
    assert_refused(refused, EXIT_BAD_INPUT, "ngon fills it with one face")
    picture = tmp_path / "out.png"
    asked = ("holes", tube, "--all", "--ngon", "-o", out, "--picture", picture, "--db", learned)
    result = run(*asked)
    assert result.code == 0 and result.err.count("one face of 7 corners") == 2
    assert read_mesh(out).arities().tolist() == [4] * 7 + [7, 7] and picture.exists()


def test_odd_holes_have_ways_out(learned: Path, tmp_path: Path) -> None:
    mesh = read_mesh(HEAD)
    faces = mesh.faces()
    beside = int(find_holes(mesh)[0].edges[0])
    face = int(MeshTopology.of(mesh).face[beside])
    odd = tmp_path / "odd.obj"
    # Half of a quad at the hole is gone, too: 17 edges.
    loop = set(find_holes(mesh)[0].loop.tolist())
    corners = faces[face]
    k = next(k for k in range(4) if corners[k] in loop and corners[k - 1] in loop)
    faces[face] = [corners[k], corners[(k + 1) % 4], corners[(k + 2) % 4]]
    write_mesh(odd, PolygonMesh.from_faces(mesh.points, faces))
    result = run("holes", odd, "--loop", NOSE, "-o", tmp_path / "out.obj", "--db", learned)
    assert_refused(result, EXIT_BAD_INPUT, "odd number")
    assert not (tmp_path / "out.obj").exists()
    for kind in ("triangle", "edge-loop", "split", "merge"):
        output = tmp_path / f"{kind}.obj"
        result = run("holes", odd, "--loop", NOSE, "--odd", kind, "-o", output, "--db", learned)
        assert result.code == 0 and "made even" in result.err
        assert len(find_holes(read_mesh(output))) == 2
    result = run("holes", odd, "--all", "-o", tmp_path / "all.obj", "--db", learned)
    assert result.code == 0 and "left open: the hole of 17 edges" in result.err
    assert "ways out that --odd takes: triangle, edge-loop, split, merge" in result.err
    for names in (["--all"], ["--loop", NOSE, "--loop", NECK, "--loop", CHEEK]):
        output = tmp_path / "closed.obj"
        result = run("holes", odd, *names, "--odd", "edge-loop", "-o", output, "--db", learned)
        assert result.code == 0 and result.err.count("made even") == 1
        assert "left open" not in result.err and find_holes(read_mesh(output)) == []


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ((), EXIT_USAGE, "name a mesh"),
        ((HEAD, "--loop", "1", "--faces", "2"), EXIT_USAGE, "exclude"),
        ((HEAD, "--shape", "round"), EXIT_USAGE, "'auto', 'flat', 'smooth'"),
        ((HEAD, "--tension", "1.5"), EXIT_USAGE, "0.0<=x<=1.0"),
        ((HEAD, "--tension", "nan"), EXIT_USAGE, "from 0 to 1"),
        ((HEAD, "--shape", "flat", "--tension", "0.5"), EXIT_USAGE, "no tension"),
        ((HEAD, "--shape", "flat", "--surface", HEAD), EXIT_USAGE, "--surface"),
        ((HEAD, "--ngon", "--shape", "smooth"), EXIT_USAGE, "no new vertices"),
        ((HEAD, "--ngon", "--odd", "split"), EXIT_USAGE, "no quads"),
        ((HEAD, "--all", "--rank", "2"), EXIT_USAGE, "--all takes the best"),
        ((HEAD, "--loop", "5-2"), EXIT_USAGE, "runs backwards"),
        ((HEAD, "--loop", "36", "--loop", "475", "--rank", "2"), EXIT_USAGE, "the best fill of"),
        ((HEAD, "--loop", "36,475"), EXIT_BAD_INPUT, "name each hole by itself"),
        ((HEAD, "--loop", "36,300"), EXIT_BAD_INPUT, "through vertex 300"),
        ((HEAD, "--loop", "x"), EXIT_USAGE, "3,17,20-25"),
        ((HEAD, "--corners", "3:7"), EXIT_USAGE, "1 to 4 quads"),
        ((HEAD, "--flow", "3"), EXIT_USAGE, "strand"),
        ((HEAD, "--limit", "2"), EXIT_BAD_INPUT, "3 border loops"),
        ((HEAD, "--faces", "99999"), EXIT_BAD_INPUT, "not in the mesh"),
        ((HEAD, "--loop", NOSE, "--rank", "9999"), EXIT_NOTHING, "no fill 9999"),
    ],
)
def test_what_is_refused(
    learned: Path, arguments: tuple[object, ...], code: int, words: str
) -> None:
    assert_refused(run("holes", *arguments, "--db", learned), code, words)


def test_a_closed_mesh_has_no_holes() -> None:
    result = run("holes", CHECKOUT / "examples" / "dog.obj")
    assert result.code == EXIT_NOTHING and "the mesh is closed" in result.err
    every = run("holes", CHECKOUT / "examples" / "dog.obj", "--all")
    assert every.code == EXIT_NOTHING and "the mesh is closed" in every.err


def test_flaws_of_a_mesh_are_told_with_its_holes(learned: Path, tmp_path: Path) -> None:
    head, path, output = read_mesh(HEAD), tmp_path / "turned.obj", tmp_path / "filled.obj"
    faces = head.faces()
    faces[7] = faces[7][::-1]
    write_mesh(path, (head.points, faces))
    words = "1 face is turned against the others of the same part, such as face 7"
    listed = run("holes", path)
    assert listed.code == 0 and words in listed.err and words not in listed.out
    assert listed.out == run("holes", HEAD).out and "turned" not in run("holes", HEAD).err
    assert words in run("holes", path, "--json").document()["notes"][0]
    filled = run("holes", path, "--loop", NOSE, "-o", output, "--db", learned, "--json")
    assert words in filled.err and words in filled.document()["notes"][0]
    points = head.points[head.corners]
    write_mesh(path, (points, [*zip(*[iter(range(len(points)))] * 4, strict=True)]))
    for options in ((), ("--all",), ("--loop", "3")):
        assert_refused(run("holes", path, *options), EXIT_BAD_INPUT, "the mesh is a soup")


def test_another_program_reads_the_filled_mesh_as_the_same_quads(
    learned: Path, tmp_path: Path
) -> None:
    trimesh = pytest.importorskip("trimesh")
    output = tmp_path / "filled.obj"
    assert run("holes", HEAD, "--all", "-o", output, "--db", learned).code == 0
    mesh = trimesh.load(output, process=False)
    # trimesh cuts each quad in two; a closed mesh, all faces turned alike.
    ours = read_mesh(output)
    assert (ours.arities() == 4).all() and len(mesh.faces) == 2 * ours.n_faces
    assert mesh.is_watertight and mesh.is_winding_consistent
