"""patterndb retopo: scripts and sessions in, quad meshes out."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from ingest.formats import read_mesh
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.session import RETOPO_SESSION
from tests.support.cli.commandline import assert_refused, run
from viewer.retopo.pointing import VIEW_SIDES

LOOPS = (
    {"tool": "loop", "at": [1, 0.02, 0], "normal": [0, 0, 1]},
    {"tool": "loop", "at": [0, 1, 0.02], "normal": [1, 0, 0]},
    {"tool": "loop", "at": [0.02, 0, 1], "normal": [0, 1, 0]},
)


@pytest.fixture
def ball(tmp_path: Path) -> Path:
    """The unit sphere, as a file."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    return write_triangles(tmp_path / "ball.obj", mesh.vertices, mesh.faces)


def write_triangles(path: Path, vertices: np.ndarray, faces: np.ndarray) -> Path:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def script(path: Path, *calls: dict[str, Any], surface: str = "ball.obj") -> Path:
    lines = [{"tool": "open", "surface": surface}, *calls]
    path.write_text("\n".join(map(json.dumps, lines)))
    return path


def faces(path: Path) -> list[list[int]]:
    mesh = read_mesh(path)
    return [mesh.corners[a:b].tolist() for a, b in np.c_[mesh.offsets[:-1], mesh.offsets[1:]]]


def document(*arguments: object, code: int = 0) -> dict[str, Any]:
    result = run("retopo", *arguments, "--json")
    assert result.code == code, result.err
    return result.document()


def assert_closed(quads: Sequence[Sequence[int]]) -> None:
    """Every edge is passed once each way."""
    edges = [(q[k - 1], q[k]) for q in quads for k in range(4)]
    assert len(set(edges)) == len(edges)
    assert {(b, a) for a, b in edges} == set(edges)


def test_a_script_makes_the_mesh_that_is_told(ball: Path, tmp_path: Path) -> None:
    half = {"tool": "export", "mesh": "first.obj"}
    played = script(tmp_path / "ball.jsonl", *LOOPS, half, {"tool": "recount", "edge": 0.2})
    output = tmp_path / "out.obj"
    told = document("--script", played, "-o", output)
    quads = faces(output)
    assert {len(quad) for quad in quads} == {4}
    assert_closed(quads)
    assert told["quads"] == len(quads)
    assert told["vertices"] == len(read_mesh(output).points) == len(quads) + 2
    assert (told["surface"], told["triangles"], told["calls"]) == (str(ball), 1280, 5)
    assert (told["patches"], told["unfilled"], told["refused"]) == ({"3": 8}, 0, [])
    assert (told["open_edges"], told["tangled"], told["flipped"], told["euler"]) == (0, 0, 0, 2)
    assert told["irregular"]["3"] == 8, "one in each octant"
    assert told["open_loops"] == []
    assert 0.0 < told["to_surface"] < told["from_surface"] < 0.01
    assert told["output"] == str(output)
    # Exported beside the script, before the recount.
    first = faces(tmp_path / "first.obj")
    assert_closed(first)
    assert len(first) > len(quads)
    text = output.read_text()
    assert text.startswith(f"# quad mesh: {len(quads)} quads in 8 patches\n")
    assert text.count("\ng patch_") == 8


@pytest.mark.parametrize("name", ["a\0b.obj", "\ud800.obj", "below/\0"])
def test_a_name_that_no_file_can_have_is_told(ball: Path, tmp_path: Path, name: str) -> None:
    played = script(tmp_path / "ball.jsonl", *LOOPS, {"tool": "export", "mesh": name})
    result = run("retopo", ball, "--script", played, "-o", tmp_path / "out.obj")
    assert result.code == 3 and "Traceback" not in result.err and "unforeseen" not in result.err


@pytest.mark.parametrize("way", ["above", "absolute", "link", "linked folder"])
def test_a_script_writes_beside_itself_and_below_alone(
    ball: Path, tmp_path: Path, way: str
) -> None:
    folder, outside = tmp_path / "scripts", tmp_path / "outside"
    folder.mkdir()
    outside.mkdir()
    (folder / "link.obj").symlink_to(outside / "stolen.obj")
    (folder / "linked").symlink_to(outside)
    name = {
        "above": "../outside/stolen.obj",
        "absolute": str(outside / "stolen.obj"),
        "link": "link.obj",
        "linked folder": "linked/stolen.obj",
    }[way]
    played = script(folder / "ball.jsonl", *LOOPS, {"tool": "export", "mesh": name})
    result = run("retopo", ball, "--script", played, "-o", tmp_path / "out.obj")
    assert_refused(result, 3, name, "not beside the script", "--exports-anywhere")
    assert list(outside.iterdir()) == [] and not (tmp_path / "out.obj").exists()
    trusted = run("retopo", ball, "--script", played, "--exports-anywhere")
    assert trusted.code == 0 and (outside / "stolen.obj").is_file()
    assert "written: " in trusted.err


