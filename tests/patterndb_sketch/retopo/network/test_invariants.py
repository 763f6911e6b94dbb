"""Triangles and larger faces among quads: imported, kept through edits, and written as given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

import patterndb
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.store import Database
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import find_open_edges, weld_patches
from patterndb_sketch.retopo.filling.report import report_mesh
from patterndb_sketch.retopo.network import BORDER, FACE, check_network
from patterndb_sketch.retopo.network.invariants import lies_within, list_kept_faces
from patterndb_sketch.retopo.quadimport import QuadImport, import_quads
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession
from tests.support.retopo.quadmeshes import Mesh, cube, refined, thirds

Faces = list[tuple[int, ...]]


@pytest.fixture(scope="module")
def source() -> Iterator[Database]:
    with patterndb.open() as database:
        yield database


def split_quads(mesh: Mesh, which: Sequence[int]) -> tuple[Points, Int32Array, Faces]:
    """Some quads as two triangles each."""
    points, quads = mesh
    halves = [half for a, b, c, d in quads[list(which)].tolist() for half in ((a, b, c), (a, c, d))]
    return points, np.delete(quads, list(which), axis=0), halves


def merge_vertex(mesh: Mesh, vertex: int) -> tuple[Points, Int32Array, Faces]:
    """The quads around an inner vertex as one face of twice as many corners."""
    points, quads = mesh
    around = (quads == vertex).any(axis=1)
    after = {a: b for q in quads[around].tolist() for a, b in zip(q, q[1:] + q[:1], strict=True)
             if vertex not in (a, b)}  # fmt: skip
    face = [min(after)]
    while after[face[-1]] != face[0]:
        face.append(after[face[-1]])
    return points, quads[~around], [tuple(face)]


def name_vertices(vertices: Points, points: Points) -> list[int]:
    """The number among points of every vertex, which is one of them bit for bit."""
    number = {point.tobytes(): k for k, point in enumerate(points)}
    return [number[vertex.tobytes()] for vertex in np.ascontiguousarray(vertices)]


def turn_first(face: Sequence[int]) -> tuple[int, ...]:
    """The same face from its lowest vertex on."""
    k = list(face).index(min(face))
    return (*face[k:], *face[:k])


def faces_of(vertices: Points, faces: Sequence[Sequence[int]], points: Points) -> Faces:
    """Faces by numbers of points, in order."""
    name = name_vertices(vertices, points)
    return sorted(turn_first([name[v] for v in face]) for face in faces)


def comes_back(found: QuadImport, points: Points, quads: Int32Array, others: Faces) -> None:
    """The network's invariants hold, and its mesh is the one given, face for face."""
    network = found.network
    check_network(network)
    made = weld_patches(found.filled)
    every = [*made.quads.tolist(), *made.kept]
    assert faces_of(made.vertices, every, points) == sorted(
        map(turn_first, [*map(tuple, quads.tolist()), *others])
    )
    used = {v for face in (*quads.tolist(), *others) for v in face}
    assert sorted(name_vertices(made.vertices, points)) == sorted(used)
    assert found.unused == len(points) - len(used)
    for chain in network.chains.values():
        if FACE in chain.marks:
            assert (chain.count, chain.pinned) == (1, True)
    for patch in network.patches.values():
        assert patch.corners == (0, 1, 2, 3)
        assert len(patch.loop) == 4


def test_a_cube_with_one_face_split_comes_back() -> None:
    points, quads, others = split_quads(cube(1), [2])
    found = import_quads(points, quads, others=others)
    assert len(found.network.patches) == 5
    comes_back(found, points, quads, others)
    made = report_mesh(found.filled, found.surface)
    assert (made.quads, made.kept, made.open_edges, made.euler) == (5, {3: 2}, 0, 2)
    # Two corners of the cube have a fourth face now; the six others three.
    assert made.irregular == {3: 6}
    assert made.to_surface == pytest.approx(0.0, abs=1e-12)
    assert made.from_surface == pytest.approx(0.0, abs=1e-12)


def test_a_pentagon_and_its_triangle_come_back() -> None:
    """A corner of a cube's face cut off: a pentagon beside a triangle, on a border of nothing."""
    points, quads = cube(3)
    at = int(np.flatnonzero((np.isclose(points, [1.0, 1 / 3, 1 / 3])).all(axis=1))[0])
    (row,) = [k for k, q in enumerate(quads.tolist()) if at in q and np.isclose(
        points[q].mean(axis=0), [1.0, 0.5, 0.5]).all()]  # fmt: skip
    a, b, c, d = quads[row].tolist()
    new = len(points)
    all_points = np.concatenate([points, [(points[a] + points[b]) / 2]])
    (beside,) = [
        k for k, q in enumerate(quads.tolist()) if (b, a) in zip(q, q[1:] + q[:1], strict=True)
    ]
    other = quads[beside].tolist()
    j = other.index(b)
    other = other[j:] + other[:j]
    others = [(a, new, b, c, d), (b, new, a, other[2], other[3])]
    rest = np.delete(quads, [row, beside], axis=0)
    found = import_quads(all_points, rest, others=others)
    comes_back(found, all_points, rest, others)
    made = report_mesh(found.filled, found.surface)
    assert (made.quads, made.kept, made.open_edges, made.euler) == (52, {5: 2}, 0, 2)


