"""Crossings of a mesh with itself, beside exact rational arithmetic on every pair."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from patterndb.errors import InvalidMeshError
from patterndb_sketch.surfacing.tessellation import area, find_self_intersections, tessellate
from tests.support.surfacing.tessellation import turned, wobbly

Point = list[Fraction]


def side(a: Point, b: Point, c: Point, d: Point) -> int:
    """Of the plane through a, b, c the side on which d is, exactly."""
    u, v, w = ([q - p for p, q in zip(a, x, strict=True)] for x in (b, c, d))
    volume = (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        - u[1] * (v[0] * w[2] - v[2] * w[0])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )
    return (volume > 0) - (volume < 0)


def pierces(p: Point, q: Point, triangle: list[Point]) -> bool:
    """Does the segment go through the inside of the triangle?"""
    a, b, c = triangle
    if side(a, b, c, p) * side(a, b, c, q) >= 0:
        return False
    turns = {side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)}
    return turns in ({1}, {-1})


def exactly(points: np.ndarray, faces: np.ndarray) -> list[list[int]]:
    """All crossing pairs, for points of which no four lie in a plane.

    Then two triangles cross if and only if an edge of one, without a corner of the other,
    goes through the inside of the other.
    """
    at = [[Fraction(x) for x in p] for p in points.tolist()]
    found: list[list[int]] = []
    for i, j in combinations(range(len(faces)), 2):
        for one, other in ((i, j), (j, i)):
            corners = faces[other].tolist()
            ends = [(faces[one, e], faces[one, (e + 1) % 3]) for e in range(3)]
            triangle = [at[k] for k in corners]
            if any(
                p not in corners and q not in corners and pierces(at[p], at[q], triangle)
                for p, q in ends
            ):
                found.append([i, j])
                break
    return found


def random_faces(points: int, faces: int, seed: int) -> np.ndarray:
    chance = np.random.default_rng(seed)
    return np.array([chance.choice(points, 3, replace=False) for _ in range(faces)])


class TestExact:
    @settings(max_examples=40, deadline=None)
    @given(st.integers(4, 40), st.integers(2, 16), st.integers(0, 2**32))
    def test_soups_with_common_corners_and_edges(self, v: int, f: int, seed: int) -> None:
        points = np.random.default_rng(seed).normal(size=(v, 3))
        faces = np.unique(np.sort(random_faces(v, f, seed), axis=1), axis=0)
        assert find_self_intersections(points, faces).tolist() == exactly(points, faces)

    @settings(max_examples=25, deadline=None)
    @given(st.integers(0, 2**32))
    def test_motion_unit_and_order_do_not_matter(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        points = chance.normal(size=(30, 3))
        faces = random_faces(30, 60, seed)
        found = {tuple(pair) for pair in find_self_intersections(points, faces).tolist()}
        assert found
        for moved in (turned(points, seed), 1e6 * points, 1e-200 * points, points + 1e3):
            assert {tuple(pair) for pair in find_self_intersections(moved, faces).tolist()} == found
        order = chance.permutation(60)
        mixed = faces[order][:, [2, 0, 1]]
        again = np.sort(order[find_self_intersections(points, mixed)], axis=1)
        assert {tuple(pair) for pair in again.tolist()} == found


class TestSpecialPositions:
    @pytest.mark.parametrize("seed", [None, 1, 2, 3])
    def test_two_crossing_squares(self, seed: int | None) -> None:
        points = np.array(
            [
                *([-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]),
                *([-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]),
            ],
            float,
        )
        points = points if seed is None else turned(points, seed)
        assert find_self_intersections(points, [[0, 1, 2, 3], [4, 5, 6, 7]]).tolist() == [[0, 1]]
        triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
        assert len(find_self_intersections(points, triangles)) > 0

    @pytest.mark.parametrize("seed", range(3))
    def test_a_convex_polyhedron_does_not_cross_itself(self, seed: int) -> None:
        points = np.random.default_rng(seed).normal(size=(200, 3))
        assert len(find_self_intersections(points, ConvexHull(points).simplices)) == 0

    @pytest.mark.parametrize("noise", [0.0, 1e-16, 1e-14, 1e-11, 1e-7, 1e-3])
    @pytest.mark.parametrize("seed", range(3))
    def test_a_plane_is_not_crossed_by_rounding(self, seed: int, noise: float) -> None:
        flat = wobbly(50, seed, 0.0)
        middle = flat - flat.mean(axis=0)
        normal = np.linalg.eigh(middle.T @ middle)[1][:, 0]
        flat = flat - np.outer(middle @ normal, normal)
        made = tessellate(flat, 0.15)
        points = np.concatenate([flat, made.inner])
        chance = np.random.default_rng(seed)
        points = points + noise * chance.normal(size=(len(points), 1)) * normal
        assert made.method == "laplacian"
        assert len(find_self_intersections(points, made.triangles)) == 0

    @pytest.mark.parametrize("seed", [None, 5, 6])
    def test_touching_is_no_crossing_and_overlapping_is(self, seed: int | None) -> None:
        points = np.array(
            [
                *([0, 0, 0], [4, 0, 0], [0, 4, 0]),
                *([1, 1, 0], [2, 1, 1], [1, 2, 1]),  # a corner on the inside of the first
                *([1, 0, 0], [2, 0, 0], [1, 0, 2]),  # an edge on an edge of the first
                *([1, 1, 0], [2, 1, 0], [1, 1, -2]),  # an edge on the inside of the first
                *([4, 0, 0], [4, 4, 0], [0, 4, 0]),  # beside the first, in its plane
                *([-1, 1, 0], [1, 1, 0], [-1, 2, 0]),  # over the first, in its plane
            ],
            float,
        )
        points = points if seed is None else turned(points, seed)
        faces = np.arange(18).reshape(6, 3)
        assert find_self_intersections(points, faces).tolist() == [[0, 5]]

    def test_triangles_of_one_edge_cross_only_folded_flat(self) -> None:
        points = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 1, 0.1], [0.5, 1, 0], [0.5, -1, 0]]
        assert len(find_self_intersections(points, [[0, 1, 2], [1, 0, 3]])) == 0
        assert len(find_self_intersections(points, [[0, 1, 2], [1, 0, 4]])) == 1
        assert len(find_self_intersections(points, [[0, 1, 2], [1, 0, 5]])) == 0

    def test_triangles_of_one_corner_cross_where_they_meet_again(self) -> None:
        points = [[0, 0, 0], [4, -1, 0], [4, 1, 0], [3, 0, -1], [3, 0, 1], [-3, 0, -1], [-3, 0, 1]]
        assert find_self_intersections(points, [[0, 1, 2], [0, 3, 4]]).tolist() == [[0, 1]]
        assert len(find_self_intersections(points, [[0, 1, 2], [0, 5, 6]])) == 0

    def test_none_and_one(self) -> None:
        assert find_self_intersections(np.zeros((0, 3)), np.zeros((0, 3), int)).shape == (0, 2)
        assert find_self_intersections(np.eye(3), [[0, 1, 2]]).shape == (0, 2)
        assert find_self_intersections(np.ones((6, 3)), [[0, 1, 2], [3, 4, 5]]).shape == (0, 2)

    def test_faces_that_are_none(self) -> None:
        with pytest.raises(InvalidMeshError, match="outside"):
            find_self_intersections(np.eye(3), [[0, 1, 3]])
        with pytest.raises(InvalidMeshError, match="shape"):
            find_self_intersections(np.eye(3), [[0, 1]])
        with pytest.raises(InvalidMeshError, match="numbers"):
            find_self_intersections(np.eye(3), [[0.5, 1, 2]])


class TestArea:
    def test_triangles_and_quads(self) -> None:
        square = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]
        assert area(square, [[0, 1, 2]]) == pytest.approx(2.0)
        assert area(square, [[0, 1, 2, 3]]) == pytest.approx(4.0)
        assert area(square, np.zeros((0, 3), int)) == 0.0

    @pytest.mark.parametrize("start", range(4))
    def test_a_concave_quad_is_cut_from_its_inner_corner(self, start: int) -> None:
        dart = np.array([[-1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 10, 0]], float)
        assert area(turned(dart, 3), [np.roll(np.arange(4), start)]) == pytest.approx(9.0)
