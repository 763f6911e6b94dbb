"""The service answers as the library and the command line do, whole and line by line."""

from __future__ import annotations

import json
import math
from typing import Any

import httpx
import numpy as np
import pytest
from click.testing import CliRunner

import patterndb
from patterndb import Boundary, Stroke
from patterndb_app.cli import cli
from query.engine import PatternSource
from query.holes.options import LEAST_TENSION, MOST_TENSION, SHAPES
from tests.support.service.servedhere import ServedHere, wait_until
from tests.support.shared import EXAMPLES

NDJSON = {"Accept": "application/x-ndjson"}

#: Questions: the body, and the options of the command line that ask the same.
QUESTIONS: tuple[tuple[dict[str, Any], tuple[str, ...]], ...] = (
    ({"sides": [3, 5, 4, 6]}, ("--sides=3,5,4,6",)),
    (
        {"sides": [5, 4, 6, 5], "strokes": [[[0, 2], [2, 3]]], "loops": 1, "limit": 7},
        ("--sides=5,4,6,5", "--flow=0:2-2:3", "--loop", "--limit=7"),
    ),
    (
        {
            "sides": [6, 2, 4, 4, 2, 4],
            "corners": ["c", "c", "c", "r", "c", "c"],
            "order": "regular",
            "per_pattern": 1,
            "valence": [3, 5],
            "max_irregular": 4,
        },
        (
            "--sides=6,2,4,4,2,4",
            "--corners=c,c,c,r,c,c",
            "--order=regular",
            "--per-pattern=1",
            "--valence=3..5",
            "--max-irregular=4",
        ),
    ),
    ({"sides": [8], "corners": [], "strict": True}, ("--sides=8", "--closed", "--strict")),
)


def read_lines(text: str) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    *fills, last = [json.loads(line) for line in text.splitlines()]
    return fills, last


@pytest.mark.parametrize(("body", "options"), QUESTIONS)
def test_the_same_question_has_the_same_list(
    starter: ServedHere, source: PatternSource, body: dict[str, Any], options: tuple[str, ...]
) -> None:
    whole = starter.http.post("/v1/fills", json=body).json()
    lines, last = read_lines(starter.http.post("/v1/fills", json=body, headers=NDJSON).text)
    assert whole["fills"] == lines and lines
    assert last.pop("done") is True
    for name in ("sides", "corners", "truncated", "stopped", "reason"):
        assert whole[name] == last[name]
    keywords = {k: v for k, v in body.items() if k not in ("sides", "corners", "strokes", "loops")}
    kinds = {"c": "convex", "r": "reflex"}
    corners = [kinds[kind] for kind in body["corners"]] if "corners" in body else None
    strokes = [Stroke(tuple(a), tuple(b)) for a, b in body.get("strokes", ())]  # type: ignore
    strokes += [Stroke.loop()] * body.get("loops", 0)
    boundary = Boundary(body["sides"], corners)  # type: ignore
    if "valence" in keywords:
        keywords["valence"] = tuple(keywords["valence"])
    found = source.fills(boundary, strokes=strokes, **keywords)
    assert [fill.to_json() for fill in found] == lines
    assert found.truncated == whole["truncated"]
    for more in ((), ("--server", starter.url)):
        result = CliRunner().invoke(cli, ["query", *options, "--json", "--flat", *more])
        assert result.exit_code == 0 and json.loads(result.stdout)["fills"] == lines
    with patterndb.connect(starter.url) as remote:
        again = remote.fills(boundary, strokes=strokes, **keywords)
        assert [fill.to_json() for fill in again] == lines
        assert (again.truncated, again.stopped) == (whole["truncated"], whole["stopped"])


@pytest.mark.parametrize("lengths", [(8,), (10,), (3, 5), (4, 6)])
def test_the_client_takes_fills_with_a_widened_polychord_that_crosses_itself(
    starter: ServedHere, source: PatternSource, lengths: tuple[int, ...]
) -> None:
    boundary = Boundary(lengths)
    here = [fill.to_json() for fill in source.fills(boundary, limit=20)]
    with patterndb.connect(starter.url) as remote:
        assert [fill.to_json() for fill in remote.fills(boundary, limit=20)] == here


TRIANGLE: dict[str, Any] = {
    "sides": [[[0, 0], [4, 0]], [[4, 0], [4, 3]], [[4, 3], [0, 0]]],
    "lengths": [4, 3, 5],
    "strokes": [[[2, 0], [2, 1.5]]],
    "limit": 3,
}