def test_faces_at_a_border_and_fans_of_triangles_come_back() -> None:
    """A sheet whose corner is a triangle fan, with a vertex that no quad has, and a lone ear."""
    points = np.array([[i, j, 0.0] for i in range(4) for j in range(4)])
    points = np.concatenate([points, [[0.4, 0.5, 0.0], [4.0, 2.5, 0.0]]])
    quads = np.array(
        [
            [4 * i + j, 4 * i + 4 + j, 4 * i + 5 + j, 4 * i + 1 + j]
            for i in range(3)
            for j in range(3)
            if (i, j) != (0, 0)
        ]
    )
    others = [(a, b, 16) for a, b in pairwise((0, 4, 5, 1, 0))] + [(14, 17, 15)]
    found = import_quads(points, quads, others=others)
    comes_back(found, points, quads, others)
    network = found.network
    rim = [chain for chain in network.chains.values() if BORDER in chain.marks]
    assert sum(chain.count for chain in rim) == 13
    assert len(find_open_edges(weld_patches(found.filled))) == 13


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(4, 8), st.integers(0, 1))
def test_any_mesh_with_other_faces_comes_back(seed: int, n: int, level: int) -> None:
    """Hulls of random points in quads; some of these split, one vertex's quads merged."""
    rng = np.random.default_rng(seed)
    hull = trimesh.convex.convex_hull(rng.normal(size=(n, 3)))
    mesh = refined(*thirds(hull.vertices, hull.faces), level)
    points, quads, others = merge_vertex(mesh, int(rng.integers(len(mesh[0]))))
    chosen = np.flatnonzero(rng.random(len(quads)) < rng.choice([0.05, 0.3]))[: len(quads) - 1]
    points, quads, halves = split_quads((points, quads), chosen.tolist())
    others = others + halves
    try:
        found = import_quads(points, quads, others=others)
    except InvalidRetopoError as error:
        # A face around a vertex of a corner may pass another vertex twice, or share two edges.
        assert "repeats a vertex" in str(error) or "edge" in str(error)
        return
    comes_back(found, points, quads, others)


def test_every_tool_leaves_given_faces_as_they_are(source: Database) -> None:
    """Random places for strokes, erasing, pulling, counts, the brush, and all else beside and over
    given faces: these stay, bit for bit, and the mesh stays closed where all patches have quads."""
    ball = trimesh.creation.icosphere(subdivisions=0)
    points, quads = refined(*thirds(ball.vertices, ball.faces), 1)
    points = points / np.linalg.norm(points, axis=1)[:, None]
    points, quads, others = merge_vertex((points, quads), 40)
    points, quads, halves = split_quads((points, quads), [5, 60, 61, 130])
    others += halves
    found = import_quads(points, quads, others=others)
    loops = list_kept_faces(found.network)
    kept = faces_of(points, others, points)
    rng = np.random.default_rng(3)
    middles = np.array([points[list(face)].mean(axis=0) for face in others])
    refused = changed = 0
    editor = Retopology.of_quads(found, source)
    for step in range(80):
        if step % 20 == 0:
            editor = Retopology.of_quads(found, source)
        centre = middles[rng.integers(len(middles))]
        places = (centre + rng.normal(size=(4, 3)) * rng.choice([0.05, 0.25])).tolist()
        at, to = places[:2]
        calls = [
            Call("stroke", {"points": places[: int(rng.integers(2, 5))]}),
            Call("erase", {"at": at}),
            Call("erase", {"points": places}),
            Call("pull", {"at": at, "to": to}),
            Call("brush", {"at": at, "to": to, "radius": 0.3}),
            Call("relax", {"at": at, "radius": 0.3}),
            Call("subdivide", {"at": at, "by": 1, "strip": bool(rng.integers(2))}),
            Call("subdivide", {"at": at, "free": True}),
            Call("recount", {"edge": 0.2}),
            Call("insertloop", {"at": at}),
            Call("knot", {"at": at, "radius": 0.15}),
            Call("corner", {"at": at}),
            Call("corner", {"at": at, "wedge": to}),
            Call("smooth", {"at": at}),
            Call("patch", {"at": at}),
            Call("autocomplete", {"at": at}),
            Call("loop", {"at": at, "normal": rng.normal(size=3).tolist()}),
            Call("choose", {"at": at, "by": 1}),
        ]
        outcome = editor.do(calls[rng.integers(len(calls))])
        refused += outcome.refused is not None
        changed += outcome.changed
        check_network(editor.network, patches=False)
        assert set(list_kept_faces(editor.network)) == set(loops)
        filled = editor.fill()
        made = weld_patches(filled)
        assert faces_of_kept(made.vertices, made.kept, points) == kept
        if filled.placed.keys() == filled.network.patches.keys():
            whole = report_mesh(filled, found.surface, made)
            assert whole.tangled == 0
    assert changed > 20
    assert refused > 5


