"""Quad meshes taken apart into patches, and put together again bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import read_mesh
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.quadgrids import check_quads, mark_separatrices
from patterndb_sketch.retopo.quadimport import import_quads
from tests.support.meshes import examples, models, shared_meshes
from tests.support.retopo.networks import genus
from tests.support.retopo.quadmeshes import (
    Mesh,
    cube,
    edges_of,
    holds,
    marked_edges,
    refined,
    thirds,
    torus,
    tube,
)


def test_a_cube_of_four_has_six_patches() -> None:
    mesh = cube(4)
    found = import_quads(*mesh)
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
    found = import_quads(*mesh)
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
    found = import_quads(points, quads)
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
        found = import_quads(*mesh)
    except InvalidRetopoError as error:
        # Triangles that were left may touch at a vertex only.
        assert "joins several fans" in str(error)
        return
    holds(found, mesh)
    checked = check_quads(*mesh)
    marked, corner = mark_separatrices(checked)
    edges = {frozenset(edge) for edge in edges_of(mesh[1])[marked].tolist()}
    assert edges == marked_edges(mesh)
    assert len(found.network.nodes) == corner.sum()


#: Patches of the meshes that are here, and of artists' meshes.
PATCHES = {
    "dog": 140,
    "hand": 115,
    "head": 259,
    "jug": 48,
    "frame": 50,
    "glove": 56,
    "mask": 97,
    "ring": 200,
    "utah_teapot": 74,
    "shaderball_base": 72,
    "mh_eyes": 20,
    "mh_shoes01": 28,
    "osd_pawn": 36,
    "mh_tongue": 14,
}
MESH_FILES = [*examples(), *models(), *shared_meshes(*PATCHES)]


@pytest.mark.parametrize(
    "path", [path for path in MESH_FILES if path.stem in PATCHES], ids=lambda path: path.stem
)
def test_meshes_come_back(path: Path) -> None:
    patches = PATCHES[path.stem]
    given_mesh = read_mesh(path)
    mesh = given_mesh.points, given_mesh.corners.reshape(-1, 4).astype(np.int32)
    found = import_quads(*mesh)
    assert len(found.network.patches) == patches
    holds(found, mesh)


SQUARES = np.array([[i, j, 0.0] for i in range(3) for j in range(3)])


@pytest.mark.parametrize(
    ("points", "quads", "message"),
    [
        (SQUARES, [[0, 3, 4]], "give triangles and larger faces as others"),
        (SQUARES, np.empty((0, 4), int), "no quads"),
        (SQUARES, [[0, 3, 4, 9]], r"quad 0 \[0, 3, 4, 9\] names a vertex outside 0..8"),
        (SQUARES, [[0, 3, 4, 4]], "quad 0 repeats a vertex"),
        (SQUARES, [[0.5, 3, 4, 1]], "whole numbers"),
        (SQUARES[:, :2], [[0, 3, 4, 1]], r"must be \(v, 3\)"),
        (SQUARES * np.nan, [[0, 3, 4, 1]], "vertex 0 of the mesh is not finite"),
        (SQUARES, [[0, 3, 4, 1], [1, 2, 5, 4]], "quad 0 and quad 1 run alike"),
        (SQUARES, [[0, 3, 4, 1], [4, 7, 8, 5]], "meet at vertex 4 without an edge"),
        (
            np.concatenate([SQUARES, SQUARES + np.array([0.0, 0.0, 1.0])]),
            [[0, 3, 4, 1], [1, 4, 5, 2], [4, 1, 10, 13]],
            "between vertices 4 and 1 has 3 faces|between vertices 1 and 4 has 3 faces",
        ),
        (np.zeros((9, 3)), [[0, 3, 4, 1]], "no triangle with an area"),
    ],
)
def test_what_is_no_quad_mesh_is_named(
    points: Points, quads: list[list[int]], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        import_quads(points, np.array(quads))
