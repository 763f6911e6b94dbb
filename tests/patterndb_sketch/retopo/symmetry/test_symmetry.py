"""Symmetry: the plane, the half of the surface, and the whole mesh of what is on it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import patterndb
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    fill_network,
    find_open_edges,
    weld_patches,
)
from patterndb_sketch.retopo.network import BORDER, Network, check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import (
    Half,
    MirroredMesh,
    Plane,
    begin_symmetry,
    cut_half,
    end_symmetry,
    mirror_mesh,
    propose_plane,
)
from patterndb_sketch.retopo.tools.stroke import insert_stroke_on_half
from patterndb_sketch.retopo.tracing import clean_stroke
from tests.support.retopo.networks import genus
from tests.support.retopo.symmetry import PLANES, X, ball, dome, empty, half, seam


def arc(plane: Plane, angle: float, begin: float = 0.0, end: float = 1.8) -> Points:
    """(n, 3) on the unit sphere, from the pole of a plane's side towards the plane and beyond."""
    up = np.array(plane.normal)
    one = np.cross(up, [0.3, 0.5, 0.1])
    one /= np.linalg.norm(one)
    side = np.cos(angle) * one + np.sin(angle) * np.cross(up, one)
    t = np.linspace(begin, end, 40)[:, None]
    return np.cos(t) * up + np.sin(t) * side


def quadrants(plane: Plane) -> tuple[Half, Sizes, Network]:
    """Four strokes on half of a sphere, from its pole across the plane."""
    at, sizes = half("ball", plane), Sizes.of(ball().diagonal)
    network = begin_symmetry(empty(ball(), sizes), at, sizes.sampling).network
    for k in range(4):
        stroke = clean_stroke(arc(plane, 0.5 * np.pi * k), ball(), sizes)
        edit = insert_stroke_on_half(network, at, sizes, stroke)
        assert "1 parts of the stroke beyond the plane are left out" in edit.notes
        network = edit.network
        check_network(network)
    return at, sizes, network


@cache
def filled(plane: Plane) -> tuple[FilledNetwork, MirroredMesh]:
    at, sizes, network = quadrants(plane)
    with patterndb.open() as source:
        found = fill_network(network, at.surface, source, 3.0 * sizes.edge)
    return found, mirror_mesh(weld_patches(found), found.network, plane)


def test_a_plane_says_what_is_wrong_with_it() -> None:
    with pytest.raises(InvalidRetopoError, match="not of length 1"):
        Plane(normal=(2.0, 0.0, 0.0))
    with pytest.raises(InvalidRetopoError, match="the normal not 0"):
        Plane.of((0, 0, 0), (0, 0, 0))
    with pytest.raises(InvalidRetopoError, match="finite"):
        Plane(point=(np.nan, 0.0, 0.0))


@given(st.lists(st.floats(-10, 10), min_size=6, max_size=6), st.integers(0, 2**32 - 1))
def test_mirroring_is_its_own_inverse_and_keeps_distances(six: list[float], seed: int) -> None:
    if np.linalg.norm(six[3:]) < 1e-3:
        return
    plane = Plane.of(six[:3], six[3:])
    points = np.random.default_rng(seed).normal(size=(20, 3))
    images = plane.mirror(points)
    np.testing.assert_allclose(plane.mirror(images), points, atol=1e-12)
    np.testing.assert_allclose(plane.heights(images), -plane.heights(points), atol=1e-12)
    np.testing.assert_allclose(
        np.linalg.norm(images[0] - images, axis=1),
        np.linalg.norm(points[0] - points, axis=1),
        atol=1e-12,
    )
    assert abs(plane.heights(plane.flatten(points))).max() < 1e-12
    assert plane.reversed.reversed == plane


def side_areas(surface: Surface, plane: Plane) -> float:
    """Area above a plane, by clipping every triangle as a polygon."""
    total = 0.0
    for corner in surface.vertices[surface.triangles]:
        height = plane.heights(corner)
        polygon: list[NDArray[np.float64]] = []
        for k in range(3):
            a, b = corner[k], corner[(k + 1) % 3]
            ha, hb = height[k], height[(k + 1) % 3]
            if ha >= 0.0:
                polygon.append(a)
            if ha * hb < 0.0:
                polygon.append(a + ha / (ha - hb) * (b - a))
        spokes = np.array(polygon[1:]).reshape(-1, 3) - (polygon[0] if polygon else 0.0)
        total += 0.5 * float(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]), axis=1).sum())
    return total


