"""Fills that are paved ring by ring: rings against what they must be, and known fills; fixed
corners; loops with two mirrors."""

from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from query.engine import PatternSource
from query.holes import fill_holes, find_holes, hole_of_faces
from query.holes.neighbourhood import extract_neighbourhood
from query.holes.regular import WITHIN, build_regular_fill, lay_ring, pave_loop
from query.holes.symmetry import ASYMMETRIC, count_followed, find_mirrors, lose_by_mirrors
from query.holes.topology import MeshTopology
from query.recognition import hash_quads


def number_loop_first(faces: list[list[int]], loop: list[int]) -> tuple[Int32Array, int]:
    """Number the vertices of a disk: those of its loop in order, then the others."""
    number = {v: i for i, v in enumerate(loop)}
    for v in itertools.chain.from_iterable(faces):
        number.setdefault(v, len(number))
    return np.array([[number[v] for v in face] for face in faces], np.int32), len(number)


def make_pole(sides: list[int]) -> tuple[Int32Array, int, Int32Array]:
    """Join len(sides) grids around one vertex, grid i sides[i] by sides[i + 1] quads: quads, loop
    vertices first, how many vertices, and the quads at each loop vertex."""
    k = len(sides)

    def name(grid: int, a: int, b: int) -> tuple[int, int, int]:
        # (0, 0) is the pole; along b = 0 a grid joins the one before.
        if a == 0 and b == 0:
            return (0, 0, 0)
        return (grid, a, b) if b or a == 0 else ((grid - 1) % k, 0, a)

    every: list[list[tuple[int, int, int]]] = []
    for i in range(k):
        wide, high = sides[i], sides[(i + 1) % k]
        for a in range(wide):
            for b in range(high):
                steps = ((a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1))
                every.append([name(i, *step) for step in steps])
    ids = {v: j for j, v in enumerate(sorted({v for face in every for v in face}))}
    faces = [[ids[v] for v in face] for face in every]
    ahead = {(a, b) for face in faces for a, b in zip(face, face[1:] + face[:1], strict=True)}
    border = {a: b for a, b in ahead if (b, a) not in ahead}
    loop = [min(border)]
    while border[loop[-1]] != loop[0]:
        loop.append(border[loop[-1]])
    quads, n_vertices = number_loop_first(faces, loop)
    return quads, n_vertices, np.bincount(quads.ravel())[: len(loop)].astype(np.int32)


def key_of(quads: Int32Array, n_vertices: int, n: int) -> bytes:
    twin, fault = weld_quads(quads, n_vertices, n)
    assert not fault
    return hash_quads(quads, twin, False)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(1, 5), min_size=3, max_size=3)
    | st.lists(st.integers(1, 4), min_size=5, max_size=5),
    st.integers(0, 60),
)
def test_one_irregular_vertex_is_found_wherever_it_lies(sides: list[int], turn: int) -> None:
    quads, n_vertices, counts = make_pole(sides)
    n = len(counts)
    turned = np.where(quads < n, (quads + turn) % n, quads).astype(np.int32)
    made = pave_loop(np.roll(counts, turn % n))
    assert made is not None
    assert key_of(*made, n) == key_of(turned, n_vertices, n)


@pytest.mark.parametrize(("wide", "high"), [(1, 1), (2, 2), (3, 2), (4, 4), (7, 5), (12, 8)])
def test_grids_are_paved(wide: int, high: int) -> None:
    n = 2 * (wide + high)
    counts = np.full(n, 2, np.int32)
    counts[[0, wide, wide + high, 2 * wide + high]] = 1
    made, regular = pave_loop(counts), build_regular_fill(counts)
    assert made is not None and regular is not None
    assert key_of(*made, n) == key_of(*regular, n)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 4), st.integers(1, 4)), min_size=2, max_size=15))
