"""Picking and drawing on meshes, beside a solver for every ray and triangle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.errors import InvalidMeshError
from patterndb_sketch.surfacing.tessellation import Canvas, draw, pick, tessellate
from query.placing import Surface
from tests.support.surfacing.tessellation import wobbly


def brute_force(
    points: np.ndarray, faces: np.ndarray, origin: np.ndarray, direction: np.ndarray
) -> tuple[float, int]:
    """The nearest hit's distance and face, each triangle as a linear system."""
    way = direction / np.linalg.norm(direction)
    best = (np.inf, -1)
    for number, (a, b, c) in enumerate(points[faces]):
        try:
            v, w, s = np.linalg.solve(np.stack([b - a, c - a, -way], axis=1), origin - a)
        except np.linalg.LinAlgError:
            continue
        if v >= 0 and w >= 0 and v + w <= 1 and s >= 0:
            best = min(best, (s, number))
    return best


def a_patch(seed: int) -> tuple[np.ndarray, np.ndarray]:
    outline = wobbly(40, seed, 0.0)
    made = tessellate(outline, 0.2)
    return np.concatenate([outline, made.inner]), made.triangles


class TestPick:
    @settings(max_examples=25, deadline=None)
    @given(st.integers(1, 30), st.integers(0, 2**32))
    def test_equals_brute_force_on_random_meshes(self, f: int, seed: int) -> None:
        chance = np.random.default_rng(seed)
        points = chance.normal(size=(3 * f, 3))
        faces = np.arange(3 * f).reshape(f, 3)
        canvas = Canvas.of(points, faces)
        for _ in range(6):
            origin, direction = chance.normal(size=3), chance.normal(size=3)
            found = canvas.pick(origin, direction)
            distance, face = brute_force(points, faces, origin, direction)
            if found is None:
                assert face == -1
                continue
            assert found.face == face
            assert found.distance == pytest.approx(distance, rel=1e-9, abs=1e-9)
            way = direction / np.linalg.norm(direction)
            assert found.point == pytest.approx(origin + distance * way, abs=1e-8)

    @settings(max_examples=20, deadline=None)
    @given(st.integers(0, 2**32))
    def test_hits_lie_on_the_mesh_within_a_millionth(self, seed: int) -> None:
        points, faces = a_patch(seed % 50)
        chance = np.random.default_rng(seed)
        origins = points.mean(axis=0) + 5.0 * chance.normal(size=(30, 3))
        goals = points[chance.integers(len(points), size=30)] + 0.1 * chance.normal(size=(30, 3))
        face, hits, distances = Canvas.of(points, faces).picks(origins, goals - origins)
        met = face >= 0
        nearest = Surface.from_arrays(points, faces).nearest(hits[met]).points
        assert np.linalg.norm(nearest - hits[met], axis=1).max(initial=0.0) < 1e-6
        way = (goals - origins) / np.linalg.norm(goals - origins, axis=1)[:, None]
        along = origins + distances[:, None] * way
        assert np.linalg.norm(along - hits, axis=1)[met].max(initial=0.0) < 1e-6
        assert np.isnan(hits[~met]).all() and np.isnan(distances[~met]).all()

    @pytest.mark.parametrize("seed", range(5))
    def test_no_ray_slips_through_between_faces(self, seed: int) -> None:
        points, faces = a_patch(seed)
        n_boundary = 40
        inner = points[n_boundary:]
        ends = np.unique(np.sort(faces[:, [0, 1]], axis=1), axis=0)
        ends = ends[(ends >= n_boundary).all(axis=1)]
        goals = np.concatenate([inner, points[ends].mean(axis=1)])
        origin = points.mean(axis=0) + np.array([3.0, 4.0, 5.0])
        face, _, distances = Canvas.of(points, faces).picks(
            np.repeat(origin[None], len(goals), axis=0), goals - origin
        )
        assert (face >= 0).all()
        assert (distances <= np.linalg.norm(goals - origin, axis=1) + 1e-9).all()

    def test_both_sides_count_and_only_ahead(self) -> None:
        points, faces = np.eye(3), [[0, 1, 2]]
        for origin, direction in (([0, 0, 0], [2, 2, 2]), ([1, 1, 1], [-1, -1, -1])):
            found = pick(points, faces, origin, direction)
            assert found is not None and found.point == pytest.approx(np.full(3, 1 / 3))
            assert pick(points, faces, origin, np.negative(direction)) is None

    def test_a_quad_is_one_face(self) -> None:
        points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]]
        canvas = Canvas.of(points, [[0, 1, 2, 3], [1, 4, 5, 2]])
        for x, face in ((0.2, 0), (0.9, 0), (1.1, 1), (1.9, 1)):
            found = canvas.pick([x, 0.3, 7], [0, 0, -1])
            assert found is not None and found.face == face and found.distance == 7.0
            assert found.point == pytest.approx([x, 0.3, 0.0])

    def test_nothing_to_meet(self) -> None:
        assert pick(np.zeros((0, 3)), np.zeros((0, 3), int), [0, 0, 0], [0, 0, 1]) is None
        assert pick(np.ones((3, 3)), [[0, 1, 2]], [1, 1, 0], [0, 0, 1]) is None

    def test_rays_that_are_none(self) -> None:
        with pytest.raises(InvalidMeshError, match="no length"):
            pick(np.eye(3), [[0, 1, 2]], [0, 0, 0], [0, 0, 0])
        with pytest.raises(InvalidMeshError, match="one each"):
            draw(np.eye(3), [[0, 1, 2]], np.zeros((2, 3)), np.ones((3, 3)))
        with pytest.raises(InvalidMeshError, match="not finite"):
            pick(np.eye(3), [[0, 1, 2]], [0, 0, np.inf], [0, 0, 1])


class TestDraw:
    def test_a_stroke_breaks_where_rays_miss_and_nothing_is_lost(self) -> None:
        points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        points += [[2, 0, 0], [3, 0, 0], [3, 1, 0], [2, 1, 0]]
        x = np.linspace(-0.5, 3.5, 41)
        origins = np.stack([x, np.full(41, 0.5), np.full(41, 2.0)], axis=1)
        drawn = draw(points, [[0, 1, 2, 3], [4, 5, 6, 7]], origins, np.tile([0, 0, -1], (41, 1)))
        assert len(drawn.strokes) == 2
        together = np.concatenate([*drawn.rays, drawn.missed])
        assert sorted(together.tolist()) == list(range(41))
        for stroke, rays in zip(drawn.strokes, drawn.rays, strict=True):
            assert stroke == pytest.approx(np.c_[x[rays], np.full(len(rays), 0.5), 0.0 * rays])
            assert (np.diff(rays) == 1).all()

    def test_a_stroke_beside_the_mesh(self) -> None:
        drawn = draw(np.eye(3), [[0, 1, 2]], np.full((3, 3), 5.0), np.ones((3, 3)))
        assert drawn.strokes == () and drawn.missed.tolist() == [0, 1, 2]