@PLANES
@pytest.mark.parametrize("name", ["ball", "dome"])
def test_the_half_is_what_is_above_the_plane(name: str, plane: Plane) -> None:
    at = half(name, plane)
    height = plane.heights(at.surface.vertices)
    assert height.min() > -1e-12
    assert abs(height[at.on]).max() < 1e-12
    assert (height[~at.on] > at.near).all()
    if plane is X:
        assert (height[at.on] == 0.0).all()
    np.testing.assert_allclose(at.surface.areas.sum(), side_areas(at.whole, plane), rtol=1e-6)
    # The seam is all of the border that the whole has not; its normals lie in the plane.
    border = len(at.surface.adjacency.border)
    runs = at.seams()
    assert all(at.on[run.vertices].all() for run in runs)
    edges = sum(len(run.vertices) - (not run.closed) for run in runs)
    assert (edges == border) == (name == "ball")
    assert abs(at.surface.normals[at.on] @ np.array(plane.normal)).max() < 1e-12


def test_a_plane_through_vertices_cuts_at_them() -> None:
    mesh = trimesh.creation.box()
    # Quadrants of the cube's faces, so that the plane passes edges, and along others.
    surface = Surface.from_arrays(*trimesh.remesh.subdivide(mesh.vertices, mesh.faces)[:2]).orient()
    at = cut_half(surface, X)
    assert at.surface.areas.sum() == pytest.approx(3.0)
    (run,) = at.seams()
    assert run.closed
    # A face in the plane is left out, and its rim is the seam.
    flush = cut_half(surface, Plane((-0.5, 0.0, 0.0)))
    assert flush.in_plane == 8
    assert flush.surface.areas.sum() == pytest.approx(5.0)
    assert [run.closed for run in flush.seams()] == [True]


def test_nothing_above_the_plane_is_refused() -> None:
    with pytest.raises(RefusedError, match="turn the normal round"):
        cut_half(ball(), Plane((2.0, 0.0, 0.0)))
    apart = cut_half(ball(), Plane((-2.0, 0.0, 0.0)))
    assert apart.seams() == []
    edit = begin_symmetry(Network(), apart, 0.01)
    assert edit.notes == ("the plane does not cut the surface: its image lies apart",)


@PLANES
def test_four_quadrants_make_a_closed_sphere(plane: Plane) -> None:
    found, both = filled(plane)
    assert found.notes == ()
    assert len(found.network.patches) == 4
    mesh = both.mesh
    assert len(find_open_edges(mesh)) == 0
    assert len(both.pinched) == 0
    assert len(mesh.vertices) - 2 * len(mesh.quads) + len(mesh.quads) == 2
    # Every vertex has its image, and the quads' images are quads.
    assert (both.image[both.image] == np.arange(len(mesh.vertices))).all()
    np.testing.assert_allclose(
        plane.mirror(mesh.vertices), mesh.vertices[both.image], rtol=0.0, atol=1e-12
    )
    own = both.image == np.arange(len(mesh.vertices))
    assert abs(plane.heights(mesh.vertices[own])).max() < 1e-12
    if plane is X:
        assert (plane.mirror(mesh.vertices) == mesh.vertices[both.image]).all()
        assert (mesh.vertices[own, 0] == 0.0).all()

    def cycles(quads: NDArray[np.int32]) -> set[tuple[int, ...]]:
        first = quads.argmin(axis=1)[:, None]
        return set(map(tuple, np.take_along_axis(quads, (first + np.arange(4)) % 4, 1).tolist()))

    assert cycles(both.image[mesh.quads[:, ::-1]]) == cycles(mesh.quads)
    triangles = np.concatenate([mesh.quads[:, :3], mesh.quads[:, [0, 2, 3]]])
    whole = trimesh.Trimesh(mesh.vertices, triangles, process=False)
    assert whole.is_winding_consistent
    assert whole.volume > 0.0


@PLANES
def test_off_keeps_both_halves_and_on_again_the_one(plane: Plane) -> None:
    found, both = filled(plane)
    half_now, sizes = half("ball", plane), Sizes.of(ball().diagonal)
    off = end_symmetry(found.network, ball(), sizes, plane).network
    check_network(off)
    assert genus(off) == 0
    assert seam(off) == []
    assert len(off.patches) == 2 * len(found.network.patches)
    for patch in found.network.patches:
        assert off.patches[patch] == found.network.patches[patch] or (
            off.patches[patch].loop == found.network.patches[patch].loop
        )
    # Counts and fills suit the images: nothing is chosen anew.
    with patterndb.open() as source:
        again = fill_network(off, ball(), source, 3.0 * sizes.edge)
    assert again.network is off
    mesh = weld_patches(again)
    assert (len(mesh.vertices), len(mesh.quads)) == (len(both.mesh.vertices), len(both.mesh.quads))
    assert len(find_open_edges(mesh)) == 0
    # The images of patches have the images' shapes: on a sphere, to how evenly it is cut.
    if plane is X:
        off_by = np.linalg.norm(mesh.vertices[:, None] - both.mesh.vertices[None], axis=2).min(1)
        assert off_by.max() < 0.01
    edit = begin_symmetry(off, half_now, sizes.sampling)
    back = edit.network
    check_network(back)
    assert any("4 curves on the other side" in note for note in edit.notes)
    assert back.chains.keys() == found.network.chains.keys()
    assert back.patches.keys() == found.network.patches.keys()
    for chain in back.chains.values():
        old = found.network.chains[chain.id]
        assert (chain.marks, chain.count) == (old.marks, old.count)
        assert (chain.points == old.points).all()
    assert all(back.patches[p].choice == found.network.patches[p].choice for p in back.patches)