def test_fills_of_points_are_placed(starter: ServedHere, source: PatternSource) -> None:
    answer = starter.http.post("/v1/fills", json=TRIANGLE).json()
    sides = [np.array(side, float) for side in TRIANGLE["sides"]]
    boundary = Boundary.from_polylines(sides, lengths=TRIANGLE["lengths"])
    stroke = Stroke.drawn(boundary, TRIANGLE["strokes"][0])
    expected = list(source.fills(boundary, strokes=[stroke], limit=3))
    assert len(answer["fills"]) == 3
    assert boundary.points is not None
    for told, fill in zip(answer["fills"], expected, strict=True):
        placement = fill.place(boundary.points, None, [stroke])
        assert told == {
            **fill.to_json(),
            "placed": placement.vertices.tolist(),
            **placement.to_json(),
        }
    bare = starter.http.post("/v1/fills", json={**TRIANGLE, "place": False}).json()
    assert bare["fills"] == [fill.to_json() for fill in expected]
    with patterndb.connect(starter.url) as remote:
        found = remote.fills(boundary, strokes=[stroke], limit=3, place=True)
        assert [fill.to_json() for fill in found] == bare["fills"]
        assert np.allclose(found.placed[0], answer["fills"][0]["placed"], atol=0, rtol=0)


def test_fills_lie_on_a_surface_that_was_sent(starter: ServedHere) -> None:
    mesh = EXAMPLES / "jug.obj"
    kept = starter.http.post("/v1/surfaces", content=mesh.read_bytes()).json()
    assert kept["n_faces"] == patterndb.read(mesh).n_faces
    form = starter.http.post("/v1/surfaces", files={"file": ("jug.obj", mesh.read_bytes())})
    assert form.json()["id"] == kept["id"]
    points = patterndb.read(mesh).points
    face = patterndb.read(mesh).faces()[0]
    corners = points[face].tolist()
    question = {
        "sides": [[corners[i], corners[(i + 1) % 4]] for i in range(4)],
        "lengths": [2, 2, 2, 2],
        "limit": 1,
        "surface": kept["id"],
    }
    (fill,) = starter.http.post("/v1/fills", json=question).json()["fills"]
    assert fill["off_surface"] < 1e-6 and len(fill["placed"]) == fill["n_vertices"]
    gone = starter.http.post("/v1/fills", json={**question, "surface": "0" * 64})
    assert gone.status_code == 404 and "/v1/surfaces" in gone.json()["error"]


@pytest.mark.parametrize(
    ("body", "status", "word"),
    [
        (b"", 400, "empty"),
        (b"[1, 2]", 400, "an object"),
        (b'{"sides": [3, 5, 4, 6], "limt": 3}', 400, "limt"),
        (b'{"sides": [3, 5, 4, 6], "limit": "3"}', 400, "limit"),
        (b'{"sides": [3, 5, 4, 6], "limit": 1e999}', 400, "limit"),
        (b'{"sides": [3, 5, 4, 6], "limit": 100000}', 413, "limit"),
        (b'{"sides": [3, 5, 4, 6], "order": "best"}', 400, "order"),
        (b'{"sides": [3, 5, 4, 6], "db": "other"}', 404, "starter"),
        (b'{"sides": [3, 5, 4, 7]}', 422, "odd"),
        (b'{"sides": [1e300, 5, 4, 7]}', 422, "perimeter"),
        (b'{"sides": [3, 5, 4, 6], "strokes": [[[0, 1], [7, 1]]]}', 422, "side 7"),
        (b'{"sides": [3, 5, 4, 6], "surface": "' + b"0" * 64 + b'"}', 422, "points"),
        (b'{"sides": ' + b"[" * 5000 + b"]" * 5000 + b"}", 413, "nested"),
        (b'{"sides": [' + b"1," * 30 + b"1]}", 413, "sides"),
        (b'{"sides": [4, 4, 4, 4], "loops": 100000000}', 413, "loops"),
        (b'{"sides": [3, 5, 4, 6], "sides": [1]}', 400, "twice"),
    ],
)
@pytest.mark.parametrize("headers", [{}, NDJSON], ids=["whole", "lines"])
def test_what_is_no_question_is_refused(
    starter: ServedHere, body: bytes, status: int, word: str, headers: dict[str, str]
) -> None:
    refused = starter.http.post("/v1/fills", content=body, headers=headers)
    document = refused.json()
    assert refused.status_code == status == document["status"], document
    assert document["ok"] is False and document["errors"][0] == document["error"]
    assert word in document["error"]


