"""Preparing a mesh against collapsing in plain Python, and what it must never do."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from meshes import BOW, SHAPES, Quads, beside, examples, mesh_of_file, quad_soups, refined, wrapped
from reference.halfedge import as_complex, components
from shared import MESHES, oracle

from ingest.prepare import prepare
from patterndb.quadmesh import QuadMesh

MEDIUM = ["spot", "penguin", "osd_pawn", "q_cat", "mh_tongue", "q_clownfish", "q_spider", "q_fish"]


def oracle_twin(quads: Quads) -> list[int]:
    """The half-edges of the collapsed mesh, by the other program."""
    program = oracle()
    reduced = program.reduce_patch(program.Complex(quads).faces, whole_mesh=True)
    adjacency = program.Complex(reduced, oriented=True).adj
    return [-1 if n is None else 4 * n[0] + n[1] for row in adjacency for n in row]


def edges(quads: np.ndarray) -> Counter[tuple[int, ...]]:
    return Counter(tuple(sorted((int(q[e]), int(q[e - 3])))) for q in quads for e in range(4))


def assert_sound(mesh: QuadMesh, prepared: QuadMesh) -> None:
    """No component gone, no degenerate quad, no new edge of three quads; names kept."""
    assert prepared.n_quads <= mesh.n_quads
    assert all(len(set(q.tolist())) == 4 for q in prepared.quads)
    named = prepared.source[prepared.quads]
    assert (np.diff(prepared.source_quad) > 0).all()
    of_quad = mesh.components()
    assert set(of_quad[prepared.source_quad]) == set(of_quad), "a component is gone"
    # A kept quad's vertices are its own, or were merged with them in its component.
    places = {v: set(of_quad[q] for q in np.flatnonzero((mesh.source[mesh.quads] == v).any(1)))
              for v in np.unique(named).tolist()}
    for q, corners in zip(prepared.source_quad.tolist(), named.tolist(), strict=True):
        assert all(of_quad[q] in places[v] for v in corners)
    if max(edges(mesh.quads).values(), default=0) <= 2:
        assert max(edges(named).values(), default=0) <= max(
            2, max(edges(mesh.source[mesh.quads]).values(), default=0)
        )


def assert_as_oracle(quads: Quads) -> None:
    mesh = QuadMesh.from_quads(quads)
    prepared = prepare(mesh)
    assert prepared.twin.tolist() == oracle_twin(quads)
    assert_sound(mesh, prepared)
    again = prepare(prepared)
    assert again.twin.tolist() == prepared.twin.tolist(), "something was left to collapse"


@pytest.mark.parametrize("name", SHAPES)
def test_shapes(name: str) -> None:
    assert_as_oracle(SHAPES[name])


@settings(max_examples=300)
@given(quad_soups(most=40))
def test_random_meshes(quads: Quads) -> None:
    assert_as_oracle(quads)


@given(quad_soups(most=12))
def test_refined_random_meshes(quads: Quads) -> None:
    assert_as_oracle(refined(quads))


@pytest.mark.parametrize(
    "path", [*examples(), *(MESHES / f"{n}.obj" for n in MEDIUM)], ids=lambda p: p.stem
)
def test_artists_meshes(path: Path) -> None:
    mesh = mesh_of_file(path)
    assert_as_oracle(mesh.source[mesh.quads].tolist())


@pytest.mark.parametrize(
    ("quads", "left"),
    [
        pytest.param(wrapped(7, 9), 1, id="a grid"),
        pytest.param(wrapped(7, 9, around=True), 3, id="a tube"),
        pytest.param(wrapped(7, 9, around=True, along=True), 9, id="a torus"),
        pytest.param(wrapped(1, 4, around=True), 3, id="a ring of quads"),
        pytest.param(beside(wrapped(4, 4, around=True), wrapped(2, 2), BOW), 6, id="each of many"),
    ],
)
def test_all_regular_components_stay(quads: Quads, left: int) -> None:
    """As few quads as still have four vertices and edges of two quads each."""
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
