"""Planar cuts: in the plane, whole, closed or from border to border, and given up when long."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.tracing import Trace, cut_by_plane
from tests.support.retopo.surfaces import bumps, plane, sphere, tube

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE_FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)


def lies_within(surface: Surface, trace: Trace) -> None:
    """Does every segment lie in its triangle, and every point of the line on the surface?"""
    line = trace.round
    assert len(line) == len(trace.triangles) + 1
    corner = surface.vertices[surface.triangles[trace.triangles]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(normal, axis=1)
    for at in (line[:-1], line[1:]):
        for e in range(3):
            tail, head = corner[:, e], corner[:, (e + 1) % 3]
            inside = np.einsum("nc,nc->n", np.cross(head - tail, at - tail), normal)
            assert (inside >= -1e-9 * size**2).all()
        off = np.einsum("nc,nc->n", at - corner[:, 0], normal) / size
        assert np.abs(off).max() < 1e-9 * surface.diagonal


def cut_triangles(surface: Surface, point: np.ndarray, normal: np.ndarray) -> float:
    """The whole length of the plane's cuts through all triangles, one after the other."""
    total = 0.0
    height = (surface.vertices - point) @ normal
    height[np.abs(height) < 1e-13] = 0.0
    side = height[surface.triangles] >= 0.0
    for corner in surface.triangles[side.any(axis=1) & ~side.all(axis=1)]:
        ends = [
            (height[i] * surface.vertices[j] - height[j] * surface.vertices[i])
            / (height[i] - height[j])
            for i, j in zip(corner, np.roll(corner, -1), strict=True)
            if (height[i] >= 0.0) != (height[j] >= 0.0)
        ]
        if ends:
            total += float(np.linalg.norm(ends[1] - ends[0]))
    return total


class TestClosed:
    @settings(max_examples=40, deadline=None)
    @given(st.integers(0, 2**32), st.booleans())
    def test_a_ball_is_cut_in_one_loop(self, seed: int, at_vertex: bool) -> None:
        ball = sphere(3)
        rng = np.random.default_rng(seed)
        normal, at = rng.normal(size=(2, 3))
        if at_vertex:
            at = ball.vertices[rng.integers(len(ball.vertices))]
        start = ball.nearest(at[None])
        height = (ball.vertices - start.points[0]) @ normal
        if np.minimum(height.max(), -height.min()) < 0.05 * np.linalg.norm(normal):
            return
        trace = cut_by_plane(ball, start, normal)
        assert trace.closed
        assert np.abs((trace.points - start.points[0]) @ normal).max() < 1e-9
        lies_within(ball, trace)
        assert trace.length == pytest.approx(cut_triangles(ball, start.points[0], normal), rel=1e-9)
        # The half that the normal points to is on the left.
        middle = trace.round[:-1] + 0.5 * np.diff(trace.round, axis=0)
        left = np.cross(middle, np.diff(trace.round, axis=0))
        assert (left @ normal > 0.0).all()
        # It passes through the start, in its last segment but for starts on an edge.
        along = np.diff(trace.round, axis=0)
        to = start.points[0] - trace.round[:-1]
        share = np.clip(np.einsum("nc,nc->n", to, along) / (along**2).sum(axis=1), 0.0, 1.0)
        assert np.linalg.norm(to - share[:, None] * along, axis=1).min() < 1e-9
        if start.weights.min() > 1e-6:
            assert start.triangles[0] == trace.triangles[-1]

    def test_through_vertices_and_along_edges_of_a_cube(self) -> None:
        cube = Surface.from_arrays(CUBE, CUBE_FACES).orient()
        start = cube.nearest([(0.5, 0.5, 1.0)])
        for normal, length in (
            ((1.0, -1.0, 0.0), 2.0 + 2.0 * np.sqrt(2.0)),
            ((-1.0, 1.0, 0.0), 2.0 + 2.0 * np.sqrt(2.0)),
            ((1.0, 0.0, 0.0), 4.0),
            ((0.0, 0.0, 1.0), 4.0),
        ):
            trace = cut_by_plane(cube, start, normal)
            assert trace.closed
            assert trace.length == pytest.approx(length, rel=1e-12)
            assert (np.diff(trace.round, axis=0) != 0.0).any(axis=1).all()
            lies_within(cube, trace)

    @pytest.mark.parametrize(
        ("point", "normal"),
        [((0.2, 0.3, 1.0), (0.0, 0.0, -1.0)), ((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))],
    )
    def test_a_plane_that_only_touches_is_refused(
        self, point: tuple[float, ...], normal: tuple[float, ...]
    ) -> None:
        cube = Surface.from_arrays(CUBE, CUBE_FACES).orient()
        with pytest.raises(RefusedError, match="only touches"):
            cut_by_plane(cube, cube.nearest([point]), normal)

    def test_parts_are_cut_one_by_one(self) -> None:
        ball = sphere(2)
        both = Surface.from_arrays(
            np.concatenate([ball.vertices, ball.vertices + np.array((3.0, 0.0, 0.0))]),
            np.concatenate([ball.triangles, ball.triangles + len(ball.vertices)]),
        ).orient()
        start = both.nearest([(0.0, 1.0, 0.1)])
        one = cut_by_plane(ball, ball.nearest([(0.0, 1.0, 0.1)]), (0.0, 0.0, 1.0))
        two = cut_by_plane(both, start, (0.0, 0.0, 1.0))
        assert two.closed and two.length == pytest.approx(one.length, rel=1e-12)


