"""One piece as a mesh: a disk with the given boundary, sound triangles, relaxed in space."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from patterndb._native.surfacing.tessellation.piece import solve_heights
from patterndb._native.surfacing.tessellation.planar import is_simple
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.tessellation import (
    Tessellation,
    area,
    find_self_intersections,
    minimal_area,
    tessellate,
)
from patterndb_sketch.surfacing.tessellation.piece import (
    GRID,
    fill_polygon,
    find_area_vector,
    project_piece,
    triangulate_polygon,
)
from tests.support.surfacing.tessellation import check_disk, turned, wobbly


def outline(corners: list[list[float]], spacing: float) -> Points:
    """A closed polygon (m, 3) in the plane with samples along its sides."""
    at = np.array(corners, float)
    parts: list[Points] = []
    for a, b in zip(at, np.roll(at, -1, axis=0), strict=True):
        edges = max(1, round(float(np.linalg.norm(b - a)) / spacing))
        parts.append(a + np.outer(np.arange(edges) / edges, b - a))
    flat = np.concatenate(parts)
    return np.c_[flat, np.zeros(len(flat))]


def circle(n: int) -> Points:
    turn = 2.0 * np.pi * np.arange(n) / n
    return np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)


def comb(gap: float) -> Points:
    """A comb whose teeth are ``gap`` apart."""
    teeth = [[0.0, -0.5], [4.0, -0.5]]
    for k in range(4, 0, -1):
        teeth += [[k, 3.0], [k - 1.0 + gap, 3.0], [k - 1.0 + gap, 0.0], [k - 1.0, 0.0]]
    return outline([*teeth[:-2], [gap, 0.0]], 0.5)


def spiral(n: int) -> Points:
    """A strip wound up nearly twice."""
    turn = np.linspace(0.0, 3.5 * np.pi, n)
    sides = [
        np.stack([r * np.cos(turn), r * np.sin(turn), 0.1 * turn], axis=1)
        for r in (1.0 + 0.3 * turn, 1.9 + 0.3 * turn)
    ]
    return np.concatenate([sides[1], sides[0][::-1]])


L_SHAPE = outline([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], 0.2)
STAR = outline(
    [
        [r * math.cos(k * math.pi / 5), r * math.sin(k * math.pi / 5)]
        for k, r in enumerate([1.0, 0.4] * 5)
    ],
    0.1,
)
SHAPES = {
    "circle": circle(60),
    "L": L_SHAPE,
    "star": STAR,
    "comb": comb(0.3),
    "comb that nearly touches": comb(1e-6),
    "spiral": spiral(100),
    "strip": outline([[0, 0], [5, 0], [5, 0.01], [0, 0.01]], 0.1),
}


def whole(points: Points, made: Tessellation) -> Points:
    return np.concatenate([points, made.inner])


def angles(points: Points, triangles: NDArray[np.int64]) -> Points:
    """(f, 3) in degrees."""
    corner = points[triangles]
    before, after = np.roll(corner, 1, axis=1) - corner, np.roll(corner, -1, axis=1) - corner
    across = np.linalg.norm(np.cross(before, after), axis=2)
    return np.degrees(np.arctan2(across, (before * after).sum(axis=2)))


class TestDisk:
    @settings(max_examples=60, deadline=None)
    @given(st.integers(3, 60), st.integers(0, 2**32), st.sampled_from([0.0, 0.02, 0.1, 0.5]))
    def test_every_piece_is_one_disk_with_the_given_boundary(
        self, n: int, seed: int, noise: float
    ) -> None:
        points = wobbly(n, seed, noise)
        made = tessellate(points, 0.2)
        check_disk(made.triangles, list(range(n)))
        assert len(made.triangles) == n - 2 + 2 * len(made.inner)
        assert (made.method == "area") == bool(made.note)
        if made.method == "laplacian":
            # A graph over its plane.
            assert len(find_self_intersections(whole(points, made), made.triangles)) == 0

    @pytest.mark.parametrize("name", SHAPES)
    @pytest.mark.parametrize("seed", [0, 1])
    def test_planar_pieces_keep_their_area_and_stay_in_their_plane(
        self, name: str, seed: int
    ) -> None:
        flat = SHAPES[name] * [1.0, 1.0, 0.0]
        points = turned(flat, seed)
        made = tessellate(points, 0.15)
        assert made.method == "laplacian"
        check_disk(made.triangles, list(range(len(points))))
        wanted = float(np.linalg.norm(find_area_vector(points)))
        assert area(whole(points, made), made.triangles) == pytest.approx(wanted, rel=1e-9)
        normal = find_area_vector(points) / wanted
        heights = (whole(points, made) - points[0]) @ normal
        assert np.abs(heights).max() < 1e-9

    def test_three_points_are_one_triangle(self) -> None:
        made = tessellate([[0, 0, 0], [1, 0, 0], [0, 1, 5]], 0.01)
        assert made.triangles.tolist() == [[0, 1, 2]] and len(made.inner) == 0

    def test_a_piece_without_room_has_no_points_inside(self) -> None:
        assert len(tessellate(SHAPES["strip"], 0.1).inner) == 0
        assert len(tessellate(circle(12), 5.0).inner) == 0


class TestShape:
    @pytest.mark.parametrize("name", ["circle", "L", "star"])
    @pytest.mark.parametrize("seed", range(3))
    def test_triangles_are_well_shaped_and_points_about_the_spacing_apart(
        self, name: str, seed: int
    ) -> None:
        points = turned(SHAPES[name], seed)
        spacing = float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).mean())
        made = tessellate(points, spacing)
        least = angles(whole(points, made), made.triangles).min(axis=1)
        assert np.median(least) > 45.0 and np.quantile(least, 0.05) > 30.0
        apart = cKDTree(whole(points, made)).query(made.inner, k=2)[0][:, 1]
        assert apart.min() > 0.5 * spacing and apart.max() < 1.5 * spacing
        assert np.median(apart) == pytest.approx(spacing, rel=0.2)

    def test_a_steep_piece_has_points_about_the_spacing_apart_too(self) -> None:
        rim = circle(80)
        rim[:, 2] = 2.0 * rim[:, 0]
        made = tessellate(rim, 0.2)
        flat = tessellate(circle(80), 0.2)
        assert len(made.inner) == pytest.approx(math.sqrt(5.0) * len(flat.inner), rel=0.2)

    @settings(max_examples=40, deadline=None)
    @given(st.integers(4, 60), st.integers(0, 2**32), st.sampled_from([0.0, 0.01, 0.1]))
    def test_the_mesh_in_the_plane_is_constrained_delaunay(
        self, n: int, seed: int, noise: float
    ) -> None:
        seen = project_piece(wobbly(n, seed, noise))
        if seen is None:
            return
        at, tail, twin = fill_polygon(seen.grid, *triangulate_polygon(seen.grid), 0.1 * GRID)
        exact = at.tolist()
        doubled = 0
        for h in range(len(tail)):
            a, b, c = (exact[tail[3 * (h // 3) + (h + e) % 3]] for e in range(3))
            if h % 3 == 0:
                size = turn(a, b, c)
                assert size > 0
                doubled += size
            if twin[h] >= 0:
                assert twin[twin[h]] == h
                d = exact[tail[3 * (twin[h] // 3) + (twin[h] + 2) % 3]]
                assert not clearly_within(a, b, c, d)
        corners = [exact[i] for i in range(n)]
        assert doubled == sum(turn(corners[0], *corners[i : i + 2]) for i in range(1, n - 1))


def turn(a: list[int], b: list[int], c: list[int]) -> int:
    """Twice a triangle's area, in exact integers."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def clearly_within(a: list[int], b: list[int], c: list[int], d: list[int]) -> bool:
    """Is d within the circle through a, b, c by more than rounding can hide?"""
    (ax, ay), (bx, by), (cx, cy) = ((p[0] - d[0], p[1] - d[1]) for p in (a, b, c))
    parts = [
        (ax * ax + ay * ay) * (bx * cy - cx * by),
        (bx * bx + by * by) * (cx * ay - ax * cy),
        (cx * cx + cy * cy) * (ax * by - bx * ay),
    ]
    reach = max(ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy)
    return sum(parts) > max(map(abs, [*parts, reach * reach])) // 10**13


