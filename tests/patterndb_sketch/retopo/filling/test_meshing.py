"""Filled patches welded to one mesh, and the report of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.filling import (
    fill_network,
    find_irregular_vertices,
    find_open_edges,
    weld_patches,
)
from patterndb_sketch.retopo.filling.report import hausdorff, report_mesh
from patterndb_sketch.retopo.network import Network
from query.engine import PatternSource
from tests.support.retopo.editors import (
    do,
    drawn_grid,
    drawn_octants,
    line,
    same_arrays,
)
from tests.support.retopo.filling import EDGE, assert_welded, edges_of
from tests.support.retopo.networks import plane


def on_one_side(network: Network, chain: int) -> bool:
    """Is there one patch beside a chain?"""
    taken = network.patch_of()
    return (2 * chain in taken) != (2 * chain + 1 in taken)


def test_neighbours_share_their_vertices(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (0.5, 1), (0.5, 1.5), (1, 2)))
    found = editor.fill()
    mesh = weld_patches(found)
    assert_welded(found, mesh)
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices), "none is there twice"
    edges = edges_of(mesh)
    once = [e for e in edges if e[::-1] not in edges]
    outer = {c for c in found.network.chains if on_one_side(found.network, c)}
    around = sum(found.network.chains[c].count for c in outer)
    assert len(once) == len(find_open_edges(mesh)) == around > 40
    n_edges = (len(edges) + len(once)) // 2
    assert len(mesh.vertices) - n_edges + len(mesh.quads) == 1
    nodes = found.network.nodes
    for v in np.flatnonzero(mesh.node >= 0).tolist():
        assert same_arrays(mesh.vertices[v], nodes[int(mesh.node[v])].point)
    assert ((mesh.node >= 0) & (mesh.chain >= 0)).sum() == 0
    on_chains = sum(found.network.chains[c].count - 1 for c in set(mesh.chain.tolist()) - {-1})
    assert (mesh.chain >= 0).sum() == on_chains


def test_a_ball_of_eight_patches_is_closed(source: PatternSource) -> None:
    editor = drawn_octants(source)
    found = editor.fill()
    mesh = weld_patches(found)
    assert_welded(found, mesh)
    edges = edges_of(mesh)
    assert {(b, a) for a, b in edges} == edges
    assert len(find_open_edges(mesh)) == 0
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.quads) == 2
    feet = editor.surface.nearest(mesh.vertices).points
    assert np.linalg.norm(feet - mesh.vertices, axis=1).max() < 1e-9
    assert all(len(placed.flipped) == 0 for placed in found.placed.values())
    wrong, valence = find_irregular_vertices(mesh)
    assert valence.tolist() == [3] * 8
    assert (mesh.node[wrong] == -1).all()
    told = report_mesh(found, editor.surface, mesh)
    assert (told.patches, told.unfilled, told.irregular) == ({3: 8}, 0, {3: 8})
    assert (told.flipped, told.open_edges, told.tangled, told.euler) == (0, 0, 0, 2)
    assert (told.vertices, told.quads) == (len(mesh.vertices), len(mesh.quads))
    assert 0.0 < told.to_surface < 0.002


def test_an_empty_network_is_an_empty_mesh(source: PatternSource) -> None:
    found = fill_network(Network(), plane(), source, EDGE)
    mesh = weld_patches(found)
    assert (mesh.vertices.shape, mesh.quads.shape) == ((0, 3), (0, 4))
    told = report_mesh(found, plane())
    assert (told.patches, told.quads, told.euler, told.to_surface) == ({}, 0, 0, 1.0)


def test_distances_of_known_shapes() -> None:
    box = trimesh.creation.box((2, 2, 2))
    surface = Surface.from_arrays(box.vertices, box.faces).orient()
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    assert hausdorff(corner, quads, surface) == pytest.approx((0.0, 0.0), abs=1e-15)
    diagonal = 2 * np.sqrt(3)
    out, back = hausdorff(corner * 1.25, quads, surface)
    assert out == pytest.approx(0.25 * np.sqrt(3) / diagonal)
    assert back == pytest.approx(0.25 / diagonal)
    # The top alone is 2 from the bottom.
    assert hausdorff(corner, quads[5:], surface) == pytest.approx((0.0, 2 / diagonal))
    assert hausdorff(corner, quads[:0], surface) == (1.0, 1.0)


def test_quads_that_pass_an_edge_the_same_way_are_told(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    found = editor.fill()
    mesh = weld_patches(found)
    doubled = replace(
        mesh,
        quads=np.concatenate([mesh.quads, mesh.quads[:1]]),
        patch=np.concatenate([mesh.patch, mesh.patch[:1]]),
    )
    assert report_mesh(found, editor.surface, mesh).tangled == 0
    assert report_mesh(found, editor.surface, doubled).tangled > 0