class TestOpen:
    @settings(max_examples=25, deadline=None)
    @given(st.integers(0, 2**32))
    def test_from_border_to_border(self, seed: int) -> None:
        hills = bumps(seed)
        rng = np.random.default_rng(seed)
        start = hills.nearest(rng.uniform(0.3, 0.7, (1, 3)))
        turn = rng.uniform(0.0, 2.0 * np.pi)
        normal = np.array((np.cos(turn), np.sin(turn), 0.0))
        trace = cut_by_plane(hills, start, normal)
        assert not trace.closed
        lies_within(hills, trace)
        ends = trace.points[[0, -1], :2]
        assert np.abs(ends - 0.5).max(axis=1) == pytest.approx(0.5, abs=1e-9)
        # Over hills, seen from above, it is a straight line.
        flat = trace.points[:, :2] - trace.points[0, :2]
        along = flat @ (np.array((-normal[1], normal[0])))
        assert (np.diff(along) * np.sign(along[-1]) > 0.0).all()
        back = cut_by_plane(hills, start, -normal)
        assert np.abs(back.points[::-1] - trace.points).max() < 1e-9

    def test_a_tube_is_cut_round_and_along(self) -> None:
        pipe = tube()
        side = 2.0 * np.sin(np.pi / 32)
        start = pipe.nearest([(1.0, 0.0, 0.73)])
        around = cut_by_plane(pipe, start, (0.0, 0.0, 1.0))
        assert around.closed and around.length == pytest.approx(32 * side, rel=1e-12)
        along = cut_by_plane(pipe, start, (0.0, 1.0, 0.0))
        assert not along.closed and along.length == pytest.approx(2.0, rel=1e-12)

    def test_neighbours_turned_against_each_other(self) -> None:
        flat = plane(6, 6)
        turned = flat.triangles.copy()
        turned[::3] = turned[::3, ::-1]
        mixed = Surface.from_arrays(flat.vertices, turned).orient()
        start = mixed.nearest([(0.31, 0.32, 0.0)])
        trace = cut_by_plane(mixed, start, (1.0, 0.2, 0.0))
        again = cut_by_plane(flat, flat.nearest([(0.31, 0.32, 0.0)]), (1.0, 0.2, 0.0))
        assert trace.length == pytest.approx(again.length, rel=1e-12)


class TestLimit:
    def test_given_up_beyond_it(self) -> None:
        ball = sphere(3)
        start = ball.nearest([(1.0, 0.0, 0.01)])
        length = cut_by_plane(ball, start, (0.0, 0.0, 1.0)).length
        assert cut_by_plane(ball, start, (0.0, 0.0, 1.0), limit=length * 1.001).closed
        with pytest.raises(RefusedError, match="longer than its limit"):
            cut_by_plane(ball, start, (0.0, 0.0, 1.0), limit=0.999 * length)

    def test_both_halves_of_an_open_cut_count(self) -> None:
        flat = plane()
        start = flat.nearest([(1.0, 1.0, 0.0)])
        assert cut_by_plane(flat, start, (1.0, 0.0, 0.0), limit=2.001).length == pytest.approx(2.0)
        with pytest.raises(RefusedError, match="longer than its limit"):
            cut_by_plane(flat, start, (1.0, 0.0, 0.0), limit=1.999)

    @pytest.mark.parametrize("normal", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (1.0, 0.0)])
    def test_a_plane_needs_a_direction(self, normal: tuple[float, ...]) -> None:
        flat = plane(2, 2)
        with pytest.raises(InvalidRetopoError, match="direction"):
            cut_by_plane(flat, flat.nearest([(0.1, 0.1, 0.0)]), normal)


class TestSampled:
    def test_even_steps_on_the_surface(self) -> None:
        ball = sphere(4)
        trace = cut_by_plane(ball, ball.nearest([(1.0, 0.0, 0.2)]), (0.0, 0.1, 1.0))
        stroke = trace.sample(ball, 0.05)
        assert stroke.closed and len(stroke.points) == round(trace.length / 0.05)
        feet = ball.nearest(stroke.points)
        assert np.abs(feet.points - stroke.points).max() < 1e-12
        assert np.einsum("nc,nc->n", feet.normals, stroke.normals).min() > 0.9999
        steps = np.linalg.norm(np.roll(stroke.points, -1, axis=0) - stroke.points, axis=1)
        assert np.ptp(steps) < 1e-3 * 0.05

    def test_ends_of_an_open_one_are_exact(self) -> None:
        hills = bumps(1)
        trace = cut_by_plane(hills, hills.nearest([(0.5, 0.5, 0.0)]), (1.0, 0.3, 0.0))
        stroke = trace.sample(hills, 0.01)
        assert (stroke.points[[0, -1]] == trace.points[[0, -1]]).all() and not stroke.closed