class TestPolygons:
    @settings(max_examples=200, deadline=None)
    @given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=3, max_size=9))
    def test_simple_polygons_are_told_from_others(self, corners: list[tuple[int, int]]) -> None:
        grid = np.array(corners, np.int64)
        assert is_simple(grid) == simple_by_fractions(corners)
        if is_simple(grid):
            tail, _ = triangulate_polygon(grid)
            check_disk(tail.reshape(-1, 3), list(range(len(grid))))
            exact = grid.tolist()
            assert min(turn(*(exact[i] for i in t)) for t in tail.reshape(-1, 3)) > 0

    @settings(max_examples=40, deadline=None)
    @given(st.integers(3, 40), st.integers(0, 2**32), st.sampled_from([1, 10, 10**5]))
    def test_vertices_very_near_each_other_and_in_a_row(
        self, n: int, seed: int, reach: int
    ) -> None:
        # Around a square, vertices in a row and pairs a few steps of the grid apart.
        chance = np.random.default_rng(seed)
        along = np.sort(chance.choice(4 * (GRID - 2), n, replace=False))
        along = np.unique(np.concatenate([along, along + chance.integers(0, reach, size=n)]))
        part, rest = np.divmod(along % (4 * GRID), GRID)
        x = np.choose(part, [rest, np.full_like(rest, GRID), GRID - rest, 0 * rest])
        y = np.choose(part, [0 * rest, rest, np.full_like(rest, GRID), GRID - rest])
        grid = np.stack([x, y], axis=1)
        assert is_simple(grid) == simple_by_fractions([(int(a), int(b)) for a, b in grid])
        if is_simple(grid):
            at, tail, _ = fill_polygon(grid, *triangulate_polygon(grid), 0.2 * GRID)
            check_disk(tail.reshape(-1, 3), list(range(len(grid))))
            exact = at.tolist()
            assert min(turn(*(exact[i] for i in t)) for t in tail.reshape(-1, 3)) > 0