def faces_of_kept(vertices: Points, faces: Sequence[Sequence[int]], points: Points) -> Faces:
    """As faces_of, where other vertices are no points."""
    number = {point.tobytes(): k for k, point in enumerate(points)}
    return sorted(
        turn_first([number[np.ascontiguousarray(vertices[v]).tobytes()] for v in face])
        for face in faces
    )


def test_a_patch_beside_a_given_face_is_counted_anew_and_stays_joined(source: Database) -> None:
    points, quads, others = split_quads(refined(*cube(2), 1), [0])
    editor = Retopology.of_quads(import_quads(points, quads, others=others), source)
    outcome = editor.do(Call("recount", {"edge": 0.1}))
    assert outcome.changed
    filled = editor.fill()
    made = report_mesh(filled, editor.surface, editor.mesh(filled))
    assert made.unfilled == 0
    assert (made.kept, made.open_edges, made.tangled, made.euler) == ({3: 2}, 0, 0, 2)
    assert made.quads > len(quads)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            Call("stroke", {"points": [[0.6, 0.3, 1.0], [0.8, 0.5, 1.0]]}),
            "in a face that was given",
        ),
        (Call("symmetry", {"axis": "x"}), "2 faces that were given stay as they are"),
        (Call("draft", {"edge": 0.2}), "faces that were given stay"),
        (Call("subdivide", {"at": [0.5, 0.0, 1.0], "count": 3}), "one edge to each side"),
    ],
)
def test_what_would_change_a_given_face_is_refused(
    source: Database, call: Call, message: str
) -> None:
    mesh = cube(1)
    top = int(np.flatnonzero((mesh[0][mesh[1]][:, :, 2] == 1.0).all(axis=1))[0])
    points, quads, others = split_quads(mesh, [top])
    editor = Retopology.of_quads(import_quads(points, quads, others=others), source)
    before = editor.state
    outcome = editor.do(call)
    assert message in (outcome.refused or "")
    assert editor.state is before


def test_given_faces_are_in_sessions() -> None:
    points, quads, others = split_quads(cube(2), [3, 4])
    with patterndb.open() as database:
        editor = Retopology.of_quads(import_quads(points, quads, others=others), database)
        session = RetopoSession(editor.surface, editor.state, "cube")
        again = RETOPO_SESSION.decode(RETOPO_SESSION.encode(session))
        assert again.state.same(editor.state)
        loaded = Retopology(again.surface, database)
        loaded.restore(again.state)
        made = loaded.mesh(loaded.fill())
    assert faces_of(made.vertices, made.kept, points) == sorted(map(turn_first, others))


@pytest.mark.parametrize(
    ("others", "message"),
    [
        ([(0, 1)], "2 corners"),
        ([(0, 1, 99)], "outside 0..7"),
        ([(0, 1, 0, 2)], "repeats a vertex"),
        ([(0, 1, 2), (0, 2, 1), (0, 1, 3)], "faces; at most two|run alike"),
    ],
)
def test_what_is_no_face_is_named(others: Faces, message: str) -> None:
    points, quads = cube(1)
    with pytest.raises(InvalidRetopoError, match=message):
        import_quads(points, quads[:3], others=others)


def test_a_face_that_touches_in_a_vertex_alone_is_named() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 1, 0], [2, 2, 0.0]])
    with pytest.raises(InvalidRetopoError, match="meet at vertex 2 without an edge"):
        import_quads(points, [[0, 1, 2, 3]], others=[(2, 4, 5)])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(3, 7))
def test_within_a_polygon_is_what_its_angles_say(seed: int, n: int) -> None:
    """Against the winding number, summed from angles, in a plane that is turned anyhow."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.random(n)) * 2 * np.pi
    if np.diff(angle, append=angle[0] + 2 * np.pi).max() > 3.0:
        return
    flat = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.5, 1.0, (n, 1))
    at = rng.uniform(-1.0, 1.0, (200, 2))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    corners, points = (np.pad(xy, ((0, 0), (0, 1))) @ turn.T for xy in (flat, at))
    normals = np.tile(turn[:, 2], (len(at), 1))
    rest = flat[None] - at[:, None]
    ahead = np.roll(rest, -1, axis=1)
    cross = rest[..., 0] * ahead[..., 1] - rest[..., 1] * ahead[..., 0]
    winding = np.arctan2(cross, (rest * ahead).sum(axis=2)).sum(axis=1) / (2 * np.pi)
    edges = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1)
    away = (abs(cross) / np.maximum(edges, 1e-12)).min(axis=1)
    sure = away > 0.01
    wanted = abs(winding) > 0.5
    assert (lies_within(corners, points, normals)[sure] == wanted[sure]).all()
    assert not lies_within(corners, points, -normals).any()
