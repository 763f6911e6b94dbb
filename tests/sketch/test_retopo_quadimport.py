"""Quad meshes taken apart into patches, and put together again bit for bit."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from retopo_cases import genus
from shared import MESHES

import patterndb
from ingest.read import read_mesh
from query.placing.surface import Points
from sketch.retopo.editor import Call, Editor
from sketch.retopo.errors import InvalidRetopoError
from sketch.retopo.filling import completed, open_edges, suits, welded
from sketch.retopo.filling.choosing import stepped
from sketch.retopo.ground import Ground
from sketch.retopo.network import BORDER, Network, check
from sketch.retopo.quadimport import Imported, imported, quads_of, separatrices
from sketch.retopo.tools.erase import erase

Quads = NDArray[np.int32]
Mesh = tuple[Points, Quads]


def cube(k: int) -> Mesh:
    """A cube of k x k quads on each side."""
    number: dict[tuple[int, ...], int] = {}
    quads: list[list[int]] = []
    for axis in range(3):
        for level in (0, k):
            for i in range(k):
                for j in range(k):
                    quad: list[int] = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at = [0, 0, 0]
                        at[axis], at[axis - 2], at[axis - 1] = level, i + di, j + dj
                        quad.append(number.setdefault(tuple(at), len(number)))
                    quads.append(quad if level else quad[::-1])
    return np.array(list(number), float) / k, np.array(quads, np.int32)


def torus(a: int, b: int, shift: int = 0) -> Mesh:
    """Closed, all valences 4; going round the tube once leads ``shift`` further."""

    def at(i: int, j: int) -> int:
        return (i + j // b * shift) % a * b + j % b

    quads = [
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(a) for j in range(b)
    ]
    u, v = np.divmod(np.arange(a * b), b)
    u, v = 2 * np.pi * (u / a + shift * v / (a * b)), 2 * np.pi * v / b
    out = 2.0 + np.cos(v)
    points = np.stack([out * np.cos(u), out * np.sin(u), np.sin(v)], axis=1)
    return points, np.array(quads, np.int32)


def tube(a: int, b: int) -> Mesh:
    """A ring of a x b quads with two borders."""
    u, v = np.divmod(np.arange(a * (b + 1)), b + 1)
    angle = 2 * np.pi * u / a
    points = np.stack([(1 + v) * np.cos(angle), (1 + v) * np.sin(angle), 0.0 * v], axis=1)
    quads = [
        [
            i * (b + 1) + j,
            i * (b + 1) + j + 1,
            (i + 1) % a * (b + 1) + j + 1,
            (i + 1) % a * (b + 1) + j,
        ]
        for i in range(a)
        for j in range(b)
    ]
    return points, np.array(quads, np.int32)


def cycles(quads: NDArray[np.integer]) -> list[tuple[int, ...]]:
    """The quads, each from its lowest vertex on, in order."""
    first = quads.argmin(axis=1)[:, None]
    return sorted(map(tuple, np.take_along_axis(quads, (first + np.arange(4)) % 4, 1).tolist()))


def is_again(found: Imported, mesh: Mesh) -> None:
    """The welded mesh is the one imported: the same vertices, bit for bit, and the same quads."""
    points, quads = mesh
    made = welded(found.filled)
    rows = np.concatenate(
        [found.vertex[p][found.filled.placed[p].quads] for p in sorted(found.filled.placed)]
    )
    name = np.full(len(made.vertices), -1)
    name[made.quads] = rows
    # One vertex of the mesh for each, and each of the mesh's once.
    assert (name[made.quads] == rows).all()
    assert sorted(name.tolist()) == np.unique(quads).tolist()
    assert made.vertices.tobytes() == np.ascontiguousarray(points[name]).tobytes()
    assert cycles(name[made.quads]) == cycles(quads)


def marked_edges(mesh: Mesh) -> set[frozenset[int]]:
    """The edges on separatrices of a mesh that has irregular vertices in every part, with sets of
    edges and nothing else."""
    _, quads = mesh
    around: dict[int, list[tuple[int, ...]]] = {}
    beside: dict[frozenset[int], int] = {}
    for quad in map(tuple, quads.tolist()):
        for a, b in pairwise((*quad, quad[0])):
            around.setdefault(a, []).append(quad)
            beside[frozenset((a, b))] = beside.get(frozenset((a, b)), 0) + 1
    border = {v for edge, uses in beside.items() if uses == 1 for v in edge}
    edges: dict[int, set[int]] = {}
    for edge in beside:
        a, b = edge
        edges.setdefault(a, set()).add(b)
        edges.setdefault(b, set()).add(a)
    irregular = {v for v, at in edges.items() if len(at) != (3 if v in border else 4)}
    marked = {edge for edge, uses in beside.items() if uses == 1}
    for start in irregular:
        for first in edges[start]:
            one, two = start, first
            marked.add(frozenset((one, two)))
            while two not in irregular and two not in border:
                # Straight ahead: the neighbour that shares no quad with the edge.
                (ahead,) = [
                    v
                    for v in edges[two] - {one}
                    if not any(one in quad and v in quad for quad in around[two])
                ]
                one, two = two, ahead
                marked.add(frozenset((one, two)))
    return marked


def holds(found: Imported, mesh: Mesh) -> None:
    """What always holds: the network's invariants, patches of four sides of one chain, T never,
    counts as they were, irregular vertices at nodes."""
    network = found.network
    check(network)
    for patch in network.patches.values():
        assert patch.corners == (0, 1, 2, 3)
        assert len(patch.loop) == 4
        assert suits(network, patch)
        assert not any(network.mark(half) for half in patch.loop)
    for node in network.nodes.values():
        outside = [h for h in node.ends if network.mark(h) == BORDER]
        assert node.flagged.count(False) == len(outside) <= 1
    # Every quad is in one patch.
    assert sum(len(placed.quads) for placed in found.filled.placed.values()) == len(mesh[1])
    checked = quads_of(*mesh)
    irregular = mesh[0][checked.irregular]
    places = {node.point.tobytes() for node in network.nodes.values()}
    assert {point.tobytes() for point in irregular} <= places
    marked, _ = separatrices(checked)
    assert sum(chain.count for chain in network.chains.values()) == len(
        {frozenset(e) for e in edges_of(mesh[1])[marked].tolist()}
    )
    is_again(found, mesh)


def edges_of(quads: Quads) -> Quads:
    """(4q, 2) the ends of every half-edge."""
    return np.stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()], axis=1)


def test_a_cube_of_four_has_six_patches() -> None:
    mesh = cube(4)
    found = imported(*mesh)
    assert len(found.network.patches) == 6
    assert [chain.count for chain in found.network.chains.values()] == [4] * 12
    assert len(found.network.nodes) == 8
    assert genus(found.network) == 0
    assert found.filled.notes == ()
    assert found.sizes.edge == pytest.approx(0.25)
    holds(found, mesh)


@pytest.mark.parametrize(
    ("mesh", "patches"),
    [
        (torus(6, 5), 1),
        (torus(6, 5, 2), 3),
        (torus(5, 4, 1), 5),
        (torus(3, 3), 1),
        (tube(7, 3), 1),
        (tube(3, 1), 1),
    ],
    ids=["torus", "torus shifted by 2", "by 1", "3 x 3", "tube", "thin tube"],
)
def test_parts_without_irregular_vertices_are_cut(mesh: Mesh, patches: int) -> None:
    """A torus whose lines close after one round is one patch; one whose lines wind is cut where
    they cross."""
    found = imported(*mesh)
    assert len(found.network.patches) == patches
    holds(found, mesh)


def test_border_vertices_of_three_quads_are_corners() -> None:
    """An L: two curves leave its inner corner, so that no curve ends on the inside of another."""
    points = np.array([[i, j, 0.0] for i in range(5) for j in range(5)])
    quads = np.array(
        [
            [5 * i + j, 5 * i + 5 + j, 5 * i + 6 + j, 5 * i + 1 + j]
            for i in range(4)
            for j in range(4)
            if not (i >= 2 and j >= 2)
        ]
    )
    found = imported(points, quads)
    assert len(found.network.patches) == 3
    assert found.unused == 4
    assert found.filled.notes == ("4 vertices that no quad uses are left out",)
    holds(found, (points, quads.astype(np.int32)))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(4, 9), st.integers(1, 3))
def test_any_mesh_is_taken_apart_and_put_together(seed: int, n: int, level: int) -> None:
    """Hulls of random points, each triangle cut into three quads and these into 4^level, some of
    them taken away; vertices and quads in random order."""
    rng = np.random.default_rng(seed)
    hull = trimesh.convex.convex_hull(rng.normal(size=(n, 3)))
    triangles = hull.faces[rng.random(len(hull.faces)) < rng.choice([0.6, 1.0])]
    if not len(triangles):
        return
    points, quads = refined(*thirds(hull.vertices, triangles), level - 1)
    order = rng.permutation(len(points))
    place = np.argsort(order)
    mesh = points[order], place[quads][rng.permutation(len(quads))].astype(np.int32)
    try:
        found = imported(*mesh)
    except InvalidRetopoError as error:
        # Triangles that were left may touch at a vertex only.
        assert "joins several fans" in str(error)
        return
    holds(found, mesh)
    checked = quads_of(*mesh)
    marked, corner = separatrices(checked)
    edges = {frozenset(edge) for edge in edges_of(mesh[1])[marked].tolist()}
    assert edges == marked_edges(mesh)
    assert len(found.network.nodes) == corner.sum()


def thirds(points: Points, triangles: NDArray[np.integer]) -> Mesh:
    """Every triangle as three quads, from its middle and the middles of its edges."""
    all_points = list(map(tuple, points.tolist()))
    number: dict[tuple[float, ...], int] = {p: k for k, p in enumerate(all_points)}

    def middle(*corners: int) -> int:
        at = tuple(np.mean([all_points[c] for c in sorted(corners)], axis=0).tolist())
        if at not in number:
            number[at] = len(all_points)
            all_points.append(at)
        return number[at]

    quads: list[list[int]] = []
    for a, b, c in triangles.tolist():
        m = middle(a, b, c)
        for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
            quads.append([v, middle(v, w), m, middle(u, v)])
    return np.array(all_points), np.array(quads, np.int32)


def refined(points: Points, quads: Quads, times: int) -> Mesh:
    """Every quad as four, so many times."""
    for _ in range(times):
        ends = np.sort(edges_of(quads), axis=1)
        edges, which = np.unique(ends, axis=0, return_inverse=True)
        on = (len(points) + which.reshape(-1, 4)).astype(np.int32)
        inside = len(points) + len(edges) + np.arange(len(quads), dtype=np.int32)
        new = np.concatenate([points, points[edges].mean(axis=1), points[quads].mean(axis=1)])
        parts = [np.stack([quads[:, e], on[:, e], inside, on[:, e - 1]], axis=1) for e in range(4)]
        points, quads = new, np.concatenate(parts).astype(np.int32)
    return points, quads


@pytest.mark.parametrize(
    ("name", "patches"),
    [
        ("utah_teapot", 74),
        ("shaderball_base", 72),
        ("mh_eyes", 20),
        ("mh_shoes01", 28),
        ("osd_pawn", 36),
        ("mh_tongue", 14),
    ],
)
def test_real_meshes_come_back(name: str, patches: int) -> None:
    given_mesh = read_mesh(MESHES / f"{name}.obj")
    mesh = given_mesh.points, given_mesh.corners.reshape(-1, 4).astype(np.int32)
    found = imported(*mesh)
    assert len(found.network.patches) == patches
    holds(found, mesh)


def test_filling_leaves_what_was_imported() -> None:
    """Counts, fills and places are there already: filling changes no bit, and an edit only what
    is beside it."""
    ball = trimesh.creation.icosphere(subdivisions=0)
    points, quads = refined(*thirds(ball.vertices, ball.faces), 2)
    found = imported(points + 0.01 * np.random.default_rng(1).normal(size=points.shape), quads)
    assert len(found.network.patches) == 60
    with patterndb.open() as source:
        whole = completed(found.network, found.ground, source, found.sizes.edge)
        assert whole.network is found.network
        assert welded(whole).vertices.tobytes() == welded(found.filled).vertices.tobytes()
        # The fill is the database's own: another can be taken, and the first again.
        patch = min(found.network.patches)
        other = stepped(found.network, patch, source, 1)
        assert other.patches[patch].choice != found.network.patches[patch].choice
        again = stepped(other, patch, source, -1)
        former = found.network.patches[patch].choice.choice
        assert again.patches[patch].choice.choice == former
        # Without one curve two patches are one.
        edit = erase(found.network, [0])
        check(edit.network)
        assert len(edit.network.patches) == 59
        after = completed(edit.network, found.ground, source, found.sizes.edge)
    made = welded(after)
    assert len(open_edges(made)) == 0
    kept = found.network.patches.keys() & edit.network.patches.keys()
    assert len(kept) == 58
    for patch in kept:
        assert (
            after.placed[patch].vertices.tobytes() == found.filled.placed[patch].vertices.tobytes()
        )


def test_corners_that_were_regular_go_with_their_curves() -> None:
    """Erasing a curve from an irregular vertex to the border joins the border again."""
    points = np.array([[i, j, 0.0] for i in range(5) for j in range(5)])
    every = [
        [5 * i + j, 5 * i + 5 + j, 5 * i + 6 + j, 5 * i + 1 + j]
        for i in range(4)
        for j in range(4)
        if not (i >= 2 and j >= 2)
    ]
    # Without the limit to how long a loop may be, which this sheet's reach.
    network: Network = replace(imported(points, np.array(every)).network, longest=np.inf)
    inner = [chain.id for chain in network.chains.values() if not chain.marked]
    assert len(inner) == 2
    after = erase(network, inner[:1]).network
    check(after)
    assert len(after.nodes) == len(network.nodes) - 1
    assert len(after.patches) == 2


def test_on_another_surface_vertices_lie_on_it() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    ground = Ground.of(ball.vertices, ball.faces)
    points, quads = cube(4)
    points = 2.0 * points - 1.0
    found = imported(points, quads, ground)
    check(found.network)
    made = welded(found.filled)
    gaps = ground.nearest(made.vertices).points - made.vertices
    assert abs(gaps).max() < 1e-12
    for chain in found.network.chains.values():
        gaps = ground.nearest(chain.points).points - chain.points
        assert abs(gaps).max() < 1e-12
    assert len(open_edges(made)) == 0


SQUARES = np.array([[i, j, 0.0] for i in range(3) for j in range(3)])


@pytest.mark.parametrize(
    ("points", "quads", "message"),
    [
        (SQUARES, [[0, 3, 4]], "triangles and larger faces cannot be imported"),
        (SQUARES, np.empty((0, 4), int), "no quads"),
        (SQUARES, [[0, 3, 4, 9]], r"quad 0 \[0, 3, 4, 9\] names a vertex outside 0..8"),
        (SQUARES, [[0, 3, 4, 4]], "quad 0 repeats a vertex"),
        (SQUARES, [[0.5, 3, 4, 1]], "whole numbers"),
        (SQUARES[:, :2], [[0, 3, 4, 1]], r"must be \(v, 3\)"),
        (SQUARES * np.nan, [[0, 3, 4, 1]], "vertex 0 of the mesh is not finite"),
        (SQUARES, [[0, 3, 4, 1], [1, 2, 5, 4]], "quads 0 and 1 run alike"),
        (SQUARES, [[0, 3, 4, 1], [4, 7, 8, 5]], "meet at vertex 4 without an edge"),
        (
            np.concatenate([SQUARES, SQUARES + np.array([0.0, 0.0, 1.0])]),
            [[0, 3, 4, 1], [1, 4, 5, 2], [4, 1, 10, 13]],
            "between vertices 4 and 1 has 3 quads|between vertices 1 and 4 has 3 quads",
        ),
        (np.zeros((9, 3)), [[0, 3, 4, 1]], "no triangle with an area"),
    ],
)
def test_what_is_no_quad_mesh_is_named(
    points: Points, quads: list[list[int]], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        imported(points, np.array(quads))


def test_quads_follow_a_curve_that_is_pulled() -> None:
    """Held vertices of the patches beside it are let go; all others stay where they were."""
    points, quads = cube(4)
    with patterndb.open() as source:
        editor = Editor.of_quads(imported(points, quads), source)
        before = welded(editor.fill())
        outcome = editor.do(Call("pull", {"at": [1.0, 0.5, 0.0], "to": [1.0, 0.5, 0.2]}))
        assert outcome.changed, outcome.refused
        check(editor.network)
        after = welded(editor.fill())
        assert len(after.quads) == len(quads)
        assert len(open_edges(after)) == 0
        one, two = ({tuple(p) for p in m.vertices.tolist()} for m in (before, after))
        kept = one & two
        # The two patches beside the cube's edge moved, the inner vertices of the others not.
        assert 4 * 9 <= len(kept) < len(before.vertices) - 2 * 9
        editor.do(Call("undo"))
        assert np.array_equal(welded(editor.fill()).vertices, before.vertices)