def simple_by_fractions(corners: list[tuple[int, int]]) -> bool:
    """Is a polygon simple and counter-clockwise? Every edge against every point of every other."""
    at = [list(p) for p in corners]
    m = len(at)
    doubled = sum(turn(at[0], at[i], at[i + 1]) for i in range(1, m - 1))
    if len({tuple(p) for p in at}) < m or doubled <= 0:
        return False

    def on(a: list[int], b: list[int], p: list[int]) -> bool:
        dot = sum((a[d] - p[d]) * (b[d] - p[d]) for d in range(2))
        return turn(a, b, p) == 0 and dot <= 0

    for i in range(m):
        a, b = at[i], at[(i + 1) % m]
        if any(on(a, b, at[k]) for k in range(m) if k not in (i, (i + 1) % m)):
            return False
        for j in range(m):
            c, d = at[j], at[(j + 1) % m]
            if turn(a, b, c) * turn(a, b, d) < 0 and turn(c, d, a) * turn(c, d, b) < 0:
                return False
    return True


class TestRelaxation:
    @settings(max_examples=20, deadline=None)
    @given(st.integers(8, 60), st.integers(0, 2**32))
    def test_heights_equal_those_of_a_direct_solver(self, n: int, seed: int) -> None:
        seen = project_piece(wobbly(n, seed, 0.01))
        if seen is None:
            return
        at, tail, twin = fill_polygon(seen.grid, *triangulate_polygon(seen.grid), 0.07 * GRID)
        heights = solve_heights(at, tail, twin, seen.heights)
        triangles, flat = tail.reshape(-1, 3), at / GRID
        rows, columns, values = [], [], []
        for e in range(3):
            a, b, c = (flat[triangles[:, (e + k) % 3]] for k in range(3))
            u, v = a - c, b - c
            half = 0.5 * (u * v).sum(axis=1) / (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
            i, j = triangles[:, e], triangles[:, (e + 1) % 3]
            rows += [i, j, i, j]
            columns += [j, i, i, j]
            values += [-half, -half, half, half]
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        laplacian = coo_array(entries, shape=(len(at), len(at))).tocsr()
        if len(at) == n:
            return
        right = -laplacian[n:, :n] @ seen.heights
        direct = np.atleast_1d(spsolve(laplacian[n:, n:].tocsc(), right))
        extent = float(np.ptp(seen.heights))
        assert heights[n:] == pytest.approx(direct, abs=1e-9 * extent)
        assert heights[:n].tolist() == seen.heights.tolist()
        # None is beyond the boundary's.
        assert heights.max() <= seen.heights.max() and heights.min() >= seen.heights.min()
        # In the plane all are at rest: this is the Laplacian in space.
        assert np.abs((laplacian @ flat)[n:]).max() < 1e-7

    def test_a_saddle_is_the_harmonic_one(self) -> None:
        rim = circle(120)
        rim[:, 2] = 0.5 * (rim[:, 0] ** 2 - rim[:, 1] ** 2)
        inner = tessellate(rim, 0.06).inner
        # The axes' plane is the boundary's own: z = (x^2 - y^2) / 2 is harmonic.
        assert inner[:, 2] == pytest.approx(0.5 * (inner[:, 0] ** 2 - inner[:, 1] ** 2), abs=2e-3)


class TestFallback:
    def test_the_plane_of_the_principal_axes_where_the_own_one_fails(self) -> None:
        points = np.array(
            [
                *([7.0, -3.3, -0.1], [3.7, 2.1, 1.4], [0.6, 2.4, 2.4]),
                *([2.8, 2.7, -0.6], [-5.9, -0.5, -0.1], [3.5, -0.7, 0.1]),
            ]
        )
        normal = find_area_vector(points) / np.linalg.norm(find_area_vector(points))
        seen = project_piece(points)
        assert seen is not None
        assert abs(float(seen.normal @ normal)) < 1.0 - 1e-6
        made = tessellate(points, 0.3)
        assert made.method == "laplacian" and not made.note
        check_disk(made.triangles, list(range(len(points))))

    @pytest.mark.parametrize("seed", range(5))
    def test_least_area_where_both_planes_fail_and_it_says_so(self, seed: int) -> None:
        # Once around and back within: from no direction without a crossing.
        turn = 4.0 * np.pi * np.arange(40) / 40
        radius = 1.0 + 0.3 * np.cos(turn / 2.0)
        knotty = np.stack(
            [radius * np.cos(turn), radius * np.sin(turn), 0.3 * np.sin(turn / 2.0)], axis=1
        )
        points = turned(knotty, seed)
        made = tessellate(points, 0.1)
        assert made.method == "area" and "touches itself" in made.note
        assert len(made.inner) == 0
        check_disk(made.triangles, list(range(40)))
        assert area(points, made.triangles) == pytest.approx(minimal_area(points)[1])

    def test_least_area_where_the_mesh_in_the_plane_joins_a_barred_pair(self) -> None:
        barred = np.zeros((12, 12), bool)
        barred[:11, :11] = True
        made = tessellate(circle(12), 5.0, barred)
        assert made.method == "area" and "one chord" in made.note
        # Only the fan from the last point is left.
        assert (made.triangles == 11).any(axis=1).all()
        barred[:11, :11] = False
        barred[:2, :2] = True
        assert tessellate(circle(12), 5.0, barred).method == "laplacian"

    def test_points_at_one_place_and_in_one_line(self) -> None:
        for points in (np.ones((6, 3)), np.outer(np.arange(6.0), [1.0, 2.0, 3.0])):
            made = tessellate(points, 0.1)
            assert made.method == "area"
            check_disk(made.triangles, list(range(6)))
        twice = np.repeat(circle(8), 2, axis=0)
        assert tessellate(twice, 0.2).method == "area"


class TestRefused:
    def test_spacings(self) -> None:
        for spacing in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(InvalidNetworkError, match="above 0"):
                tessellate(circle(5), spacing)
        with pytest.raises(InvalidNetworkError, match="the limit is"):
            tessellate(circle(5), 1e-6)

    def test_points(self) -> None:
        with pytest.raises(InvalidNetworkError, match="three or more"):
            tessellate(np.eye(3)[:2], 1.0)
        with pytest.raises(InvalidNetworkError, match="not finite"):
            tessellate(np.full((4, 3), np.nan), 1.0)
