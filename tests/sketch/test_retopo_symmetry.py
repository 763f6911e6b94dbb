"""Symmetry: the half of the ground, the seam, strokes on it, and the whole mesh."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from retopo_cases import genus

import patterndb
from query.placing.surface import Points
from sketch.retopo.errors import InvalidRetopoError, RefusedError
from sketch.retopo.filling import FilledNetwork, completed, open_edges, welded
from sketch.retopo.ground import Ground, Stroke, cleaned
from sketch.retopo.network import (
    BORDER,
    SYMMETRY,
    AtNode,
    Network,
    add_chain,
    check,
    with_borders,
)
from sketch.retopo.sizes import Sizes
from sketch.retopo.symmetry import (
    Half,
    MirroredMesh,
    Plane,
    half_of,
    insert_on_half,
    mirrored,
    parted,
    proposed,
    refuse_beyond,
    with_symmetry,
    without_symmetry,
)

X = Plane()
TILTED = Plane.of((0.3, 0.3, -0.3), (1.0, 2.0, 3.0))
PLANES = pytest.mark.parametrize("plane", [X, TILTED], ids=["x", "tilted"])


def turned(mesh: trimesh.Trimesh) -> Ground:
    """A mesh turned, so that no vertex is on a plane by chance."""
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3]))
    return Ground.of(mesh.vertices, mesh.faces)


@cache
def ball() -> Ground:
    return turned(trimesh.creation.icosphere(subdivisions=3))


@cache
def dome() -> Ground:
    """The upper half of the unit sphere, with a border near z = 0."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    kept = mesh.vertices[mesh.faces][:, :, 2].min(axis=1) > -1e-9
    return Ground.of(mesh.vertices, mesh.faces[kept])


@cache
def half(name: str, plane: Plane) -> Half:
    return half_of({"ball": ball, "dome": dome}[name](), plane)


def empty(ground: Ground, sizes: Sizes) -> Network:
    return with_borders(Network(longest=4.0 * ground.diagonal), ground, sizes.sampling)


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
    network = with_symmetry(empty(ball(), sizes), at, sizes.sampling).network
    for k in range(4):
        stroke = cleaned(arc(plane, 0.5 * np.pi * k), ball(), sizes)
        edit = insert_on_half(network, at, sizes, stroke)
        assert "1 parts of the stroke beyond the plane are left out" in edit.notes
        network = edit.network
        check(network)
    return at, sizes, network


def seam(network: Network) -> list[int]:
    return [chain.id for chain in network.chains.values() if SYMMETRY in chain.marks]


@cache
def filled(plane: Plane) -> tuple[FilledNetwork, MirroredMesh]:
    at, sizes, network = quadrants(plane)
    with patterndb.open() as source:
        found = completed(network, at.ground, source, 3.0 * sizes.edge)
    return found, mirrored(welded(found), found.network, plane)


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
    images = plane.mirrored(points)
    np.testing.assert_allclose(plane.mirrored(images), points, atol=1e-12)
    np.testing.assert_allclose(plane.heights(images), -plane.heights(points), atol=1e-12)
    np.testing.assert_allclose(
        np.linalg.norm(images[0] - images, axis=1),
        np.linalg.norm(points[0] - points, axis=1),
        atol=1e-12,
    )
    assert abs(plane.heights(plane.flattened(points))).max() < 1e-12
    assert plane.reversed.reversed == plane


def side_areas(ground: Ground, plane: Plane) -> float:
    """Area above a plane, by clipping every triangle as a polygon."""
    total = 0.0
    for corner in ground.vertices[ground.triangles]:
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
    height = plane.heights(at.ground.vertices)
    assert height.min() > -1e-12
    assert abs(height[at.on]).max() < 1e-12
    assert (height[~at.on] > at.near).all()
    if plane is X:
        assert (height[at.on] == 0.0).all()
    np.testing.assert_allclose(
        at.ground.surface.areas.sum(), side_areas(at.whole, plane), rtol=1e-6
    )
    # The seam is all of the border that the whole has not; its normals lie in the plane.
    border = len(at.ground.topology.border)
    runs = at.seams()
    assert all(at.on[run.vertices].all() for run in runs)
    edges = sum(len(run.vertices) - (not run.closed) for run in runs)
    assert (edges == border) == (name == "ball")
    assert abs(at.ground.normals[at.on] @ np.array(plane.normal)).max() < 1e-12


