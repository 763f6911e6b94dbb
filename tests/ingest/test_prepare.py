"""Preparing a mesh against collapsing in plain Python, and what it must never do."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.typing import NDArray

from ingest.prepare import prepare
from patterndb.core.quadmesh import QuadMesh
from tests.support.meshes import (
    BOW,
    SHAPES,
    Quads,
    beside,
    examples,
    mesh_of_file,
    models,
    quad_soups,
    refined,
    shared_meshes,
    wrapped,
)
from tests.support.reference import reduction as reference
from tests.support.reference.halfedge import as_complex, components, twins
from tests.support.shared import SHARED, oracle

MEDIUM = ["spot", "penguin", "osd_pawn", "q_cat", "mh_tongue", "q_clownfish", "q_spider", "q_fish"]

#: Plain Python takes minutes for larger meshes.
MOST_QUADS = 1000


def twin_of(adjacency: list[list[tuple[int, int] | None]]) -> list[int]:
    return [-1 if n is None else 4 * n[0] + n[1] for row in adjacency for n in row]


def edges(quads: NDArray[np.int32]) -> Counter[tuple[int, ...]]:
    return Counter(tuple(sorted((int(q[e]), int(q[e - 3])))) for q in quads for e in range(4))


def assert_sound(mesh: QuadMesh, prepared: QuadMesh) -> None:
    """No component gone, no degenerate quad, no new edge of three quads; names kept."""
    assert prepared.n_quads <= mesh.n_quads
    assert all(len(set(q.tolist())) == 4 for q in prepared.quads)
    assert (np.diff(prepared.source_quad) > 0).all()
    of_quad = mesh.components()
    assert set(of_quad[prepared.source_quad]) == set(of_quad), "a component is gone"
    # What a kept quad's corners were merged into lay in its component.
    lies_in = set(zip(mesh.source[mesh.vertex].tolist(), of_quad.repeat(4).tolist(), strict=True))
    corners = prepared.source[prepared.vertex].tolist()
    kept = of_quad[prepared.source_quad].repeat(4).tolist()
    assert set(zip(corners, kept, strict=True)) <= lies_in
    # Where two fans share a name, an edge of three cannot be told by names.
    if len(set(mesh.source.tolist())) == mesh.n_vertices and max(edges(mesh.quads).values()) <= 2:
        assert max(edges(prepared.source[prepared.quads]).values()) <= 2


def assert_prepared(quads: Quads) -> None:
    """Half-edges as by plain Python; and as by the program of the shared folder, where it is.

    These find neighbours by vertices, so they are compared where no border edges lie on each
    other to begin with.
    """
    mesh = QuadMesh.from_quads(quads)
    prepared = prepare(mesh)
    assert_sound(mesh, prepared)
    if mesh.n_quads <= MOST_QUADS and twins(mesh.quads.tolist()) == mesh.twin.tolist():
        expected = twins(reference.prepare_mesh(mesh.quads.tolist()))
        assert prepared.twin.tolist() == expected
    if not SHARED.is_dir():
        return
    program = oracle()
    faces = program.Complex(quads).faces
    if twin_of(program.adjacency(faces)) == mesh.twin.tolist():
        reduced = program.reduce_patch(faces, whole_mesh=True)
        assert prepared.twin.tolist() == twin_of(program.Complex(reduced, oriented=True).adj)


@pytest.mark.parametrize("name", SHAPES)
def test_shapes(name: str) -> None:
    assert_prepared(SHAPES[name])


@settings(max_examples=200)
@given(quad_soups(most=40))
def test_random_meshes(quads: Quads) -> None:
    assert_prepared(quads)


@given(quad_soups(most=12))
def test_refined_random_meshes(quads: Quads) -> None:
    assert_prepared(refined(quads))


@pytest.mark.parametrize(
    "path", [*examples(), *models(), *shared_meshes(*MEDIUM)], ids=lambda p: p.stem
)
def test_artists_meshes(path: Path) -> None:
    mesh = mesh_of_file(path)
    assert_prepared(mesh.source[mesh.quads].tolist())
    prepared = prepare(mesh)
    assert prepare(prepared).twin.tolist() == prepared.twin.tolist(), "something was left"


@pytest.mark.parametrize(
    ("quads", "left"),
    [
        pytest.param(wrapped(7, 9), 1, id="a grid"),
        pytest.param(wrapped(7, 9, around=True), 2, id="a tube"),
        pytest.param(wrapped(7, 9, around=True, along=True), 9, id="a torus"),
        pytest.param(wrapped(1, 4, around=True), 2, id="a ring of quads"),
        pytest.param(beside(wrapped(4, 4, around=True), wrapped(2, 2), BOW), 5, id="each of many"),
    ],
)
def test_all_regular_components_stay(quads: Quads, left: int) -> None:
    """As few quads as still have four vertices each; a tube closes to a pillow of two."""
    mesh = QuadMesh.from_quads(quads)
    prepared = prepare(mesh)
    assert prepared.n_quads == left
    before = set(components(as_complex(mesh.twin.tolist())).values())
    after = set(components(as_complex(prepared.twin.tolist())).values())
    assert len(after) == len(before)
    assert_sound(mesh, prepared)


@pytest.mark.parametrize("name", ["cube", "cup", "star 3"])
def test_refining_twice_is_undone(name: str) -> None:
    quads = SHAPES[name]
    fine = prepare(QuadMesh.from_quads(refined(refined(quads))))
    assert fine.n_quads == prepare(QuadMesh.from_quads(quads)).n_quads


def test_no_quads() -> None:
    assert prepare(QuadMesh.from_quads([])).n_quads == 0
