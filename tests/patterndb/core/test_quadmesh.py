from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb._native.core.halfedge import next_border_edge
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import InvalidMeshError
from tests.support.meshes import (
    BOOK,
    BOW,
    CLASP,
    CUBE,
    PILLOW,
    SHAPES,
    Quads,
    beside,
    grid,
    quad_soups,
    wrapped,
)
from tests.support.reference import halfedge


def assert_as_reference(quads: Quads) -> None:
    """Orientation, joined edges, fans, border and components, by the plain reference."""
    mesh = QuadMesh.from_quads(quads)
    oriented = halfedge.oriented(quads)
    twin = halfedge.twins(oriented)
    assert mesh.twin.tolist() == twin
    complex_ = halfedge.as_complex(twin)
    vertex = halfedge.fans(complex_)
    assert mesh.vertex.tolist() == [vertex[h] for h in range(4 * len(quads))]
    assert mesh.n_vertices == len(set(vertex.values()))
    assert mesh.source[mesh.vertex].tolist() == [v for q in oriented for v in q]
    assert mesh.source_quad.tolist() == list(range(len(quads)))
    border = halfedge.border_vertices(complex_, vertex)
    assert np.flatnonzero(mesh.border()).tolist() == sorted(border)
    component = halfedge.components(complex_)
    assert mesh.components().tolist() == [component[f] for f in range(len(quads))]
    counts = [list(vertex.values()).count(v) for v in range(mesh.n_vertices)]
    assert mesh.valence().tolist() == counts


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_agree_with_the_reference(name: str) -> None:
    assert_as_reference(SHAPES[name])


@given(quad_soups())
def test_random_meshes_agree_with_the_reference(quads: Quads) -> None:
    assert_as_reference(quads)


@given(quad_soups())
def test_half_edges_are_an_involution_between_opposite_directions(quads: Quads) -> None:
    mesh = QuadMesh.from_quads(quads)
    inner = np.flatnonzero(mesh.twin >= 0)
    assert (mesh.twin[mesh.twin[inner]] == inner).all()
    assert (mesh.twin[inner] >> 2 != inner >> 2).all()
    head = mesh.vertex[(inner & ~3) | ((inner + 1) & 3)]
    assert (mesh.vertex[mesh.twin[inner]] == head).all()


@given(quad_soups())
def test_a_border_loop_visits_each_border_edge_once(quads: Quads) -> None:
    twin = QuadMesh.from_quads(quads).twin
    border = np.flatnonzero(twin < 0).tolist()
    assert sorted(int(next_border_edge(twin, h)) for h in border) == border


@given(st.sampled_from(["cube", "torus", "grid", "star 5", "refined cup"]), st.randoms())
def test_an_orientable_mesh_is_joined_however_its_quads_are_flipped(
    name: str, chance: random.Random
) -> None:
    quads = SHAPES[name]
    mesh = QuadMesh.from_quads(quads)
    flipped = [q[::-1] if i and chance.random() < 0.5 else q for i, q in enumerate(quads)]
    again = QuadMesh.from_quads(flipped)
    assert (again.twin < 0).sum() == (mesh.twin < 0).sum()
    np.testing.assert_array_equal(again.source[again.quads][0], mesh.source[mesh.quads][0])
    directed = {(int(q[e]), int(q[e - 3])) for q in again.source[again.quads] for e in range(4)}
    assert directed == {(q[e], q[e - 3]) for q in quads for e in range(4)}


def n_joined(quads: Quads) -> int:
    return int((QuadMesh.from_quads(quads).twin >= 0).sum()) // 2


@pytest.mark.parametrize(
    ("quads", "joined", "vertices", "components"),
    [
        pytest.param(BOW, 0, 8, 2, id="two fans at a vertex are two vertices"),
        pytest.param(CLASP, 0, 8, 2, id="at both ends of a diagonal"),
        pytest.param(BOOK, 0, 12, 3, id="an edge of three quads joins none"),
        pytest.param(BOOK[:2], 1, 6, 1, id="of two, it does"),
        pytest.param(PILLOW, 4, 4, 1, id="a quad twice is closed"),
        pytest.param([*PILLOW, PILLOW[0]], 0, 12, 3, id="three times, three quads"),
        pytest.param(CUBE, 12, 8, 1, id="closed surface"),
        pytest.param(wrapped(1, 5, twist=True), 4, 12, 1, id="a Moebius strip is cut once"),
        pytest.param(beside(CUBE, BOW, grid(2, 2)), 16, 25, 4, id="beside each other"),
    ],
)
def test_what_joins(quads: Quads, joined: int, vertices: int, components: int) -> None:
    mesh = QuadMesh.from_quads(quads)
    assert n_joined(quads) == joined
    assert mesh.n_vertices == vertices
    assert mesh.components().max() + 1 == components


def test_no_quads_make_an_empty_mesh() -> None:
    mesh = QuadMesh.from_quads([])
    assert (mesh.n_quads, mesh.n_vertices, len(mesh.components())) == (0, 0, 0)


@pytest.mark.parametrize(
    ("quads", "message"),
    [
        ([[0, 1, 2]], r"\(q, 4\)"),
        ([0, 1, 2, 3], r"\(q, 4\)"),
        ([[0, 1, 2, -1]], "0..2"),
        ([[0, 1, 2, 2**31]], "0..2"),
        ([[0, 1, 2, 3], [4, 5, 4, 6]], r"quad 1 repeats a vertex: \[4, 5, 4, 6\]"),
    ],
)
def test_what_is_no_quad_mesh_is_refused(quads: list[list[int]], message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        QuadMesh.from_quads(quads)


def test_the_quads_given_are_not_changed() -> None:
    quads = np.array([[0, 1, 2, 3], [0, 1, 4, 5]], np.int32)
    before = quads.copy()
    mesh = QuadMesh.from_quads(quads)
    assert mesh.source[mesh.quads][1].tolist() == [5, 4, 1, 0]
    np.testing.assert_array_equal(quads, before)


@given(
    st.lists(st.lists(st.integers(0, 9), min_size=0, max_size=7), max_size=30),
)
def test_quads_of_a_polygon_mesh_are_its_faces_of_four_distinct_corners(
    faces: list[list[int]],
) -> None:
    mesh = PolygonMesh(
        np.zeros((10, 3)),
        np.array([v for f in faces for v in f], np.int32),
        np.cumsum([0, *map(len, faces)]).astype(np.int64),
    )
    quads, places = mesh.quads()
    expected = [i for i, f in enumerate(faces) if len(f) == len(set(f)) == 4]
    assert places.tolist() == expected
    assert quads.tolist() == [faces[i] for i in expected]
    assert quads.shape == (len(expected), 4)


@pytest.mark.parametrize(
    ("points", "corners", "offsets"),
    [
        ((4, 2), [0, 1, 2, 3], [0, 4]),
        ((4, 3), [0, 1, 2, 4], [0, 4]),
        ((4, 3), [0, 1, 2, -1], [0, 4]),
        ((4, 3), [0, 1, 2, 3], [0, 3]),
        ((4, 3), [0, 1, 2, 3], [1, 4]),
        ((4, 3), [0, 1, 2, 3], [0, 4, 3, 4]),
        ((4, 3), [], []),
    ],
)
def test_an_unsound_polygon_mesh_is_refused(
    points: tuple[int, int], corners: list[int], offsets: list[int]
) -> None:
    with pytest.raises(InvalidMeshError):
        PolygonMesh(np.zeros(points), np.array(corners, np.int32), np.array(offsets, np.int64))
