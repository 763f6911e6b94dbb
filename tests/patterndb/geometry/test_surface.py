"""The surface: what is next to what, what is repaired, and projection."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.adjacency import Adjacency
from patterndb.geometry.surface import Surface
from tests.support.retopo.surfaces import bumps, sphere


def plates(gap: float) -> Surface:
    """Two squares of side 2, the upper facing up and the lower facing down."""
    square = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    return Surface.from_arrays(
        np.concatenate([square + np.array((0, 0, gap)), square]),
        np.concatenate([faces, faces[:, ::-1] + 4]),
    ).orient()


class TestTopology:
    @settings(max_examples=60, deadline=None)
    @given(st.integers(0, 2**32))
    def test_against_all_pairs_of_sides(self, seed: int) -> None:
        # Any triangles at all: edges of one to many.
        rng = np.random.default_rng(seed)
        vertices = rng.normal(size=(7, 3))
        faces = np.array([rng.choice(7, 3, replace=False) for _ in range(9)], np.int32)
        topology = Adjacency.of(vertices, faces)
        ends = np.sort(np.stack([faces.ravel(), np.roll(faces, -1, axis=1).ravel()], 1), axis=1)
        assert (topology.ends[topology.edges] == ends).all()
        for side in range(27):
            alike = np.flatnonzero((ends == ends[side]).all(axis=1))
            k = topology.edges[side]
            assert sorted(topology.sides[topology.side_start[k] : topology.side_start[k + 1]]) == (
                alike.tolist()
            )
            other = topology.across[side]
            if other >= 0:
                assert other in alike and other != side and topology.across[other] == side
            free = alike[topology.across[alike] < 0]
            assert len(free) == len(alike) % 2
        for v in range(7):
            star = topology.star[topology.star_start[v] : topology.star_start[v + 1]]
            assert sorted(star) == sorted(set(ends[(ends == v).any(axis=1)].ravel()) - {v})

    def test_of_three_at_an_edge_the_straightest_two_are_neighbours(self) -> None:
        points = np.array([(0, 0, 0), (0, 2, 0), (1, 1, 0.1), (-1, 1, 0), (0.1, 1, 1)], float)
        topology = Adjacency.of(points, np.array([(0, 2, 1), (0, 4, 1), (0, 1, 3)], np.int32))
        assert topology.across[2] == 6 and topology.across[6] == 2 and topology.across[5] == -1


class TestSurface:
    def test_vertices_at_one_place_are_one_in_the_order_given(self) -> None:
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        surface = Surface.from_arrays(points, [(0, 1, 2), (3, 4, 5), (1, 3, 4)]).orient()
        assert surface.repairs.vertex.tolist() == [0, 1, 2, 1, 3, 2]
        assert (surface.vertices[surface.repairs.vertex] == points).all()
        assert surface.repairs.dropped == 1 and len(surface.triangles) == 2
        assert len(surface.adjacency.border) == 4
        assert surface.diagonal == pytest.approx(math.sqrt(2.0))

    def test_what_is_no_surface(self) -> None:
        with pytest.raises(InvalidMeshError, match="no triangle with an area"):
            Surface.from_arrays(np.zeros((3, 3)), [(0, 1, 2)]).orient()
        with pytest.raises(InvalidMeshError, match="triangulate"):
            Surface.from_arrays(np.eye(4)[:, :3], [(0, 1, 2, 3)]).orient()


class TestProjection:
    @settings(max_examples=15, deadline=None)
    @given(st.integers(0, 2**32))
    def test_the_nearest_hit_that_faces_as_the_normal_does(self, seed: int) -> None:
        surface = bumps(seed % 5, 8)
        rng = np.random.default_rng(seed)
        points = rng.uniform((-0.1, -0.1, -0.3), (1.1, 1.1, 0.3), (30, 3))
        normals = rng.normal(size=(30, 3))
        reach = 0.4
        done = surface.project(points, normals, reach)
        corner = surface.vertices[surface.triangles]
        faces = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        for i, (p, n) in enumerate(zip(points, normals, strict=True)):
            n = n / np.linalg.norm(n)
            best = np.inf
            for (a, b, c), up in zip(corner, faces, strict=True):
                if up @ n > 1e-6 * np.linalg.norm(up):
                    s, v, w = np.linalg.solve(np.stack([-n, b - a, c - a], axis=1), p - a)
                    if min(v, w, 1.0 - v - w) >= 0.0:
                        best = min(best, abs(s))
            missed = i in done.missed or i in done.lost
            assert missed == (best > reach)
            if not missed:
                assert np.linalg.norm(done.points[i] - p) == pytest.approx(best, abs=1e-7)
                assert np.linalg.norm(np.cross(done.points[i] - p, n)) < 1e-7
            assert (i in done.lost) == bool((faces @ n <= 0.0).all())
            if i not in done.lost:
                assert faces[done.triangles[i]] @ n > 0.0

    def test_points_on_the_surface_stay(self) -> None:
        ball = sphere(3)
        rng = np.random.default_rng(0)
        feet = ball.nearest(rng.normal(size=(50, 3)))
        done = ball.project(feet.points, feet.normals, 0.1)
        assert np.abs(done.points - feet.points).max() < 1e-9
        assert len(done.missed) == len(done.lost) == 0

    def test_of_a_thin_plate_the_side_that_faces(self) -> None:
        thin = plates(0.01)
        points = np.tile((0.2, 0.3, 0.002), (2, 1))
        done = thin.project(points, [(0, 0, 1.0), (0, 0, -1.0)], 0.1)
        assert done.points[:, 2].tolist() == pytest.approx([0.01, 0.0], abs=1e-12)
        assert done.normals[:, 2].tolist() == pytest.approx([1.0, -1.0])

    def test_without_a_hit_the_nearest_that_faces_and_it_is_told(self) -> None:
        thin = plates(0.5)
        # Beside both plates, nearer to the lower; too far above; and facing no plate at all.
        points = [(1.4, 0.0, 0.1), (0.0, 0.0, 9.0), (0.0, 0.0, 0.1)]
        done = thin.project(points, [(0, 0, 1.0), (0, 0, 1.0), (1.0, 0, 0)], reach=1.0)
        assert done.missed.tolist() == [0, 1] and done.lost.tolist() == [2]
        assert np.abs(done.points - [(1, 0, 0.5), (0, 0, 0.5), (0, 0, 0)]).max() < 1e-12

    def test_bad_input_is_named(self) -> None:
        ball = sphere(1)
        with pytest.raises(InvalidMeshError, match="row 1 of points is not finite"):
            ball.nearest([(0, 0, 0), (0, np.nan, 0)])
        with pytest.raises(InvalidMeshError, match="2 points have 1 normals"):
            ball.project(np.eye(3)[:2], np.eye(3)[:1], 1.0)
        with pytest.raises(InvalidMeshError, match=r"\(n, 3\)"):
            ball.nearest([(0.0, 0.0)])

    def test_nothing_of_nothing(self) -> None:
        assert len(sphere(1).project(np.empty((0, 3)), np.empty((0, 3)), 1.0).points) == 0


class TestRays:
    def test_strokes_break_where_rays_miss_and_no_ray_is_lost(self) -> None:
        points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        points += [[2, 0, 0], [3, 0, 0], [3, 1, 0], [2, 1, 0]]
        two = Surface.from_polygons(PolygonMesh.from_faces(points, [[0, 1, 2, 3], [4, 5, 6, 7]]))
        x = np.linspace(-0.5, 3.5, 41)
        origins = np.stack([x, np.full(41, 0.5), np.full(41, 2.0)], axis=1)
        hits = two.cast_rays(origins, np.tile([0.0, 0.0, -3.0], (41, 1)))
        runs = hits.list_runs()
        assert len(runs) == 2
        missed = np.flatnonzero(~hits.found)
        assert sorted(np.concatenate([*runs, missed]).tolist()) == list(range(41))
        for run in runs:
            assert hits.points[run] == pytest.approx(np.c_[x[run], np.full(len(run), 0.5), 0 * run])
            assert (np.diff(run) == 1).all()
        assert np.isnan(hits.points[missed]).all() and np.isnan(hits.normals[missed]).all()
        assert (hits.distances[missed] == np.inf).all()

    def test_nothing_to_meet(self) -> None:
        empty = Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
        hits = empty.cast_rays([[0.0, 0, 0]], [[0.0, 0, 1]])
        assert not hits.found[0] and hits.list_runs() == []
        point = Surface(np.ones((3, 3)), np.array([[0, 1, 2]], np.int32))
        assert not point.cast_rays([[1.0, 1, 0]], [[0.0, 0, 1]]).found[0]