def test_a_plane_through_vertices_cuts_at_them() -> None:
    mesh = trimesh.creation.box()
    # Quadrants of the cube's faces, so that the plane passes edges, and along others.
    ground = Ground.of(*trimesh.remesh.subdivide(mesh.vertices, mesh.faces)[:2])
    at = half_of(ground, X)
    assert at.ground.surface.areas.sum() == pytest.approx(3.0)
    (run,) = at.seams()
    assert run.closed
    # A face in the plane is left out, and its rim is the seam.
    flush = half_of(ground, Plane((-0.5, 0.0, 0.0)))
    assert flush.in_plane == 8
    assert flush.ground.surface.areas.sum() == pytest.approx(5.0)
    assert [run.closed for run in flush.seams()] == [True]


def test_nothing_above_the_plane_is_refused() -> None:
    with pytest.raises(RefusedError, match="turn the normal round"):
        half_of(ball(), Plane((2.0, 0.0, 0.0)))
    apart = half_of(ball(), Plane((-2.0, 0.0, 0.0)))
    assert apart.seams() == []
    edit = with_symmetry(Network(), apart, 0.01)
    assert edit.notes == ("the plane does not cut the surface: its image lies apart",)


@PLANES
def test_four_quadrants_make_a_closed_sphere(plane: Plane) -> None:
    found, both = filled(plane)
    assert found.notes == ()
    assert len(found.network.patches) == 4
    mesh = both.mesh
    assert len(open_edges(mesh)) == 0
    assert len(both.pinched) == 0
    assert len(mesh.vertices) - 2 * len(mesh.quads) + len(mesh.quads) == 2
    # Every vertex has its image, and the quads' images are quads.
    assert (both.image[both.image] == np.arange(len(mesh.vertices))).all()
    np.testing.assert_allclose(
        plane.mirrored(mesh.vertices), mesh.vertices[both.image], rtol=0.0, atol=1e-12
    )
    own = both.image == np.arange(len(mesh.vertices))
    assert abs(plane.heights(mesh.vertices[own])).max() < 1e-12
    if plane is X:
        assert (plane.mirrored(mesh.vertices) == mesh.vertices[both.image]).all()
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
    off = without_symmetry(found.network, ball(), sizes, plane).network
    check(off)
    assert genus(off) == 0
    assert seam(off) == []
    assert len(off.patches) == 2 * len(found.network.patches)
    for patch in found.network.patches:
        assert off.patches[patch] == found.network.patches[patch] or (
            off.patches[patch].loop == found.network.patches[patch].loop
        )
    # Counts and fills suit the images: nothing is chosen anew.
    with patterndb.open() as source:
        again = completed(off, ball(), source, 3.0 * sizes.edge)
    assert again.network is off
    mesh = welded(again)
    assert (len(mesh.vertices), len(mesh.quads)) == (len(both.mesh.vertices), len(both.mesh.quads))
    assert len(open_edges(mesh)) == 0
    # The images of patches have the images' shapes: on a sphere, to how evenly it is cut.
    if plane is X:
        off_by = np.linalg.norm(mesh.vertices[:, None] - both.mesh.vertices[None], axis=2).min(1)
        assert off_by.max() < 0.01
    edit = with_symmetry(off, half_now, sizes.sampling)
    back = edit.network
    check(back)
    assert any("4 curves on the other side" in note for note in edit.notes)
    assert back.chains.keys() == found.network.chains.keys()
    assert back.patches.keys() == found.network.patches.keys()
    for chain in back.chains.values():
        old = found.network.chains[chain.id]
        assert (chain.marks, chain.count) == (old.marks, old.count)
        assert (chain.points == old.points).all()
    assert all(back.patches[p].choice == found.network.patches[p].choice for p in back.patches)


def test_an_open_surface_has_borders_and_a_seam_between_them() -> None:
    ground, sizes = dome(), Sizes.of(dome().diagonal)
    at = half("dome", X)
    network = with_symmetry(empty(ground, sizes), at, sizes.sampling).network
    check(network)
    (one,) = seam(network)
    assert {network.chains[one].start, network.chains[one].end} == set(network.nodes)
    stroke = np.array([[np.sin(t), 0.0, np.cos(t)] for t in np.linspace(-0.3, 1.7, 60)])
    network = insert_on_half(network, at, sizes, cleaned(stroke, ground, sizes)).network
    check(network)
    assert genus(network) == 0
    assert len(network.patches) == 2
    with patterndb.open() as source:
        found = completed(network, at.ground, source, 3.0 * sizes.edge)
    both = mirrored(welded(found), found.network, X)
    # A disk: its border is that of the dome, all around.
    mesh, rim = both.mesh, open_edges(both.mesh)
    edges = (4 * len(mesh.quads) + len(rim)) // 2
    assert len(mesh.vertices) - edges + len(mesh.quads) == 1
    lines = [c for c in found.network.chains.values() if BORDER in c.marks]
    ends = {node for line in lines for node in (line.start, line.end)}
    on_border = np.isin(mesh.chain, [c.id for c in lines]) | np.isin(mesh.node, sorted(ends))
    assert set(rim.ravel().tolist()) <= set(np.flatnonzero(on_border).tolist())
    off = without_symmetry(found.network, ground, sizes, X).network
    check(off)
    assert genus(off) == 0
    assert len(off.patches) == 4
    back = with_symmetry(off, at, sizes.sampling).network
    check(back)
    assert back.chains.keys() == found.network.chains.keys()