def test_the_table_says_what_the_json_says(ball: Path, tmp_path: Path) -> None:
    played = script(tmp_path / "ball.jsonl", *LOOPS)
    told = document("--script", played)
    result = run("retopo", ball, "--script", played)
    assert result.code == 0
    rows = dict(
        line.split(None, 1) for line in result.out.splitlines()[1:] if "surface" not in line
    )
    assert rows["patches"] == "8 with 3"
    assert rows["quads"] == f"{told['quads']:,}"
    assert rows["flipped"] == "0"
    assert "ball.obj: 1,280 triangles" in result.err


def test_a_session_goes_on_where_it_ended(ball: Path, tmp_path: Path) -> None:
    """In two runs, the second from the session of the first, as in one."""
    more = {"tool": "stroke", "points": [[1, 0, 1], [1, 0.5, 0.9], [0, 1, 1]]}
    whole = script(tmp_path / "whole.jsonl", *LOOPS, more)
    one, two = script(tmp_path / "one.jsonl", *LOOPS), script(tmp_path / "two.jsonl", more)
    session, outputs = tmp_path / "ball.retopo", [tmp_path / f"{k}.obj" for k in range(3)]
    document("--script", whole, "-o", outputs[0])
    told = document("--script", one, "--session", session)
    assert told["session"] == str(session)
    assert RETOPO_SESSION.read(session).name == "ball.obj"
    told = document("--script", two, "--session", session, "-o", outputs[1])
    assert told["patches"] == {"3": 7, "4": 1} or sum(told["patches"].values()) == 9
    assert outputs[1].read_bytes() == outputs[0].read_bytes()
    # And the mesh of the session, for which nothing else is needed.
    ball.unlink()
    saved = session.read_bytes()
    told = document("--session", session, "-o", outputs[2])
    assert (told["surface"], told["calls"]) == ("ball.obj", 0)
    assert outputs[2].read_bytes() == outputs[0].read_bytes()
    assert session.read_bytes() == saved


def test_a_refused_call_ends_the_script_and_leaves_the_session(ball: Path, tmp_path: Path) -> None:
    session, output = tmp_path / "ball.retopo", tmp_path / "out.obj"
    knot = {"tool": "knot", "at": [0.6, 0.6, 0.6]}
    document("--script", script(tmp_path / "a.jsonl", *LOOPS), "--session", session)
    saved = session.read_bytes()
    ring = {"tool": "loop", "at": [1, 0, 0.3], "normal": [0, 0, 1]}
    played = script(tmp_path / "b.jsonl", ring, knot)
    result = run("retopo", "--script", played, "--session", session, "-o", output)
    assert_refused(result, 3, "line 3: knot: nothing is within the circle")
    assert session.read_bytes() == saved
    assert not output.exists()
    told = document("--script", played, "--session", session, "--lenient")
    ((line, tool, why),) = [one.values() for one in told["refused"]]
    assert (line, tool) == (3, "knot")
    assert why.startswith("nothing is within the circle")
    assert session.read_bytes() != saved


def test_nothing_drawn_is_nothing_found(ball: Path, tmp_path: Path) -> None:
    told = document("--script", script(tmp_path / "a.jsonl"), code=1)
    assert (told["patches"], told["quads"], told["to_surface"]) == ({}, 0, 1.0)
    told = document("--script", script(tmp_path / "b.jsonl", LOOPS[0]), code=1)
    one, other = told["open_loops"]
    assert (one["corners"], other["corners"]) == (0, 0)
    # Each side of the equator once: they run opposite ways.
    steps = [np.subtract(loop["towards"], loop["at"]) for loop in (one, other)]
    sides = [np.cross(loop["at"], step)[2] for loop, step in zip((one, other), steps, strict=True)]
    assert sides[0] * sides[1] < 0.0


def test_a_session_that_is_there_is_opened_whether_its_surface_is_named_or_not(
    ball: Path, tmp_path: Path
) -> None:
    session, outputs = tmp_path / "a.retopo", [tmp_path / f"{k}.obj" for k in range(2)]
    played = script(tmp_path / "a.jsonl", *LOOPS)
    document(ball, "--script", played, "--session", session)
    kept = session.read_bytes()
    for output, named in zip(outputs, ([ball], []), strict=True):
        run("retopo", *named, "--session", session, "-o", output, "--json")
    assert outputs[0].read_bytes() == outputs[1].read_bytes()
    assert session.read_bytes() == kept
    other = tmp_path / "other.obj"
    other.write_text(ball.read_text().replace("v -0.5257", "v -0.6257", 1))
    result = run("retopo", other, "--session", session, "-o", outputs[0], "--json")
    assert_refused(result, 3, "other.obj is not the surface of", "ball.obj", "leave SURFACE out")