def test_rings_have_the_quads_that_are_asked_for(pairs: list[tuple[int, int]]) -> None:
    corners = list(itertools.chain.from_iterable(pairs))
    n = len(corners)
    ring = lay_ring(np.array(corners, np.int32))
    if ring is None:
        return
    assert (np.bincount(ring.quads.ravel(), minlength=n)[:n] == corners).all()
    assert (ring.quads < n).any(axis=1).all()
    assert sorted(set(ring.quads.ravel().tolist())) == list(range(ring.n_vertices))
    assert (np.bincount(ring.quads.ravel())[ring.inner] == ring.counts).all()
    assert len(set(ring.inner.tolist())) == len(ring.inner) and len(ring.inner) % 2 == 0
    uses = Counter(
        (a, b) for q in ring.quads.tolist() for a, b in zip(q, q[1:] + q[:1], strict=True)
    )
    border = {edge for edge in uses if edge[::-1] not in uses}
    rim = {(i, (i + 1) % n) for i in range(n)}
    inner = ring.inner.tolist()
    # What is left is the loop within, run the other way.
    assert border == rim | {(b, a) for a, b in zip(inner, inner[1:] + inner[:1], strict=True)}


def test_the_table_of_what_lies_within_has_parts_of_one() -> None:
    assert np.abs(WITHIN.sum(axis=1) - 1).max() < 0.005


def wave(n: int) -> PolygonMesh:
    """A sheet of n by n quads that is bent a little."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)[:-1, :-1].ravel()
    faces = np.column_stack([at, at + 1, at + n + 2, at + n + 1]).tolist()
    points = np.column_stack([x.ravel(), y.ravel(), 0.1 * np.sin(x + y).ravel()])
    return PolygonMesh.from_faces(points, faces)


def test_all_fills_have_the_corners_that_are_fixed(source: PatternSource) -> None:
    topology = MeshTopology.of(wave(8))
    hole = hole_of_faces(topology, [8 * r + c for r in range(2, 6) for c in range(2, 5)])
    for place in (0, 3, 5):
        for quads in (1, 2, 3, 4):
            asked = {int(hole.loop[place]): quads, int(hole.loop[place + 4]): 2}
            listed = list(fill_holes(source, hole, corners=asked, limit=60))
            assert listed
            for fill in listed:
                assert fill.corners[place] == quads and fill.corners[place + 4] == 2


def slot(n: int, long: float) -> PolygonMesh:
    """A flat ring of quads around an ellipse of n edges, ``long`` times as long as wide."""
    at = 2 * np.pi * np.arange(n) / n
    rings = [
        np.column_stack([(long + r) * np.cos(at), (1 + r) * np.sin(at), 0 * at])
        for r in (0.8, 0.4, 0.0)
    ]
    i = np.arange(n)
    faces = [
        np.column_stack([a + i, a + (i + 1) % n, a + n + (i + 1) % n, a + n + i]) for a in (0, n)
    ]
    return PolygonMesh.from_faces(np.vstack(rings), np.vstack(faces).tolist())


@pytest.mark.parametrize("edges", [24, 36, 40, 48])
def test_a_slot_is_filled_as_both_of_its_mirrors_ask(source: PatternSource, edges: int) -> None:
    hole = max(find_holes(slot(edges, edges / 8)), key=lambda hole: -hole.length)
    mirrors = find_mirrors(hole.points, extract_neighbourhood(hole).regular_valence)
    assert len(mirrors) == 2
    fill = next(fill_holes(source, hole, twins=False))
    n_vertices = edges + len(fill.points)
    key = key_of(fill.local, n_vertices, edges)
    assert count_followed(fill.local, n_vertices, edges, key, mirrors) == 2


def test_each_of_two_mirrors_counts_and_of_more_any() -> None:
    assert [lose_by_mirrors(2, k) / ASYMMETRIC for k in range(3)] == [2, 1, 0]
    assert [lose_by_mirrors(8, k) / ASYMMETRIC for k in range(3)] == [1, 0, 0]
    assert lose_by_mirrors(0, 0) == 0
