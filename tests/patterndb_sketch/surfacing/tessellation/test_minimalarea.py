"""The triangulation of least area, beside all triangulations one by one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.tessellation import (
    MAX_VERTICES,
    area,
    find_self_intersections,
    minimal_area,
    patch_of_least_area,
)
from tests.support.surfacing.tessellation import as_loop, check_disk, turned, wobbly

Triangle = tuple[int, int, int]


def all_triangulations(first: int, last: int) -> Iterator[tuple[Triangle, ...]]:
    """Every triangulation between two vertices of a polygon."""
    if last - first < 2:
        yield ()
        return
    for k in range(first + 1, last):
        for left in all_triangulations(first, k):
            for right in all_triangulations(k, last):
                yield (*left, (first, k, last), *right)


def by_brute_force(points: np.ndarray, barred: np.ndarray | None = None) -> float:
    """The least area of all triangulations that join no barred pair, infinite without one."""
    n = len(points)
    areas = np.zeros((n, n, n))
    for i in range(n):
        for k in range(i + 1, n):
            for j in range(k + 1, n):
                areas[i, k, j] = area(points, [[i, k, j]])
    if barred is not None:
        for i, k, j in zip(*np.nonzero(areas), strict=True):
            sides = ((i, k), (k, j), (i, j))
            if any(barred[a, b] and (b - a) % n not in (1, n - 1) for a, b in sides):
                areas[i, k, j] = np.inf
    return min(sum(areas[t] for t in way) for way in all_triangulations(0, n - 1))


class TestLeast:
    @settings(max_examples=60, deadline=None)
    @given(st.integers(3, 9), st.integers(0, 2**32))
    def test_equals_brute_force_over_all_triangulations(self, n: int, seed: int) -> None:
        points = np.random.default_rng(seed).normal(size=(n, 3))
        triangles, least = minimal_area(points)
        assert least == pytest.approx(by_brute_force(points), rel=1e-12)
        assert least == pytest.approx(area(points, triangles), rel=1e-12)
        check_disk(triangles, list(range(n)))

    def test_equals_brute_force_for_ten_vertices_on_a_grid(self) -> None:
        # Many equal areas, points in a row and points at one place.
        for seed in range(3):
            points = np.random.default_rng(seed).integers(0, 3, size=(10, 3)).astype(float)
            triangles, least = minimal_area(points)
            assert least == pytest.approx(by_brute_force(points), rel=1e-11)
            assert least == pytest.approx(area(points, triangles), rel=1e-12)
            check_disk(triangles, list(range(10)))

    @settings(max_examples=40, deadline=None)
    @given(st.integers(3, 8), st.integers(0, 2**32), st.floats(0.0, 0.6))
    def test_barred_pairs_are_not_joined(self, n: int, seed: int, share: float) -> None:
        chance = np.random.default_rng(seed)
        points = chance.normal(size=(n, 3))
        barred = chance.uniform(size=(n, n)) < share
        barred |= barred.T
        wanted = by_brute_force(points, barred)
        if wanted == np.inf:
            with pytest.raises(InvalidNetworkError, match="barred"):
                minimal_area(points, barred)
            return
        triangles, least = minimal_area(points, barred)
        assert least == pytest.approx(wanted, rel=1e-12)
        assert least == pytest.approx(area(points, triangles), rel=1e-12)
        check_disk(triangles, list(range(n)))

    @settings(max_examples=20, deadline=None)
    @given(st.integers(20, 120), st.integers(0, 2**32), st.floats(0.0, 0.1))
    def test_start_sense_motion_and_unit_do_not_change_the_area(
        self, n: int, seed: int, noise: float
    ) -> None:
        points = wobbly(n, seed, noise)
        least = minimal_area(points)[1]
        for same in (np.roll(points, 7, axis=0), points[::-1], turned(points, seed + 1)):
            assert minimal_area(same)[1] == pytest.approx(least, rel=1e-9)
        for unit in (1e-100, 1e100):
            triangles, scaled = minimal_area(unit * points)
            assert scaled == pytest.approx(unit * unit * least, rel=1e-9)
            check_disk(triangles, list(range(n)))


class TestTies:
    @settings(max_examples=20, deadline=None)
    @given(st.integers(4, 40), st.integers(0, 2**32))
    def test_planar_and_convex_it_is_the_delaunay_triangulation(self, n: int, seed: int) -> None:
        chance = np.random.default_rng(seed)
        angles = np.sort(chance.uniform(0.0, 2.0 * np.pi, n))
        flat = np.stack([2.0 * np.cos(angles), np.sin(angles)], axis=1)
        points = turned(np.c_[flat, np.zeros(n)], seed)
        found = {tuple(sorted(t)) for t in minimal_area(points)[0].tolist()}
        theirs = {tuple(sorted(t)) for t in Delaunay(flat).simplices.tolist()}
        # Nearly flat triangles on the hull, and nearly equal choices, are decided by rounding.
        clear = {t for t in theirs if area(points, [t]) > 1e-6}
        assert len(clear - found) <= 0.05 * n

    def test_straight_sides_give_no_triangle_without_area(self) -> None:
        steps = np.arange(6) / 6.0
        bottom = np.c_[steps, 0.0 * steps, 0.0 * steps]
        square = [bottom]
        for _ in range(3):
            square.append(np.stack([1.0 - square[-1][:, 1], square[-1][:, 0], 0.0 * steps], 1))
        points = np.concatenate(square)
        for start in range(24):
            shifted = np.roll(points, start, axis=0)
            triangles, least = minimal_area(shifted)
            assert least == pytest.approx(1.0)
            assert min(area(shifted, [t]) for t in triangles) > 1e-3
            assert len(find_self_intersections(shifted, triangles)) == 0

    def test_points_at_one_place_have_no_area(self) -> None:
        triangles, least = minimal_area(np.ones((7, 3)))
        assert least == 0.0
        check_disk(triangles, list(range(7)))


class TestPatch:
    @settings(max_examples=10, deadline=None)
    @given(st.integers(3, 60), st.integers(0, 2**32))
    def test_a_whole_patch_of_least_area_has_no_new_vertices(self, n: int, seed: int) -> None:
        loop = as_loop(wobbly(n, seed, 0.05))
        mesh = patch_of_least_area(loop)
        assert mesh.methods == ("area",) and len(mesh.points) == 0
        assert (mesh.vertices(loop) == loop.points).all()
        check_disk(mesh.triangles, list(range(n)))
        assert area(loop.points, mesh.triangles) == pytest.approx(minimal_area(loop.points)[1])


class TestRefused:
    def test_too_few_and_too_many(self) -> None:
        with pytest.raises(InvalidNetworkError, match="three or more"):
            minimal_area([[0, 0, 0], [1, 0, 0]])
        with pytest.raises(InvalidNetworkError, match="the limit is"):
            minimal_area(np.zeros((MAX_VERTICES + 1, 3)))

    def test_points_that_are_none(self) -> None:
        with pytest.raises(InvalidNetworkError, match="not finite"):
            minimal_area([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]])