def test_curves_drawn_before_are_cut_and_told() -> None:
    sizes = Sizes.of(ball().diagonal)
    at = half("ball", X)
    t = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    network = empty(ball(), sizes)
    drawn: list[int] = []
    for level, radius in ((0.5, 1.0), (0.0, 1.0)):
        circle = np.stack([radius * np.cos(t), radius * np.sin(t), 0.0 * t + level], axis=1)
        stroke = cleaned(circle, ball(), sizes, True)
        edit = insert_on_half(network, half_of(ball(), Plane((-9.0, 0.0, 0.0))), sizes, stroke)
        network = edit.network
        drawn += edit.chains
    # One on the far side alone, and one on the near side alone.
    for x in (-0.8, 0.8):
        small = np.stack([0.0 * t + x, 0.3 * np.cos(t), 0.3 * np.sin(t) + 0.7], axis=1)
        far = cleaned(small / np.linalg.norm(small, axis=1)[:, None], ball(), sizes, True)
        network = insert_on_half(
            network, half_of(ball(), Plane((-9.0, 0.0, 0.0))), sizes, far
        ).network
    before = network
    edit = with_symmetry(network, at, sizes.sampling)
    check(edit.network)
    assert genus(edit.network) == 0
    assert any(note.startswith("2 curves are cut at the plane") for note in edit.notes), edit.notes
    for chain in edit.network.chains.values():
        assert at.plane.heights(chain.points).min() > -1e-12
    for chain in seam(edit.network):
        assert abs(at.plane.heights(edit.network.chains[chain].points)).max() == 0.0
    # What is on the near side alone is as it was.
    same = edit.network.chains.keys() & before.chains.keys()
    assert same
    assert all(edit.network.chains[c] is before.chains[c] for c in same)
    with pytest.raises(RefusedError, match="on already"):
        with_symmetry(edit.network, at, sizes.sampling)
    with pytest.raises(RefusedError, match="off already"):
        without_symmetry(before, ball(), sizes, X)


def test_two_curves_across_one_place_are_refused() -> None:
    sizes = Sizes.of(ball().diagonal)
    network = empty(ball(), sizes)
    up = np.array([0.0, 0.0, 1.0])
    for shift in (0.0, 0.3):
        line = np.array([[-0.2, -shift, 1.0], [0.0, 0.0, 1.0], [0.2, shift, 1.0]])
        network, _ = add_chain(network, line, np.tile(up, (3, 1)))
    with pytest.raises(RefusedError, match="at one place"):
        with_symmetry(network, half("ball", X), sizes.sampling)


def test_closed_strokes_become_open_and_end_on_the_plane() -> None:
    sizes, at = Sizes.of(ball().diagonal), half("ball", X)
    t = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    wave = 0.3 * np.sin(3.0 * t)
    circle = np.stack([np.cos(t), np.sin(t), wave], axis=1)
    circle /= np.linalg.norm(circle, axis=1)[:, None]
    stroke = cleaned(circle, ball(), sizes, True)
    found = parted(stroke, at, sizes)
    assert (len(found.parts), found.beyond) == (1, 1)
    (part,) = found.parts
    assert not part.stroke.closed
    assert part.on == (True, True)
    assert (part.stroke.points[[0, -1], 0] == 0.0).all()
    assert part.stroke.points[:, 0].min() == 0.0
    # One that does not cross stays closed; one beyond is nothing.
    small = np.stack([0.0 * t + 0.8, 0.3 * np.cos(t), 0.3 * np.sin(t)], axis=1)
    near = cleaned(small, ball(), sizes, True)
    assert [part.stroke.closed for part in parted(near, at, sizes).parts] == [True]
    far = cleaned(small * [-1.0, 1.0, 1.0], ball(), sizes, True)
    assert parted(far, at, sizes).parts == ()
    network = with_symmetry(empty(ball(), sizes), at, sizes.sampling).network
    with pytest.raises(RefusedError, match="other side of the plane"):
        insert_on_half(network, at, sizes, far)
    with pytest.raises(RefusedError, match="the spine crosses the plane"):
        refuse_beyond(stroke, at, "the spine")
    refuse_beyond(near, at, "the spine")