def test_pages_of_patterns_hold_each_once_in_order(
    starter: ServedHere, source: patterndb.Database
) -> None:
    seen: list[dict[str, Any]] = []
    cursor = last = ""
    while True:
        page = starter.http.get(f"/v1/patterns?sides=5&max_irregular=3&limit=9{cursor}").json()
        seen += page["patterns"]
        if page["next"] is None:
            break
        last = cursor = f"&cursor={page['next']}"
    held = source.pattern_class(5)
    rows = np.flatnonzero(held.n_irregular <= 3)
    assert len(seen) == page["total"] == len(rows)
    expected = sorted((-int(held.frequency[r]), int(held.ids[r])) for r in rows)
    assert [(-one["frequency"], int(one["id"], 16)) for one in seen] == expected
    other = starter.http.get(f"/v1/patterns?order=quads&sides=5{last}")
    assert other.status_code == 400


def test_a_pattern_is_told_with_its_polychords_and_drawn(starter: ServedHere) -> None:
    (listed,) = starter.http.get("/v1/patterns?sides=5&limit=1").json()["patterns"]
    told = starter.http.get(f"/v1/patterns/{listed['id']}").json()
    assert {name: told[name] for name in listed} == listed
    passed = [quad for chord in told["polychords"] for quad in chord]
    assert sorted(set(passed)) == list(range(told["n_quads"]))
    assert len(told["vertices"]) == 1 + max(max(quad) for quad in told["quads"])
    assert sum(one["count"] for one in told["occurrences"]) == told["frequency"]
    drawn = starter.http.get(listed["svg"])
    assert drawn.headers["content-type"] == "image/svg+xml" and drawn.text.startswith("<?xml")
    again = starter.http.get(listed["svg"], headers={"If-None-Match": drawn.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    head = starter.http.head(listed["svg"])
    assert head.status_code == 200 and head.content == b"" and head.headers["etag"]
    picture = starter.http.get(listed["svg"].replace(".svg", ".png"))
    assert picture.content.startswith(b"\x89PNG")


def test_a_hole_is_filled_as_the_library_fills_it(starter: ServedHere, source: object) -> None:
    n = 5
    points = [[x, y, 0] for y in range(n) for x in range(n)]
    faces = [
        [y * n + x, y * n + x + 1, (y + 1) * n + x + 1, (y + 1) * n + x]
        for y in range(n - 1)
        for x in range(n - 1)
        if not (x in (1, 2) and y in (1, 2))
    ]
    mesh = {"points": points, "faces": faces}
    listed = starter.http.post("/v1/holes", json={"mesh": mesh, "list": True}).json()["holes"]
    assert [hole["edges"] for hole in listed] == [8, 16]
    question = {"mesh": mesh, "loop": [listed[0]["loop"][0]], "limit": 2, "weld": 1}
    answer = starter.http.post("/v1/holes", json=question).json()
    polygons = patterndb.PolygonMesh.from_faces(points, faces)
    hole = polygons.hole(loop=question["loop"])
    found = hole.fills(source, limit=2)  # type: ignore
    expected = [fill.to_json() for fill in found]
    assert answer["holes"][0]["fills"] == expected
    assert len(answer["mesh"]["faces"]) == len(faces) + len(expected[0]["quads"])
    unnamed = starter.http.post("/v1/holes", json={"mesh": mesh})
    assert unnamed.status_code == 422 and "name a vertex" in unnamed.json()["error"]
    assert answer["notes"] == []


def test_flaws_of_a_mesh_come_with_its_holes_or_refuse_them(starter: ServedHere) -> None:
    points = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    cube = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]

    def ask(points: list[list[int]], faces: list[list[int]], **more: object) -> httpx.Response:
        mesh = {"points": points, "faces": faces}
        return starter.http.post("/v1/holes", json={"mesh": mesh, **more})

    listed = ask(points, cube, list=True).json()
    assert listed["holes"] == [] and "the mesh is closed" in listed["notes"][0]
    closed = ask(points, cube)
    assert closed.status_code == 422 and "the mesh is closed" in closed.json()["error"]
    turned = ask(points, [*cube[1:4], cube[4][::-1]], list=True).json()
    assert "1 face is turned" in turned["notes"][0] and turned["holes"]
    fin = [[0, 0, 2], [0, 1, 2]]
    crowded = ask([*points, *fin], [*cube, [1, 3, 9, 8]], list=True)
    assert crowded.status_code == 422 and "1-3 (3 faces" in crowded.json()["error"]
    corners = [points[v] for face in cube for v in face]
    soup = ask(corners, [[*range(k, k + 4)] for k in range(0, 24, 4)], list=True)
    assert soup.status_code == 422 and "the mesh is a soup" in soup.json()["error"]


def test_a_mesh_in_a_body_may_have_a_large_face(starter: ServedHere) -> None:
    n = 500
    ring = [[math.cos(2 * math.pi * k / n), math.sin(2 * math.pi * k / n)] for k in range(n)]
    points = [[x, y, z] for z in (0.0, 1.0) for x, y in ring]
    sides = [[k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n) if k > 1]
    faces = [[*range(n)][::-1], [*range(n, 2 * n)], *sides]
    asked: dict[str, Any] = {"mesh": {"points": points, "faces": faces}, "list": True}
    (hole,) = starter.http.post("/v1/holes", json=asked).json()["holes"]
    assert hole["edges"] == 6
    asked["mesh"]["faces"][0] = [0] * 100_001
    refused = starter.http.post("/v1/holes", json=asked)
    assert refused.status_code == 400 and "100,000" in refused.json()["error"]


def test_a_fill_lies_as_it_is_asked_to(starter: ServedHere, source: object) -> None:
    n = 8
    at = 2 * np.pi * np.arange(n) / n
    points = [[float(np.cos(t)), float(np.sin(t)), z] for z in (0.0, 1.0) for t in at]
    faces = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    mesh, polygons = {"points": points, "faces": faces}, patterndb.PolygonMesh.from_faces
    listed = starter.http.get("/v1/shapes").json()
    assert [shape["name"] for shape in listed["shapes"]] == list(SHAPES)
    assert listed["tension"] == [LEAST_TENSION, MOST_TENSION]
    asked: tuple[dict[str, Any], ...] = (
        {},
        {"shape": "flat"},
        {"shape": "smooth", "tension": 0.25},
        {"ngon": True},
    )
    for options in asked:
        question = {"mesh": mesh, "loop": [n], "limit": 2, "weld": 1, **options}
        answer = starter.http.post("/v1/holes", json=question).json()
        hole = polygons(points, faces).hole(loop=[n])
        found = hole.fills(source, limit=2, **options)  # type: ignore
        fills = answer["holes"][0]["fills"]
        assert fills == [fill.to_json() for fill in found]
        last = fills[0]["ngon"] if "ngon" in options else fills[0]["quads"][-1]
        assert answer["mesh"]["faces"][-1] == last
    for options, word in (
        ({"shape": "round"}, "shape"),
        ({"tension": 2}, "tension: 2 is not a number from 0 to 1"),
        ({"shape": "flat", "tension": 0.5}, "no tension"),
    ):
        refused = starter.http.post("/v1/holes", json={"mesh": mesh, "loop": [n], **options})
        assert refused.status_code == 400 and word in refused.json()["error"]


def test_who_closes_a_stream_ends_the_search(starter: ServedHere) -> None:
    long = {"sides": [40, 40, 40, 40, 40, 40], "limit": 1000}
    with starter.http.stream("POST", "/v1/fills", json=long, headers=NDJSON) as stream:
        lines = stream.iter_lines()  # Held, for an iterator that is dropped closes the stream.
        next(lines)
        # What was asked before may be ending yet; this one does not, for nobody reads on.
        wait_until(lambda: starter.service.workers.at_work == 1)
    wait_until(lambda: starter.service.workers.at_work == 0)
    with patterndb.connect(starter.url) as remote:
        found = remote.fills((40, 40, 40, 40, 40, 40), limit=1000)
        next(found)
        found.cancel()
        assert list(found) == [] and found.stopped == "cancelled" and found.truncated
    wait_until(lambda: starter.service.workers.at_work == 0)


def test_a_time_limit_ends_a_list_with_its_last_line(starter: ServedHere) -> None:
    long = {"sides": [40, 40, 40, 40, 40, 40], "limit": 1000, "time_limit": 0.2}
    fills, last = read_lines(starter.http.post("/v1/fills", json=long, headers=NDJSON).text)
    assert fills and last["done"] and last["truncated"] and last["stopped"] == "time limit"