def test_a_session_that_another_changed_meanwhile_is_not_replaced(
    ball: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from patterndb_sketch.retopo.editor import Retopology

    session = tmp_path / "a.retopo"
    played = script(tmp_path / "a.jsonl", *LOOPS)
    document(ball, "--script", played, "--session", session)
    more = script(tmp_path / "b.jsonl", *LOOPS[:1])
    fill = Retopology.fill

    def meanwhile(self: Retopology) -> object:
        session.write_bytes(b"another's")
        return fill(self)

    monkeypatch.setattr(Retopology, "fill", meanwhile)
    result = run("retopo", "--script", more, "--session", session, "--lenient", "--json")
    assert_refused(result, 3, "has changed since", "reload it", "another file", "overwrite it")
    assert session.read_bytes() == b"another's"


@pytest.mark.usefixtures("screen")
def test_options_that_do_not_go_together_are_usage_errors(ball: Path, tmp_path: Path) -> None:
    session = tmp_path / "a.retopo"
    played = script(tmp_path / "a.jsonl", *LOOPS)
    assert_refused(run("retopo"), 2, "nothing to draw on: give a SURFACE", "no session is given")
    assert_refused(run("retopo", "--session", session), 2, "nothing to draw on", "there is no")
    assert_refused(run("retopo", ball, "--view", "--json"), 2, "leave it or --view out")
    assert_refused(run("retopo", ball, "--lenient", "--json"), 2, "give a --script")
    wrong = tmp_path / "a.zip"
    assert_refused(run("retopo", "--script", played, "--session", wrong), 2, "must end in .retopo")
    document("--script", played, "--session", session)
    assert_refused(run("retopo", "--session", session, "--lenient"), 2, "give a --script")
    result = run("retopo", "--session", session, "--from-quads", "--json")
    assert_refused(result, 2, "has begun already; leave --from-quads out")
    record = tmp_path / "r.jsonl"
    result = run("retopo", "--session", session, "--record", record)
    assert_refused(result, 2, "leave --record out")


def test_bad_files_are_said_by_name(ball: Path, tmp_path: Path) -> None:
    session = tmp_path / "a.retopo"
    played = script(tmp_path / "a.jsonl", *LOOPS)
    session.write_bytes(b"hello")
    result = run("retopo", "--session", session, "--json")
    assert_refused(result, 3, f"{session}: this is not a session of retopology")
    session.unlink()
    document("--script", played, "--session", session)
    mesh = trimesh.creation.icosphere(subdivisions=2)
    write_triangles(tmp_path / "other.obj", mesh.vertices, mesh.faces)
    other = script(tmp_path / "b.jsonl", surface="other.obj")
    result = run("retopo", "--script", other, "--session", session)
    assert_refused(result, 3, "other.obj, is not the session's, ball.obj")
    missing = script(tmp_path / "c.jsonl", surface="none.obj")
    assert_refused(run("retopo", "--script", missing), 3, "there is no none.obj, neither beside")
    unknown = script(tmp_path / "d.jsonl", {"tool": "strike"})
    result = run("retopo", "--script", unknown)
    assert_refused(result, 3, "line 2: there is no tool 'strike'; there are stroke,")


def test_what_a_crash_left_is_told(ball: Path, tmp_path: Path) -> None:
    session = tmp_path / "a.retopo"
    played = script(tmp_path / "a.jsonl", *LOOPS)
    document("--script", played, "--session", session)
    recovery = tmp_path / f"a.retopo.{10**30}-0f.recovery"
    recovery.write_bytes(session.read_bytes())
    result = run("retopo", "--session", session, "--json")
    assert result.code == 0
    assert f"a crash left work on this session: {recovery}" in result.err


def test_symmetry_gives_both_halves(ball: Path, tmp_path: Path) -> None:
    half = [{"tool": "symmetry"}, LOOPS[0], LOOPS[2]]
    output = tmp_path / "out.obj"
    told = document("--script", script(tmp_path / "half.jsonl", *half), "-o", output)
    assert (told["open_edges"], told["euler"]) == (0, 2)
    points = {tuple(p) for p in read_mesh(output).points.tolist()}
    assert points == {(-x if x else 0.0, y, z) for x, y, z in points}
    assert_closed(faces(output))


def test_a_mesh_of_quads_comes_back_as_it_was_and_can_be_edited(ball: Path, tmp_path: Path) -> None:
    """Also through the script that is recorded."""
    first, again = tmp_path / "first.obj", tmp_path / "again.obj"
    document("--script", script(tmp_path / "ball.jsonl", *LOOPS), "-o", first)
    record = tmp_path / "edits.jsonl"
    result = run("retopo", first, "--from-quads", "-o", again, "--record", record)
    assert result.code == 0, result.err
    one, two = read_mesh(first), read_mesh(again)
    assert sorted(map(tuple, one.points.tolist())) == sorted(map(tuple, two.points.tolist()))
    assert len(faces(first)) == len(faces(again))
    text = record.read_text()
    assert text == f'{{"tool": "open", "surface": "{first}", "quads": true}}\n'
    # Curves of the network leave every vertex of three quads.
    corner = one.points[np.argmax(np.bincount(one.corners) == 3)].tolist()
    more = json.dumps({"tool": "subdivide", "at": corner, "by": 2})
    (tmp_path / "more.jsonl").write_text(text + more)
    told = document("--script", tmp_path / "more.jsonl", "-o", again)
    assert told["quads"] > len(faces(first))
    assert_closed(faces(again))


def test_a_few_other_faces_stay_beside_the_quads(tmp_path: Path) -> None:
    """A cube with one face split: counted, written as given, and kept by a session's edits."""
    given, again = tmp_path / "cube.obj", tmp_path / "again.obj"
    corners = [f"v {x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    rows = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8", "2 8 4"]
    given.write_text("\n".join([*corners, *(f"f {row}" for row in rows)]))
    session = tmp_path / "cube.retopo"
    edits = tmp_path / "edits.jsonl"
    edits.write_text(
        json.dumps({"tool": "open", "surface": str(given), "quads": True})
        + "\n"
        + json.dumps({"tool": "recount", "edge": 0.25})
    )
    result = run("retopo", given, "--from-quads", "-o", again, "--json")
    assert result.code == 0, result.err
    told = json.loads(result.out)
    assert (told["quads"], told["kept"], told["open_edges"]) == (5, {"3": 2}, 0)
    assert sorted(map(len, read_mesh(again).faces())) == [3, 3, 4, 4, 4, 4, 4]
    assert "2 faces as given" in again.read_text()
    result = run("retopo", "--script", edits, "--session", session, "-o", again)
    assert result.code == 0, result.err
    assert "2 triangles" in result.out
    result = run("retopo", "--session", session, "-o", again, "--json")
    assert json.loads(result.out)["kept"] == {"3": 2}
    mesh = read_mesh(again)
    kept = [face for face in mesh.faces() if len(face) == 3]
    cut = {tuple(sorted(map(tuple, mesh.points[face].tolist()))) for face in kept}
    assert cut == {
        ((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0)),
        ((0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0)),
    }


def test_triangles_are_no_quads_to_begin_from(ball: Path) -> None:
    result = run("retopo", ball, "--from-quads", "--json")
    assert_refused(result, 3, f"{ball}: 1280 of 1280 faces are not quads")


def test_a_picture_is_drawn_without_a_window(ball: Path, tmp_path: Path) -> None:
    picture = tmp_path / "ball.png"
    result = run("retopo", "--script", script(tmp_path / "a.jsonl", *LOOPS), "--picture", picture)
    assert result.code == 0, result.err
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert f"drawn: {picture}" in result.err


def test_a_picture_has_the_sides_that_are_named(ball: Path, tmp_path: Path) -> None:
    picture = tmp_path / "ball.png"
    common = ("retopo", "--script", script(tmp_path / "a.jsonl", *LOOPS))
    result = run(*common, "--picture", picture, "--sides", "front, top,left")
    assert result.code == 0, result.err
    # Two rows of two, each as large as a picture of one side.
    assert struct.unpack(">II", picture.read_bytes()[16:24]) == (2 * 1200, 2 * 800)
    assert_refused(run(*common, "--picture", picture, "--sides", "front,up"), 2, "no side 'up'")
    assert_refused(run(*common, "--sides", "front"), 2, "give --picture")
    said = " ".join(run("retopo", "--help").out.split())
    assert all(f" {side}" in said for side in VIEW_SIDES)


@pytest.mark.usefixtures("screen")
def test_a_surface_alone_opens_the_window(
    ball: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the window is given; what is done in it reaches the mesh."""
    shown: list[dict[str, object]] = []

    def show(editor: Retopology, **options: object) -> None:
        shown.append(options)
        for call in LOOPS:
            editor.do(Call(str(call["tool"]), {k: v for k, v in call.items() if k != "tool"}))

    monkeypatch.setattr("viewer.retopo.show", show)
    session, record = tmp_path / "a.retopo", tmp_path / "a.jsonl"
    result = run("retopo", ball, "--session", session, "--record", record)
    assert result.code == 0, result.err
    assert shown[0]["title"] == "ball.obj"
    assert (shown[0]["session"], shown[0]["script"]) == (session, record)
    output = tmp_path / "out.obj"
    result = run("retopo", ball, "--view", "-o", output)
    assert result.code == 0, result.err
    assert len(shown) == 2
    assert_closed(faces(output))