def test_a_stroke_along_the_plane_is_none() -> None:
    sizes, at = Sizes.of(ball().diagonal), half("ball", X)
    t = np.linspace(0.3, 1.5, 80)
    line = np.stack([0.2 * sizes.snap * np.sin(40.0 * t), np.cos(t), np.sin(t)], axis=1)
    stroke = Stroke(line, line.copy(), False)
    found = parted(stroke, at, sizes)
    assert found.parts == ()
    assert found.along > 3


def test_an_edge_from_seam_to_seam_is_told() -> None:
    at, sizes, network = quadrants(X)
    # All curves with one edge: between the strokes every edge beside the seam ends on it.
    with patterndb.open() as source:
        found = completed(network, at.ground, source, 3.0 * sizes.edge)
    mesh = welded(found)
    lines = [c for c in found.network.chains.values() if c.id in set(seam(found.network))]
    nodes = {node for line in lines for node in (line.start, line.end)}
    assert all(AtNode(node).node in found.network.nodes for node in nodes)
    assert len(mirrored(mesh, found.network, X).pinched) == 0
    # The same with every vertex of one quad's edge put on the seam.
    inner = next(
        quad for quad in mesh.quads.tolist() if all(mesh.chain[v] == mesh.node[v] for v in quad)
    )
    mesh.chain[inner[:2]] = lines[0].id
    assert mirrored(mesh, found.network, X).pinched.tolist() == [sorted(inner[:2])]


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["ball", "dome"]), st.booleans())
def test_random_strokes_keep_all_that_holds(seed: int, name: str, tilted: bool) -> None:
    """Strokes before, on the half, off and on again: the invariants hold, and nothing is lost."""
    rng = np.random.default_rng(seed)
    plane = TILTED if tilted else X
    at = half(name, plane)
    sizes = Sizes.of(at.whole.diagonal)
    whole = half_of(at.whole, Plane((-9.0, 0.0, 0.0)))

    def scribble() -> Stroke:
        places = rng.normal(size=(rng.integers(2, 5), 3))
        if name == "dome":
            places[:, 2] = np.abs(places[:, 2]) + 0.1
        t = np.linspace(0.0, len(places) - 1.0, 60)
        line = np.stack([np.interp(t, np.arange(len(places)), places[:, d]) for d in range(3)], 1)
        line /= np.linalg.norm(line, axis=1)[:, None]
        # A closed one of two places would run back upon itself.
        return cleaned(line, at.whole, sizes, len(places) > 2 and bool(rng.integers(2)))

    network = empty(at.whole, sizes)
    for _ in range(2):
        network = insert_on_half(network, whole, sizes, scribble()).network
    network = with_symmetry(network, at, sizes.sampling).network
    for _ in range(3):
        check(network)
        assert genus(network) == 0
        for chain in network.chains.values():
            height = plane.heights(chain.points)
            assert height.min() > -1e-9
            if SYMMETRY in chain.marks:
                assert abs(height).max() < 1e-12
        try:
            network = insert_on_half(network, at, sizes, scribble()).network
        except RefusedError:
            continue
    edit = without_symmetry(network, at.whole, sizes, plane)
    off = edit.network
    check(off, patches=False)
    assert genus(off) == 0
    assert network.chains.keys() <= off.chains.keys()
    if name == "ball":
        assert edit.notes == ()
        assert len(off.patches) == 2 * len(network.patches)
    back = with_symmetry(off, at, sizes.sampling).network
    check(back, patches=False)
    if edit.notes:
        # The dome has no place for all images beyond a tilted plane.
        assert "left out" in edit.notes[0]
        return
    assert back.chains.keys() == network.chains.keys()
    assert all((back.chains[c].points == network.chains[c].points).all() for c in network.chains)


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
        found = proposed(Ground.of(points @ turn.T + shift, body.faces))
        assert found.off < 1e-3
        assert abs(turn[:, 0] @ np.array(found.plane.normal)) > 1.0 - 1e-4
        assert abs(found.plane.heights(shift[None])[0]) < 1e-2
    # In place, it is exactly the plane of the axes; a body without any is far off.
    assert proposed(Ground.of(points, body.faces)).plane == X
    crooked = points + 0.4 * np.stack([z * y, x * z, 0.0 * x], axis=1)
    assert proposed(Ground.of(crooked, body.faces)).off > 0.005
