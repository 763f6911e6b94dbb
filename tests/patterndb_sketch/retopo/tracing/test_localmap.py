"""Local parameterisation: exact where the surface is flat, near where it bends, and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.tracing import LocalMap, MapExtent, spread_map
from patterndb_sketch.retopo.tracing.localmap import TORN
from tests.support.retopo.surfaces import bumps, grid, raised, sphere

B = 1.0
STEP = B / 10.0


def flat_surface(columns: int, rows: int, seed: int, low: tuple[float, float]) -> Surface:
    at, faces = grid(columns, rows, STEP, seed, low)
    return Surface.from_arrays(raised(at, lambda x, y: 0.0 * x), faces).orient()


def line(start: tuple[float, ...], end: tuple[float, ...], n: int) -> np.ndarray:
    return np.linspace(start, end, n)


class TestOnThePlane:
    @pytest.mark.parametrize("seed", range(3))
    def test_a_straight_stroke_is_exact(self, seed: int) -> None:
        surface = flat_surface(60, 80, seed, (-3.0, -2.0))
        stroke = line((0.0, 0.0, 0.0), (0.0, 4.0, 0.0), 81)
        found = spread_map(
            surface,
            surface.nearest(stroke),
            np.tile((0.0, 1.0, 0.0), (81, 1)),
            MapExtent.spine(B, 4.0),
        )
        error = np.abs(found.uv - surface.vertices[found.vertices, :2])
        assert error.max() < 1e-9 * B
        # The brush lies within: corners of a patch can be asked for.
        _, there = found.at([(-B, 0.0), (B, 0.0), (B, 4.0), (-B, 4.0)])
        assert there.all()

    @settings(max_examples=20, deadline=None)
    @given(st.integers(0, 2**32))
    def test_a_point_is_exact_in_any_direction(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        surface = flat_surface(60, 60, seed, (-3.0, -3.0))
        at = np.r_[rng.uniform(-0.3, 0.3, 2), 0.0]
        turn = rng.uniform(0.0, 2.0 * np.pi)
        along, right = (np.cos(turn), np.sin(turn), 0.0), (np.sin(turn), -np.cos(turn), 0.0)
        # Its length and a part across the surface do not count.
        tangent = 7.0 * np.array(along) + np.array((0.0, 0.0, rng.normal()))
        found = spread_map(
            surface, surface.nearest(at[None]), tangent[None], MapExtent.completion(B)
        )
        off = surface.vertices[found.vertices] - at
        assert np.abs(found.uv - np.stack([off @ right, off @ along], axis=1)).max() < 1e-9 * B
        assert found.uv[:, 0].min() < -B and found.uv[:, 1].max() > 2.0 * B

    @pytest.mark.parametrize("seed", range(3))
    def test_an_arc_is_near_the_polar_map(self, seed: int) -> None:
        surface = flat_surface(100, 100, seed, (-5.0, -5.0))
        radius, half = 3.0 * B, 0.8
        turn = np.linspace(-half, half, 97)
        stroke = radius * np.stack([np.cos(turn) - 1.0, np.sin(turn), 0.0 * turn], axis=1)
        tangents = np.stack([-np.sin(turn), np.cos(turn), 0.0 * turn], axis=1)
        length = 2.0 * half * radius
        found = spread_map(surface, surface.nearest(stroke), tangents, MapExtent.spine(B, length))
        x, y = (surface.vertices[found.vertices, :2] + (radius, 0.0)).T
        polar = np.stack([np.hypot(x, y) - radius, (np.arctan2(y, x) + half) * radius], axis=1)
        beside = (np.abs(polar[:, 0]) <= B) & (polar[:, 1] >= 0.0) & (polar[:, 1] <= length)
        error = np.linalg.norm(found.uv - polar, axis=1)[beside]
        assert error.max() < 0.1 * B and error.mean() < 0.03 * B


class TestOnACylinder:
    @pytest.mark.parametrize("seed", range(3))
    def test_a_stroke_along_the_axis_unrolls_it(self, seed: int) -> None:
        radius = 2.0 * B
        flat, faces = grid(60, 80, STEP, seed, (-3.0, -2.0))
        turn = flat[:, 0] / radius
        rolled = np.c_[radius * np.cos(turn), radius * np.sin(turn), flat[:, 1]]
        surface = Surface.from_arrays(rolled, faces).orient()
        stroke = surface.nearest(line((radius, 0.0, 0.0), (radius, 0.0, 4.0), 81))
        found = spread_map(
            surface, stroke, np.tile((0.0, 0.0, 1.0), (81, 1)), MapExtent.spine(B, 4.0)
        )
        error = np.abs(found.uv - flat[found.vertices])[np.abs(flat[found.vertices, 0]) <= B]
        assert len(error) > 500 and error.max() < 1e-3 * B


def spread(seed: int) -> tuple[Surface, LocalMap]:
    surface = bumps(seed, 40)
    rng = np.random.default_rng(seed)
    at = surface.nearest(rng.uniform(0.4, 0.6, (1, 3)))
    return surface, spread_map(surface, at, [(1.0, 0.3, 0.0)], MapExtent.completion(0.15))


class TestBothWays:
    @settings(max_examples=25, deadline=None)
    @given(st.integers(0, 2**32))
    def test_there_and_back(self, seed: int) -> None:
        surface, found = spread(seed)
        rng = np.random.default_rng(seed)
        chosen = rng.integers(len(found.triangles), size=50)
        weights = rng.dirichlet((1.0, 1.0, 1.0), 50)
        feet = surface.at(found.triangles[chosen], weights)
        uv = found.of(feet)
        assert np.isfinite(uv).all()
        again, there = found.at(uv)
        assert there.all()
        assert np.abs(found.of(again) - uv).max() < 1e-9
        # The same place, unless the map lies over itself: then one that is no further off.
        same = again.triangles == feet.triangles
        assert np.abs(again.points - feet.points)[same].max() < 1e-9
        assert same.mean() > 0.9

    @settings(max_examples=15, deadline=None)
    @given(st.integers(0, 2**32))
    def test_lookup_against_all_triangles(self, seed: int) -> None:
        _, found = spread(seed)
        rng = np.random.default_rng(seed)
        asked = rng.uniform(found.uv.min(axis=0) - 0.02, found.uv.max(axis=0) + 0.02, (60, 2))
        feet, there = found.at(asked)
        a, b, c = np.moveaxis(found.uv[found.corners], 1, 0)
        for uv, triangle, is_there in zip(asked, feet.triangles, there, strict=True):
            vw = np.linalg.solve(np.stack([b - a, c - a], axis=2), (uv - a)[:, :, None])[:, :, 0]
            weights = np.c_[1.0 - vw.sum(axis=1), vw]
            far = np.einsum("ke,ke->k", weights, found.distance[found.corners])
            far[weights.min(axis=1) < 0.0] = np.inf
            assert is_there == np.isfinite(far).any()
            assert triangle == (found.triangles[far.argmin()] if is_there else -1)

    def test_points_beside_the_surface(self) -> None:
        surface, found = spread(3)
        feet = surface.at(found.triangles[::7], np.full((len(found.triangles[::7]), 3), 1 / 3))
        uv = found.of_points(feet.points + 1e-4 * feet.normals, feet.normals)
        assert np.abs(uv - found.of(feet)).max() < 1e-3
        assert np.isnan(found.of_points(feet.points + 50.0, feet.normals)).all()
        # No triangle of these hills faces down: such a point is on another sheet.
        down = np.tile((0.0, 0.0, -1.0), (len(feet), 1))
        assert np.isnan(found.of_points(feet.points, down)).all()

    def test_outside_is_told(self) -> None:
        surface, found = spread(4)
        feet, there = found.at([(9.0, 9.0), (np.nan, 0.0), (0.0, 0.0)])
        assert there.tolist() == [False, False, True]
        assert (feet.triangles[:2] == -1).all() and np.isnan(feet.points[:2]).all()
        mapped = np.isin(np.arange(len(surface.triangles)), found.triangles)
        rest = np.flatnonzero(~mapped).astype(np.int32)
        assert np.isnan(found.of(surface.at(rest, np.full((len(rest), 3), 1 / 3)))).all()


class TestReach:
    def test_only_triangles_with_all_corners_within(self) -> None:
        surface, found = spread(5)
        window = MapExtent.completion(0.15)
        assert (found.distance <= window.distance).all() and (np.diff(found.distance) >= 0).all()
        for d, (low, high) in enumerate((window.u, window.v)):
            assert (found.uv[:, d] >= low).all() and (found.uv[:, d] <= high).all()
        has = np.zeros(len(surface.vertices), bool)
        has[found.vertices] = True
        whole = np.flatnonzero(has[surface.triangles].all(axis=1))
        assert set(found.triangles) <= set(whole)
        assert (found.vertices[found.corners] == surface.triangles[found.triangles]).all()

    def test_fronts_that_meet_behind_a_limb_leave_a_gap(self) -> None:
        turn = 2.0 * np.pi * np.arange(24) / 24
        rings = [np.stack([np.cos(turn), np.sin(turn), 0.0 * turn + z], 1) for z in range(4)]
        i = np.arange(24)
        faces = [
            np.stack([24 * r + i, 24 * r + (i + 1) % 24, 24 * r + 24 + (i + 1) % 24], 1)
            for r in range(3)
        ] + [
            np.stack([24 * r + i, 24 * r + 24 + (i + 1) % 24, 24 * r + 24 + i], 1) for r in range(3)
        ]
        surface = Surface.from_arrays(np.concatenate(rings), np.concatenate(faces)).orient()
        seeds = surface.nearest(line((1.0, 0.0, 0.5), (1.0, 0.0, 2.5), 9))
        window = MapExtent(20.0, (-9.0, 9.0), (-9.0, 9.0))
        found = spread_map(surface, seeds, np.tile((0.0, 0.0, 1.0), (9, 1)), window)
        assert len(found.vertices) == len(surface.vertices)
        assert len(found.triangles) < len(surface.triangles)
        corner = found.uv[found.corners]
        flat = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)
        solid = surface.vertices[surface.triangles[found.triangles]]
        solid = np.linalg.norm(solid - np.roll(solid, -1, axis=1), axis=2)
        assert (flat <= TORN * solid + 1e-12).all()

    def test_it_does_not_depend_on_the_surface_elsewhere(self) -> None:
        near, far = sphere(3), sphere(3)
        both = Surface.from_arrays(
            np.concatenate([near.vertices, far.vertices + 9.0]),
            np.concatenate([near.triangles, far.triangles + len(near.vertices)]),
        ).orient()
        seed = near.nearest([(0.0, 0.0, 1.0)])
        window = MapExtent.completion(0.4)
        one = spread_map(near, seed, [(1.0, 0.0, 0.0)], window)
        two = spread_map(both, both.nearest(seed.points), [(1.0, 0.0, 0.0)], window)
        assert len(one.vertices) == len(two.vertices)
        assert np.abs(one.uv - two.uv).max() < 1e-12


class TestRefusals:
    def test_no_seed(self) -> None:
        surface = sphere(1)
        with pytest.raises(InvalidRetopoError, match="one point or more"):
            spread_map(
                surface, surface.nearest(np.empty((0, 3))), np.empty((0, 3)), MapExtent.spine(1, 1)
            )

    @pytest.mark.parametrize("tangent", [(0.0, 0.0, 0.0), (0.0, 0.0, 2.0), (0.0, np.nan, 0.0)])
    def test_a_tangent_across_the_surface(self, tangent: tuple[float, ...]) -> None:
        surface = flat_surface(4, 4, 0, (0.0, 0.0))
        seed: SurfacePoints = surface.nearest([(0.2, 0.2, 0.0)])
        with pytest.raises(InvalidRetopoError, match="no part along the surface"):
            spread_map(surface, seed, [tangent], MapExtent.spine(1, 1))

    def test_shapes(self) -> None:
        _, found = spread(1)
        with pytest.raises(InvalidRetopoError, match=r"\(n, 2\)"):
            found.at([(0.0, 0.0, 0.0)])
