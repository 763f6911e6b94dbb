"""Placing: boundary exact, interior harmonic, nothing flipped in convex outlines."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.errors import InvalidBoundaryError
from patterndb.geometry.quadshape import flipped, plane_normal
from query import Fill
from query.placing import lay_flat, place, quality
from query.placing.laplace import HeldQuads
from tests.support.query.placing import CONVEX, convex_outline, grid, polygon, widened

CASES = st.tuples(st.sampled_from(range(len(CONVEX))), st.integers(0, 2**32))


def dense(fill: Fill, points: np.ndarray) -> np.ndarray:
    """Every interior vertex at the mean of its neighbours, by a dense solve over the edges."""
    n = fill.n_vertices
    matrix = np.zeros((n, n))
    for quad in fill.quads.tolist():
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            matrix[a, b] = matrix[b, a] = -1.0
    matrix -= np.diag(matrix.sum(axis=1))
    p = fill.perimeter
    inner = np.linalg.solve(matrix[p:, p:], -matrix[p:, :p] @ points)
    return np.concatenate([points, inner])


def assert_faces_up(fill: Fill, vertices: np.ndarray, points: np.ndarray) -> None:
    """No quad flipped in the boundary's plane, by triangles and their sum."""
    normal = plane_normal(points)
    assert normal is not None
    a, b, c, d = (vertices[fill.quads[:, e]] for e in range(4))

    def area(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return np.cross(y - x, z - x) @ normal

    one = np.minimum(area(a, b, c), area(a, c, d))
    other = np.minimum(area(b, c, d), area(b, d, a))
    assert (np.maximum(one, other) > 0.0).all()
    whole = sum(area(points[0], points[i], points[i + 1]) for i in range(len(points) - 1))
    total = (area(a, b, c) + area(a, c, d)).sum()
    assert total == pytest.approx(whole, rel=1e-9)


class TestInThePlane:
    @settings(max_examples=150, deadline=None)
    @given(CASES)
    def test_convex_outlines(self, case: tuple[int, int]) -> None:
        chance = random.Random(case[1])
        fill = widened(CONVEX[case[0]], chance, 4)
        if fill is None:
            return
        points = convex_outline(fill.lengths, chance)
        placed = place(fill, points)
        assert placed.vertices.dtype == np.float64
        assert placed.vertices.shape == (fill.n_vertices, 3)
        assert (placed.vertices[: fill.perimeter] == points).all()
        assert len(placed.flipped) == 0
        assert_faces_up(fill, placed.vertices, points)
        normal = plane_normal(points)
        assert normal is not None
        size = np.ptp(points, axis=0).max()
        off = (placed.vertices - points[0]) @ normal
        assert np.abs(off).max() < 1e-9 * size
        assert np.abs(placed.vertices - dense(fill, points)).max() < 1e-9 * size
        assert (placed.vertices == lay_flat(fill, points)).all()

    def test_a_grid_is_a_grid(self) -> None:
        fill = grid(5, 3)
        corners = np.array([[0, 0, 0], [5, 0, 0], [5, 3, 0], [0, 3, 0]], float)
        placed = place(fill, polygon(corners, fill.lengths))
        assert quality(fill.quads, placed.vertices) == pytest.approx(0.0, abs=1e-18)
        assert np.abs(placed.vertices - placed.vertices.round()).max() < 1e-10

    def test_a_reflex_outline_is_untangled(self) -> None:
        # A deep notch in the upper side: the membrane crosses it.
        fill = grid(8, 4)
        points = polygon(
            np.array([[0, 0, 0], [8, 0, 0], [8, 4, 0], [0, 4, 0]], float), fill.lengths
        )
        top = np.flatnonzero(points[:, 1] == 4.0)
        points[top, 1] -= 3.4 * np.maximum(0.0, 1.0 - np.abs(points[top, 0] - 4.0) / 2.0)
        membrane = lay_flat(fill, points)
        up = np.tile([0.0, 0.0, 1.0], (fill.n_vertices, 1))
        assert flipped(fill.quads, membrane, up).any()
        placed = place(fill, points)
        assert len(placed.flipped) == 0
        assert (placed.vertices[: fill.perimeter] == points).all()
        assert_faces_up(fill, placed.vertices, points)

    def test_what_hangs_on_two_vertices_is_opened(self) -> None:
        # Two corners cut the inner quads off: the means of neighbours all lie on a line.
        around = [[0, 1, 2, 4], [0, 5, 2, 3]]
        inside = [[0, 4, 7, 6], [4, 2, 8, 7], [2, 5, 9, 8], [5, 0, 6, 9], [6, 7, 8, 9]]
        quads = np.array(around + inside, np.int32)
        fill = replace(grid(1, 1), quads=quads, n_vertices=10)
        outer = np.array([[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 4, 0]], float)
        up = np.tile([0.0, 0.0, 1.0], (10, 1))
        assert flipped(quads, lay_flat(fill, outer), up).sum() >= len(inside)
        placed = place(fill, outer)
        assert len(placed.flipped) == 0
        assert (placed.vertices[:4] == outer).all()
        assert_faces_up(fill, placed.vertices, outer)

    @settings(max_examples=60, deadline=None)
    @given(CASES)
    def test_with_centres_nothing_flips_either(self, case: tuple[int, int]) -> None:
        chance = random.Random(case[1])
        fill = widened(CONVEX[case[0]], chance, 3)
        if fill is not None:
            points = convex_outline(fill.lengths, chance)
            net = HeldQuads.of(fill.quads, fill.n_vertices, fill.perimeter)
            assert_faces_up(fill, net.place_centred(points), points)

    def test_no_interior(self) -> None:
        fill = grid(3, 1)
        points = polygon(
            np.array([[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0]], float), (3, 1, 3, 1)
        )
        assert (place(fill, points).vertices == points).all()


class TestQuality:
    def test_against_angles_one_by_one(self) -> None:
        rng = np.random.default_rng(5)
        fill = grid(4, 3)
        corners = np.array([[0, 0, 0], [4, 0, 0], [5, 3, 1], [0, 3, 0]], float)
        vertices = lay_flat(fill, polygon(corners, fill.lengths))
        vertices += 0.05 * rng.normal(size=vertices.shape)
        total = 0.0
        for quad in fill.quads.tolist():
            for e in range(4):
                i, j, k = quad[e], quad[(e + 1) % 4], quad[(e + 3) % 4]
                u, v = vertices[j] - vertices[i], vertices[k] - vertices[i]
                angle = np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v))
                total += (angle - np.pi / 2.0) ** 2
        assert quality(fill.quads, vertices) == pytest.approx(total / fill.n_quads)

    def test_a_dart_has_a_reflex_angle(self) -> None:
        dart = np.array([[0, 0, 0], [2, 0, 0], [0.5, 0.5, 0], [0, 2, 0]], float)
        # Angles 90, atan(1/3) twice, and 360 less the others.
        small = np.arctan2(0.5, 1.5)
        wanted = 2.0 * (small - np.pi / 2.0) ** 2 + (np.pi - 2.0 * small) ** 2
        assert quality(np.array([[0, 1, 2, 3]], np.int32), dart) == pytest.approx(wanted)


class TestRefusals:
    @pytest.mark.parametrize(
        ("points", "words"),
        [
            (np.zeros((7, 3)), "7 points for 8 boundary vertices"),
            (np.zeros((8, 3)), "in one place"),
            (np.full((8, 3), np.nan), "point 0 of"),
            (np.zeros((8, 4)), "shape (8, 4)"),
            ("no points", "no list of points"),
        ],
    )
    def test_points(self, points: object, words: str) -> None:
        with pytest.raises(InvalidBoundaryError) as caught:
            place(grid(2, 2), points)  # pyright: ignore[reportArgumentType]
        assert words in str(caught.value)
