"""Geodesics: shortest in what can be unrolled, and locally shortest on everything else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.tracing import Trace, trace_geodesic
from tests.patterndb_sketch.retopo.tracing.test_planarcut import CUBE, CUBE_FACES, lies_within
from tests.support.retopo.surfaces import bumps, grid, plane, raised, sphere, tube


def between(surface: Surface, a: np.ndarray, b: np.ndarray) -> Trace:
    feet = surface.nearest([a, b])
    trace = trace_geodesic(surface, feet[:1], feet[1:])
    assert (trace.points[0] == feet.points[0]).all()
    assert (trace.points[-1] == feet.points[1]).all()
    return trace


def somewhere(surface: Surface, rng: np.random.Generator) -> SurfacePoints:
    """A point within a triangle, on an edge, or at a vertex."""
    weights = rng.dirichlet((1.0, 1.0, 1.0))
    kind = rng.integers(3)
    weights[:kind] = 0.0
    triangle = np.array([rng.integers(len(surface.triangles))], np.int32)
    return surface.at(triangle, rng.permutation(weights / weights.sum())[None])


def shortest_through(surface: Surface, trace: Trace) -> float:
    """The least length of a path through the same edges, by a general minimiser.

    Where the path passes a vertex, from triangle to triangle with no edge in common, its own.
    """
    line = trace.points
    edges = []
    for one, two in zip(trace.triangles[:-1], trace.triangles[1:], strict=True):
        common = np.intersect1d(surface.triangles[one], surface.triangles[two])
        if len(common) < 2:
            return trace.length
        edges.append(surface.vertices[common[:2]])
    tails, heads = np.array(edges)[:, 0], np.array(edges)[:, 1]
    along = heads - tails
    begin = np.einsum("nc,nc->n", line[1:-1] - tails, along) / (along**2).sum(axis=1)

    def length(share: np.ndarray, soft: float) -> tuple[float, np.ndarray]:
        at = np.concatenate([line[:1], tails + share[:, None] * along, line[-1:]])
        step = np.diff(at, axis=0)
        size = np.sqrt((step**2).sum(axis=1) + soft**2)
        unit = step / np.maximum(size, 1e-300)[:, None]
        return float(size.sum()), np.einsum("nc,nc->n", unit[:-1] - unit[1:], along)

    # Where the path passes a vertex segments vanish, and their length is not smooth there: it is
    # rounded less and less.
    share = np.clip(0.5 * begin + 0.25, 0.0, 1.0)
    for soft in (1e-2, 1e-4, 1e-6):
        share = minimize(
            length, share, (soft,), jac=True, bounds=[(0.0, 1.0)] * len(begin), method="L-BFGS-B",
            options={"ftol": 1e-15, "gtol": 1e-12, "maxiter": 400 if soft < 1e-5 else 60},
        ).x  # fmt: skip
    return length(share, 0.0)[0]


def straight_all_round(surface: Surface, trace: Trace) -> None:
    """At every vertex inside that the path passes, is neither side less than a straight angle?

    By brute force: the angles of all triangles in order round the vertex, and where the path
    comes and goes among them.
    """
    border = np.zeros(len(surface.vertices), bool)
    sides = surface.adjacency.border
    border[surface.triangles[sides // 3, sides % 3]] = True
    border[surface.triangles[sides // 3, (sides % 3 + 1) % 3]] = True
    for k in range(1, len(trace.points) - 1):
        at = trace.points[k]
        off = np.linalg.norm(surface.vertices - at, axis=1)
        v = int(off.argmin())
        if off[v] > 1e-12 or border[v]:
            continue
        turn, places = 0.0, {}
        f, e = np.argwhere(surface.triangles == v)[0]
        first = f
        while True:
            corner = surface.vertices[surface.triangles[f]]
            u, w = corner[(e + 1) % 3] - at, corner[(e + 2) % 3] - at
            for name, point, held in (
                ("came", trace.points[k - 1], trace.triangles[k - 1]),
                ("goes", trace.points[k + 1], trace.triangles[k]),
            ):
                if held == f:
                    places[name] = turn + angle(u, point - at)
            turn += angle(u, w)
            side = surface.adjacency.across[3 * f + (e + 2) % 3]
            f = side // 3
            e = int(np.flatnonzero(surface.triangles[f] == v)[0])
            if f == first:
                break
        # Both segments may lie in triangles that the path only touches there.
        if len(places) == 2:
            one = abs(places["came"] - places["goes"])
            assert min(one, turn - one) > np.pi - 1e-6


def angle(u: np.ndarray, w: np.ndarray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(u, w)), u @ w))


class TestUnrolled:
    @settings(max_examples=100, deadline=None)
    @given(st.integers(0, 2**32))
    def test_on_the_plane_it_is_the_straight_line(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        flat = plane(seed=seed % 7)
        a, b = somewhere(flat, rng), somewhere(flat, rng)
        apart = float(np.linalg.norm(a.points - b.points))
        if apart == 0.0:
            return
        trace = trace_geodesic(flat, a, b)
        assert trace.length == pytest.approx(apart, rel=1e-9)
        lies_within(flat, trace)

    @settings(max_examples=100, deadline=None)
    @given(st.integers(0, 2**32))
    def test_round_a_prism(self, seed: int) -> None:
        pipe = tube()
        rng = np.random.default_rng(seed)
        a, b = rng.integers(len(pipe.vertices), size=2)
        apart = abs(a % 32 - b % 32)
        around = min(apart, 32 - apart) * 2.0 * np.sin(np.pi / 32)
        up = abs(pipe.vertices[a, 2] - pipe.vertices[b, 2])
        # Nearly opposite points have two paths, one to each side, of nearly one length.
        if a == b or around > 0.8 * 32 * np.sin(np.pi / 32):
            return
        trace = between(pipe, pipe.vertices[a], pipe.vertices[b])
        assert trace.length == pytest.approx(np.hypot(around, up), rel=1e-9)
        lies_within(pipe, trace)

    def test_over_the_edges_of_a_cube(self) -> None:
        cube = Surface.from_arrays(CUBE, CUBE_FACES).orient()
        centres = (0.5, 0.5, 1.0), (1.0, 0.5, 0.5)
        assert between(cube, *np.array(centres)).length == pytest.approx(1.0, rel=1e-12)
        # From corner to opposite corner over two faces unrolled.
        assert between(cube, CUBE[0], CUBE[7]).length == pytest.approx(np.sqrt(5.0), rel=1e-12)

    def test_round_a_hole_it_bends_at_the_border(self) -> None:
        at, faces = grid(10, 10, 0.1)
        middle = at[faces].mean(axis=1)
        kept = (np.abs(middle - 0.5) > 0.2).any(axis=1)
        holed = Surface.from_arrays(raised(at, lambda x, y: 0.0 * x), faces[kept]).orient()
        trace = between(holed, np.array((0.1, 0.5, 0.0)), np.array((0.9, 0.5, 0.0)))
        assert trace.length == pytest.approx(2.0 * np.hypot(0.2, 0.2) + 0.4, rel=1e-9)


class TestCurved:
    @settings(max_examples=30, deadline=None)
    @given(st.integers(0, 2**32))
    @example(1387720)
    def test_locally_shortest_on_hills(self, seed: int) -> None:
        hills = bumps(seed % 11, 10)
        rng = np.random.default_rng(seed)
        a, b = somewhere(hills, rng), somewhere(hills, rng)
        if (a.points == b.points).all():
            return
        trace = trace_geodesic(hills, a, b)
        lies_within(hills, trace)
        straight_all_round(hills, trace)
        if len(trace.points) > 2:
            # The general minimiser may stop early; never is it shorter.
            least = shortest_through(hills, trace)
            assert trace.length <= least * (1.0 + 1e-9)
            assert least <= trace.length * (1.0 + 1e-4)

    @settings(max_examples=40, deadline=None)
    @given(st.integers(0, 2**32))
    def test_on_a_ball_it_is_near_the_great_circle(self, seed: int) -> None:
        ball = sphere(4)
        a, b = np.random.default_rng(seed).normal(size=(2, 3))
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        trace = between(ball, a, b)
        assert trace.length == pytest.approx(angle(a, b), rel=3e-3, abs=1e-4)
        straight_all_round(ball, trace)
        back = between(ball, b, a)
        assert back.length == pytest.approx(trace.length, rel=1e-3)

    def test_sampled_it_stays_on_the_surface(self) -> None:
        hills = bumps(2)
        trace = between(hills, np.array((0.1, 0.1, 0.0)), np.array((0.9, 0.8, 0.0)))
        stroke = trace.sample(hills, 0.01)
        assert not stroke.closed and len(stroke.points) == round(trace.length / 0.01) + 1
        assert (stroke.points[[0, -1]] == trace.points[[0, -1]]).all()
        assert np.abs(hills.nearest(stroke.points).points - stroke.points).max() < 1e-12


class TestUnusualSurfaces:
    def test_a_fin_on_an_edge_of_three_triangles(self) -> None:
        points = [(0, 0, 0), (0, 2, 0), (1, 1, 0), (-1, 1, 0), (0, 1, 1)]
        fin = Surface.from_arrays(points, [(0, 2, 1), (0, 1, 3), (0, 4, 1)]).orient()
        tips = np.array(points, float)[2:]
        for a, b in ((0, 1), (1, 2), (0, 2)):
            assert between(fin, tips[a], tips[b]).length == pytest.approx(2.0, rel=1e-12)

    def test_neighbours_turned_against_each_other(self) -> None:
        hills = bumps(4)
        turned = hills.triangles.copy()
        turned[::3] = turned[::3, ::-1]
        a, b = np.array((0.2, 0.1, 0.0)), np.array((0.7, 0.9, 0.0))
        one = between(hills, *hills.nearest([a, b]).points)
        two = between(
            Surface.from_arrays(hills.vertices, turned).orient(), *hills.nearest([a, b]).points
        )
        assert two.length == pytest.approx(one.length, rel=1e-9)

    def test_vertices_that_stand_double_are_one(self) -> None:
        flat = plane()
        soup = Surface.from_arrays(
            flat.vertices[flat.triangles.ravel()], np.arange(2400).reshape(-1, 3)
        ).orient()
        assert len(soup.vertices) == len(flat.vertices)
        trace = between(soup, np.array((0.1, 0.1, 0.0)), np.array((1.7, 1.3, 0.0)))
        assert trace.length == pytest.approx(2.0, rel=1e-12)


class TestRefusals:
    def test_parts_that_do_not_hang_together(self) -> None:
        flat = plane(4, 4)
        both = Surface.from_arrays(
            np.concatenate([flat.vertices, flat.vertices + np.array((5.0, 0.0, 0.0))]),
            np.concatenate([flat.triangles, flat.triangles + len(flat.vertices)]),
        ).orient()
        with pytest.raises(RefusedError, match="do not hang together"):
            between(both, np.array((0.1, 0.1, 0.0)), np.array((5.3, 0.1, 0.0)))

    def test_one_place_and_several(self) -> None:
        flat = plane(4, 4)
        feet = flat.nearest([(0.1, 0.1, 0.0), (0.2, 0.2, 0.0)])
        with pytest.raises(RefusedError, match="two points"):
            trace_geodesic(flat, feet[:1], feet[:1])
        with pytest.raises(InvalidRetopoError, match="one point"):
            trace_geodesic(flat, feet, feet[:1])
