"""Placing on surfaces: vertices on it, nothing flipped, never through to the back."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.geometry.casting import first_along
from patterndb._native.geometry.proximity import nearest
from patterndb._native.geometry.tree import build
from patterndb.errors import InvalidBoundaryError, InvalidMeshError
from query.placing import Surface, enclose_region, place
from tests.support.query.placing import CONVEX, grid, parallel, polygon, sphere, widened

SPHERE = sphere()


def far_from_sphere(vertices: np.ndarray) -> float:
    """The greatest distance of points from the sphere's triangles, triangle by triangle."""
    corner = SPHERE.vertices[SPHERE.triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # The sphere is convex: its distance is that to the outermost plane, if inside.
    height = vertices @ normal.T - (normal * corner[:, 0]).sum(axis=1)
    return float(np.abs(height.max(axis=1)).max())


class TestOnASphere:
    @settings(max_examples=25, deadline=None)
    @given(
        st.sampled_from([p for p in range(len(CONVEX)) if CONVEX[p].n_sides > 2]),
        st.integers(0, 2**32),
        st.floats(-25.0, 80.0),
    )
    def test_caps(self, number: int, seed: int, latitude: float) -> None:
        fill = widened(CONVEX[number], random.Random(seed), 3)
        if fill is None or fill.n_quads > 300:
            return
        points = parallel(SPHERE, fill.perimeter, latitude)
        placed = place(fill, points, SPHERE)
        assert (placed.vertices[: fill.perimeter] == points).all()
        inner = placed.vertices[fill.perimeter :]
        if len(inner):
            assert far_from_sphere(inner) < 1e-6
            assert placed.off_surface < 1e-6
        assert placed.region_share is not None
        wanted = (1.0 - np.sin(np.radians(latitude))) / 2.0
        assert placed.region_share == pytest.approx(wanted, abs=0.12)
        if placed.at_rest:
            # The side that the boundary encloses, not the one beneath.
            assert inner[:, 2].min(initial=1.0) > points[:, 2].min() - 0.2

    @pytest.mark.parametrize("latitude", [-20.0, 0.0, 30.0, 70.0])
    def test_a_grid_over_a_cap_does_not_flip_and_rests(self, latitude: float) -> None:
        fill = grid(8, 8)
        points = parallel(SPHERE, fill.perimeter, latitude)
        placed = place(fill, points, SPHERE)
        assert len(placed.flipped) == 0
        assert placed.at_rest and placed.rounds > 0
        assert placed.vertices[:, 2].max() > 0.99
        again = place(fill, points, enclose_region(SPHERE, points))
        assert (again.vertices == placed.vertices).all()

    def test_turned_about_it_covers_the_rest(self) -> None:
        points = parallel(SPHERE, 16, 40.0)
        one, other = enclose_region(SPHERE, points), enclose_region(SPHERE, points[::-1])
        assert one.separates and other.separates
        crossed = len(one.surface.triangles) + len(other.surface.triangles)
        assert one.share < 0.3 and other.share > 0.75
        assert len(SPHERE.triangles) < crossed < 1.2 * len(SPHERE.triangles)


class TestEnclosing:
    def test_a_cylinder_cut_round_is_two_pieces(self) -> None:
        turn = 2.0 * np.pi * np.arange(24) / 24
        rings = [np.stack([np.cos(turn), np.sin(turn), np.full(24, z)], 1) for z in range(6)]
        i = np.arange(24)
        quads = [
            np.stack([24 * r + i, 24 * r + (i + 1) % 24, 24 * r + 24 + (i + 1) % 24], 1)
            for r in range(5)
        ] + [
            np.stack([24 * r + i, 24 * r + 24 + (i + 1) % 24, 24 * r + 24 + i], 1) for r in range(5)
        ]
        tube = Surface.from_arrays(np.concatenate(rings), np.concatenate(quads))
        loop = tube.nearest(np.c_[rings[0][:, :2], np.full(24, 2.5)]).points
        region = enclose_region(tube, loop)
        assert region.separates
        heights = region.surface.vertices[region.surface.triangles][..., 2]
        assert heights.min() == 2.0 and heights.max() == 5.0

    def test_round_a_handle_nothing_is_enclosed(self) -> None:
        u, v = np.meshgrid(np.arange(24), np.arange(12), indexing="ij")
        a, b = 2.0 * np.pi * u / 24, 2.0 * np.pi * v / 12
        points = np.stack(
            [(3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)], axis=-1
        )
        name = 12 * u + v
        one, two = np.roll(name, -1, 0), np.roll(name, -1, 1)
        both = np.roll(one, -1, 1)
        halves = [np.stack([name, one, both], -1), np.stack([name, both, two], -1)]
        faces = np.concatenate(halves).reshape(-1, 3)
        torus = Surface.from_arrays(points.reshape(-1, 3), faces)
        around = torus.nearest(points[5] + 0.01).points
        region = enclose_region(torus, around)
        assert not region.separates and region.share == 1.0
        assert len(region.surface.triangles) == len(faces)


class TestTree:
    def test_against_all_triangles(self) -> None:
        rng = np.random.default_rng(1)
        corners = rng.normal(size=(60, 1, 3)) + 0.4 * rng.normal(size=(60, 3, 3))
        points = 1.5 * rng.normal(size=(80, 3))
        triangle, weights = nearest(corners, *build(corners), points)
        assert (weights >= -1e-12).all() and np.allclose(weights.sum(axis=1), 1.0)
        found = np.linalg.norm(np.einsum("ne,nec->nc", weights, corners[triangle]) - points, axis=1)
        # Brute force: a fine net of points on every triangle can come no nearer.
        net = np.array([(i, j) for i in range(41) for j in range(41 - i)]) / 40.0
        net = np.c_[1.0 - net.sum(axis=1), net]
        on = np.einsum("me,tec->tmc", net, corners).reshape(-1, 3)
        best = np.linalg.norm(points[:, None] - on, axis=2).min(axis=1)
        assert (found <= best + 1e-12).all() and (found >= best - 0.1).all()

    @settings(max_examples=60, deadline=None)
    @given(st.integers(0, 2**32), st.sampled_from([0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2]))
    def test_triangles_of_little_or_no_area(self, seed: int, width: float) -> None:
        rng = np.random.default_rng(seed)
        a, b = rng.normal(size=(2, 3))
        # Its third corner on the line of the others, between them or beyond, but for a width.
        c = a + rng.choice([0.0, 1.0, rng.uniform(-0.5, 1.5)]) * (b - a)
        corners = np.stack([a, b, c + width * rng.normal(size=3)])
        points = np.r_[rng.normal(size=(40, 3)), 100.0 * rng.normal(size=(10, 3))]
        points = np.r_[points, a + rng.uniform(size=(40, 1)) * (b - a)]
        found, weights = nearest(corners[None], *build(corners[None]), points)
        assert (found == 0).all()
        assert (weights >= -1e-12).all() and np.allclose(weights.sum(axis=1), 1.0, atol=1e-12)
        off = np.linalg.norm(weights @ corners - points, axis=1)
        # No further than the nearest of the edges' points, no nearer than that less the width.
        edge = np.full(len(points), np.inf)
        for tail, head in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            along = head - tail
            size = along @ along
            share = np.clip((points - tail) @ along / size, 0.0, 1.0) if size else 0.0 * edge
            on = tail + np.where(np.isfinite(share), share, 0.0)[:, None] * along
            edge = np.minimum(edge, np.linalg.norm(on - points, axis=1))
        assert (off <= edge + 1e-11).all()
        assert (off >= edge - 4.0 * width - 1e-11).all()

    def test_lines(self) -> None:
        rng = np.random.default_rng(2)
        corners = rng.normal(size=(60, 1, 3)) + 0.8 * rng.normal(size=(60, 3, 3))
        points = rng.normal(size=(200, 3))
        normals = rng.normal(size=(200, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        hit, weights = first_along(corners, *build(corners), points, normals, np.full(200, 9.0))
        for i, (p, n) in enumerate(zip(points, normals, strict=True)):
            best = np.inf
            for a, b, c in corners:
                if np.cross(b - a, c - a) @ n <= 0.0:
                    continue
                s, v, w = np.linalg.solve(np.stack([-n, b - a, c - a], axis=1), p - a)
                if v >= 0.0 and w >= 0.0 and v + w <= 1.0:
                    best = min(best, abs(s))
            if hit[i] < 0:
                assert best > 9.0
            else:
                at = weights[i] @ corners[hit[i]]
                assert np.linalg.norm(np.cross(at - p, n)) < 1e-7
                assert abs((at - p) @ n) == pytest.approx(best, abs=1e-7)


class TestSurface:
    @pytest.mark.parametrize(
        ("vertices", "faces", "words"),
        [
            (np.zeros((3, 2)), [[0, 1, 2]], "(v, 3)"),
            (np.eye(3), [[0, 1, 2, 0]], "triangulate"),
            (np.eye(3), [[0, 1, 3]], "outside 0..2"),
            (np.diag([1.0, 1.0, np.inf]), [[0, 1, 2]], "vertex 2"),
            (np.zeros((3, 3)), [[0, 1, 2]], "no triangle with an area"),
        ],
    )
    def test_refusals(self, vertices: np.ndarray, faces: list[list[int]], words: str) -> None:
        with pytest.raises(InvalidMeshError) as caught:
            Surface.from_arrays(vertices, faces)
        assert words in str(caught.value)

    def test_a_trimesh_is_taken_as_it_is(self) -> None:
        trimesh = pytest.importorskip("trimesh")
        mesh = trimesh.Trimesh(SPHERE.vertices, SPHERE.triangles, process=False)
        fill = grid(4, 4)
        points = parallel(SPHERE, fill.perimeter, 50.0)
        assert (place(fill, points, mesh).vertices == place(fill, points, SPHERE).vertices).all()

    def test_a_flat_surface_is_the_plane(self) -> None:
        flat = Surface.from_arrays(
            [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]]
        )
        fill = grid(5, 3)
        corners = np.array([[0, 0, 0], [5, 0, 0], [4, 3, 0], [0, 3, 0]], float)
        points = polygon(corners, fill.lengths)
        off = place(fill, points, flat).vertices - place(fill, points).vertices
        assert np.abs(off).max() < 1e-9


def make_shell(thickness: float, columns: int = 40, rows: int = 20) -> Surface:
    """Half a tube of radius 1 about z, two walls with rims between them: a thin cloth.

    Triangles face away from the cloth's middle.
    """
    turn = np.pi * np.arange(columns + 1) / columns
    walls = []
    for radius in (1.0, 1.0 - thickness):
        x, z = np.meshgrid(turn, np.linspace(0.0, 2.0, rows + 1), indexing="ij")
        walls.append(np.stack([radius * np.cos(x), radius * np.sin(x), z], axis=2).reshape(-1, 3))
    n = len(walls[0])
    cells = [i * (rows + 1) + j for i in range(columns) for j in range(rows)]
    faces = [[a, a + rows + 1, a + rows + 2] for a in cells]
    faces += [[a, a + rows + 2, a + 1] for a in cells]
    outer = np.array(faces)
    sides = np.concatenate([outer[:, [k, (k + 1) % 3]] for k in range(3)])
    one_way = {(int(a), int(b)) for a, b in sides}
    rim = [(a, b) for a, b in one_way if (b, a) not in one_way]
    walls_between = [[b, a, a + n] for a, b in rim] + [[b, a + n, b + n] for a, b in rim]
    inner = outer[:, ::-1] + n
    return Surface.from_arrays(np.concatenate(walls), np.concatenate([outer, inner, walls_between]))


@pytest.mark.parametrize("thickness", [0.2, 0.05, 0.02, 0.005])
@pytest.mark.parametrize("steps", [4, 6, 12])
def test_a_boundary_on_a_thin_cloth_stays_on_its_wall(thickness: float, steps: int) -> None:
    """The chords of the boundary's edges come nearer to the lining than to the outer wall."""
    surface = make_shell(thickness)
    fill = grid(steps, steps)
    turn, height = np.linspace(0.8, 2.3, steps + 1), np.linspace(0.4, 1.6, steps + 1)
    around = [
        *((t, height[0]) for t in turn[:-1]),
        *((turn[-1], h) for h in height[:-1]),
        *((t, height[-1]) for t in turn[:0:-1]),
        *((turn[0], h) for h in height[:0:-1]),
    ]
    points = np.array([[np.cos(t), np.sin(t), h] for t, h in around])
    # What is enclosed, and half of what the boundary's triangles have beside it.
    wanted = 1.5 * 1.2 / surface.areas.sum()
    region = enclose_region(surface, points)
    assert region.separates
    assert wanted <= region.share <= 1.35 * wanted
    placed = place(fill, points, region)
    inner = placed.vertices[fill.perimeter :]
    radius = np.linalg.norm(inner[:, :2], axis=1)
    assert not len(placed.flipped) and placed.at_rest
    # On the outer wall, whose facets are up to this far within the tube.
    assert (radius > np.cos(np.pi / 80.0) - 1e-6).all()
    other = enclose_region(surface, points[::-1])
    assert other.separates and other.share == pytest.approx(1.0 - wanted, abs=0.05)


@pytest.mark.parametrize(("size", "move"), [(1.0, 1000.0), (1.0, 3.0), (1e-3, 0.0), (1000.0, 0.0)])
def test_a_boundary_nowhere_near_its_surface_is_refused(size: float, move: float) -> None:
    """With how far off it is, in diagonals of the surface: it is elsewhere, or in another unit."""
    points = size * parallel(SPHERE, 12, 40.0) + [move, 0.0, 0.0]
    with pytest.raises(InvalidBoundaryError, match="times the diagonal of the surface") as caught:
        enclose_region(SPHERE, points)
    off = np.linalg.norm(SPHERE.nearest(points).points - points, axis=1)
    shown = off.min()
    assert f"{shown:.4g} off, {shown / SPHERE.diagonal:.3g} times" in str(caught.value)
    with pytest.raises(InvalidBoundaryError):
        place(grid(3, 3), points, SPHERE)