def test_an_open_surface_has_borders_and_a_seam_between_them() -> None:
    surface, sizes = dome(), Sizes.of(dome().diagonal)
    at = half("dome", X)
    network = begin_symmetry(empty(surface, sizes), at, sizes.sampling).network
    check_network(network)
    (one,) = seam(network)
    assert {network.chains[one].start, network.chains[one].end} == set(network.nodes)
    stroke = np.array([[np.sin(t), 0.0, np.cos(t)] for t in np.linspace(-0.3, 1.7, 60)])
    network = insert_stroke_on_half(
        network, at, sizes, clean_stroke(stroke, surface, sizes)
    ).network
    check_network(network)
    assert genus(network) == 0
    assert len(network.patches) == 2
    with patterndb.open() as source:
        found = fill_network(network, at.surface, source, 3.0 * sizes.edge)
    both = mirror_mesh(weld_patches(found), found.network, X)
    # A disk: its border is that of the dome, all around.
    mesh, rim = both.mesh, find_open_edges(both.mesh)
    edges = (4 * len(mesh.quads) + len(rim)) // 2
    assert len(mesh.vertices) - edges + len(mesh.quads) == 1
    lines = [c for c in found.network.chains.values() if BORDER in c.marks]
    ends = {node for line in lines for node in (line.start, line.end)}
    on_border = np.isin(mesh.chain, [c.id for c in lines]) | np.isin(mesh.node, sorted(ends))
    assert set(rim.ravel().tolist()) <= set(np.flatnonzero(on_border).tolist())
    off = end_symmetry(found.network, surface, sizes, X).network
    check_network(off)
    assert genus(off) == 0
    assert len(off.patches) == 4
    back = begin_symmetry(off, at, sizes.sampling).network
    check_network(back)
    assert back.chains.keys() == found.network.chains.keys()


def test_an_edge_from_seam_to_seam_is_told() -> None:
    at, sizes, network = quadrants(X)
    with patterndb.open() as source:
        found = fill_network(network, at.surface, source, 3.0 * sizes.edge)
    mesh = weld_patches(found)
    assert len(mirror_mesh(mesh, found.network, X).pinched) == 0
    # The same with both ends of one edge, from the inside of a patch, put on the seam.
    inner = next(
        quad for quad in mesh.quads.tolist() if all(mesh.chain[v] == mesh.node[v] for v in quad)
    )
    mesh.chain[inner[:2]] = seam(found.network)[0]
    assert mirror_mesh(mesh, found.network, X).pinched.tolist() == [sorted(inner[:2])]


def test_the_plane_of_a_turned_surface_is_found() -> None:
    """A body that is symmetric in one plane only, turned and moved at random."""
    rng = np.random.default_rng(3)
    body = trimesh.creation.icosphere(subdivisions=3)
    x, y, z = body.vertices.T
    points = np.stack([x, 1.5 * y + 0.4 * z**2 + 0.3 * x**2, 2.2 * z + 0.5 * y**3], axis=1)
    for _ in range(4):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        turn *= np.sign(np.linalg.det(turn))
        shift = 5.0 * rng.normal(size=3)
        found = propose_plane(Surface.from_arrays(points @ turn.T + shift, body.faces).orient())
        assert found.off < 1e-3
        assert abs(turn[:, 0] @ np.array(found.plane.normal)) > 1.0 - 1e-4
        assert abs(found.plane.heights(shift[None])[0]) < 1e-2
    # In place, it is exactly the plane of the axes; a body without any is far off.
    assert propose_plane(Surface.from_arrays(points, body.faces).orient()).plane == X
    crooked = points + 0.4 * np.stack([z * y, x * z, 0.0 * x], axis=1)
    assert propose_plane(Surface.from_arrays(crooked, body.faces).orient()).off > 0.005


@pytest.mark.parametrize("thick", [0.0, 0.01])
def test_the_plane_that_a_sheet_lies_in_is_no_symmetry(thick: float) -> None:
    sheet = trimesh.creation.box((2.0, 1.0, thick or 1.0)).subdivide().subdivide()
    points = np.array(sheet.vertices)
    # Not symmetric in any other plane than its own.
    points[:, 0] += 0.3 * points[:, 1] + 0.2 * points[:, 1] ** 2
    faces = sheet.faces
    if not thick:
        faces = faces[(points[faces][:, :, 2] > 0.49).all(axis=1)]
        points[:, 2] = 0.0
    found = propose_plane(Surface.from_arrays(points, faces).orient())
    assert abs(found.plane.normal[2]) < 0.5 and not found.symmetric
