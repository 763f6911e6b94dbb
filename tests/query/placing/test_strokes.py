"""Strands, how far strokes are from them, and pulling them onto the strokes."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from query import Boundary, Fill
from query.errors import InvalidQueryError
from query.placing import find_loops, find_strand, lay_flat, measure_flow_distance, place
from query.stroke import Stroke
from tests.support.query.placing import (
    CONVEX,
    convex_outline,
    grid,
    parallel,
    polygon,
    sphere,
    widened,
)


def rectangle(fill: Fill) -> np.ndarray:
    w, h = fill.lengths[:2]
    corners = np.array([[0, 0, 0], [w, 0, 0], [w, h, 0], [0, h, 0]], float)
    return polygon(corners, fill.lengths)


def integral(stroke: np.ndarray, line: np.ndarray, n: int = 20_000) -> float:
    """Distance of two polylines by arc length, integrated over the first's, by fine steps."""

    def at(points: np.ndarray, t: np.ndarray) -> np.ndarray:
        steps = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
        return np.stack([np.interp(t * steps[-1], steps, points[:, c]) for c in range(3)], axis=1)

    t = (np.arange(n) + 0.5) / n
    length = np.linalg.norm(np.diff(stroke, axis=0), axis=1).sum()
    return float(np.linalg.norm(at(stroke, t) - at(line, t), axis=1).mean() * length)


class TestStrand:
    @settings(max_examples=60, deadline=None)
    @given(st.sampled_from(range(len(CONVEX))), st.integers(0, 2**32))
    def test_strands_cover_every_quad_twice(self, number: int, seed: int) -> None:
        fill = widened(CONVEX[number], random.Random(seed), 3)
        if fill is None:
            return
        crossed = np.zeros(fill.n_quads, np.int64)
        ends: dict[tuple[int, int], tuple[int, int]] = {}
        for side, length in enumerate(fill.lengths):
            for edge in range(length):
                one = find_strand(fill, (side, edge))
                assert one.ends is not None and one.ends[0] == (side, edge)
                ends[one.ends[0]] = one.ends[1]
                assert len(one.edges) == len(one.quads) + 1
                for quad, (a, b), (c, d) in zip(one.quads, one.edges, one.edges[1:], strict=False):
                    # Entered by a -> b seen from ahead, left by c and d: left, then right.
                    corners = fill.quads[quad].tolist()
                    assert sorted(corners) == sorted([a, b, c, d])
                    turn = corners.index(b)
                    assert corners[turn:] + corners[:turn] == [b, a, c, d]
                np.add.at(crossed, one.quads, 1)
        assert all(ends[ends[edge]] == edge for edge in ends)
        for loop in find_loops(fill):
            assert loop.is_loop and len(loop.edges) == len(loop.quads)
            np.add.at(crossed, loop.quads, 2)
        # Every open strand was met from both its ends.
        assert (crossed == 4).all()

    def test_no_such_edge(self) -> None:
        with pytest.raises(InvalidQueryError, match="no edge 5 of side 0"):
            find_strand(grid(5, 3), (0, 5))


class TestFlowDistance:
    @settings(max_examples=40, deadline=None)
    @given(st.integers(0, 2**32), st.integers(0, 2))
    def test_against_fine_steps(self, seed: int, tolerance: int) -> None:
        chance = random.Random(seed)
        fill = grid(6, 4)
        vertices = lay_flat(fill, rectangle(fill))
        i, j = chance.randrange(6), chance.randrange(6)
        drawn = np.array([[i + 0.5, 0, 0], [chance.uniform(1, 5), 2, chance.uniform(-1, 1)]])
        drawn = np.r_[drawn, [[5 - j + 0.5, 4, 0]]]
        stroke = Stroke((0, i), (2, j), drawn)
        # Strand k runs from edge k of side 0 to edge 5 - k of side 2.
        possible = [
            integral(drawn, find_strand(fill, (0, k)).midline(vertices))
            for k in range(6)
            if abs(k - i) <= tolerance and abs(5 - k - j) <= tolerance
        ]
        found = measure_flow_distance(fill, vertices, [stroke], tolerance)
        if possible:
            assert found == pytest.approx(min(possible), rel=2e-3, abs=2e-3)
        else:
            assert found == math.inf
        # Which end comes first does not matter.
        turned = Stroke((2, j), (0, i), drawn[::-1])
        assert measure_flow_distance(fill, vertices, [turned], tolerance) == pytest.approx(found)

    def test_two_strokes_take_two_strands(self) -> None:
        fill = grid(6, 4)
        vertices = lay_flat(fill, rectangle(fill))
        line = np.array([[2.5, 0, 0], [2.5, 4, 0]])
        stroke = Stroke((0, 2), (2, 3), line)
        assert measure_flow_distance(fill, vertices, [stroke]) == pytest.approx(0.0, abs=1e-12)
        assert measure_flow_distance(fill, vertices, [stroke] * 2) == pytest.approx(4.0)
        assert measure_flow_distance(fill, vertices, [stroke] * 3) == pytest.approx(8.0)
        assert measure_flow_distance(fill, vertices, [stroke] * 4) == math.inf

    def test_without_points_nothing_counts(self) -> None:
        fill = grid(6, 4)
        assert (
            measure_flow_distance(fill, lay_flat(fill, rectangle(fill)), [Stroke((0, 0), (2, 0))])
            == 0.0
        )

    def test_loops_begin_anywhere_and_run_either_way(self) -> None:
        fill, points = with_loop()
        vertices = lay_flat(fill, points)
        (ring,) = find_loops(fill)
        drawn = ring.midline(vertices)
        for turn in range(len(drawn)):
            for sense in (1, -1):
                stroke = Stroke.loop(np.roll(drawn, turn, axis=0)[::sense])
                # The start is sought in steps of a 64th of the loop.
                length = np.linalg.norm(drawn - np.roll(drawn, 1, axis=0), axis=1).sum()
                assert measure_flow_distance(fill, vertices, [stroke]) < length * length / 100
        assert (
            measure_flow_distance(fill, vertices, [Stroke.loop(drawn + np.array([0.0, 0.0, 2.0]))])
            > 1.5
        )
        assert measure_flow_distance(grid(2, 2), vertices, [Stroke.loop(drawn)]) == math.inf


def with_loop() -> tuple[Fill, np.ndarray]:
    """A fill with one loop strand, and points on a circle for its boundary."""
    chance = random.Random(1)
    for pattern in CONVEX:
        if pattern.n_loops == 1:
            fill = widened(pattern, chance, 1)
            if fill is not None and len(find_loops(fill)) == 1:
                turn = 2.0 * np.pi * np.arange(fill.perimeter) / fill.perimeter
                return fill, 3.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    raise AssertionError("no pattern with a loop")


class TestPulling:
    def test_a_strand_comes_to_lie_on_its_stroke(self) -> None:
        fill = grid(8, 6)
        points = rectangle(fill)
        t = np.linspace(0.0, 1.0, 30)
        drawn = np.stack([3.5 + 1.2 * np.sin(np.pi * t), 6.0 * t, 0.0 * t], axis=1)
        stroke = Stroke.drawn(Boundary(fill.lengths, points=points), drawn)
        placed = place(fill, points, strokes=[stroke], tolerance=0)
        assert placed.pull == 1.0
        assert placed.strokes_before.shape == placed.strokes_after.shape == (1, 2)
        assert placed.strokes_after[0, 0] < 0.1 * placed.strokes_before[0, 0]
        assert placed.strokes_after[0, 1] < placed.strokes_before[0, 1]
        assert len(placed.flipped) == 0
        assert (placed.vertices[: fill.perimeter] == points).all()
        assert (placed.vertices[:, 2] == 0.0).all()
        assert place(fill, points).strokes_before.shape == (0, 2)

    def test_two_strokes_on_a_sphere(self) -> None:
        surface = sphere()
        fill = grid(8, 8)
        points = parallel(surface, 32, 10.0)
        boundary = Boundary(fill.lengths, points=points)
        strokes = []
        for start, end, bend in ((3, 20, 0.35), (11, 28, -0.3)):
            a, b = (points[i] / 2 + points[i + 1] / 2 for i in (start, end))
            t = np.linspace(0.0, 1.0, 40)[:, None]
            side = np.cross(b - a, [0.0, 0.0, 1.0])
            lifted = a + t * (b - a) + np.sin(np.pi * t) * ([0.0, 0.0, 1.0] + bend * side)
            line = surface.nearest(lifted / np.linalg.norm(lifted, axis=1, keepdims=True)).points
            strokes.append(Stroke.drawn(boundary, line))
        placed = place(fill, points, surface, strokes)
        assert (placed.strokes_after[:, 0] < 0.5 * placed.strokes_before[:, 0]).all()
        assert len(placed.flipped) == 0
        assert placed.off_surface < 1e-6
        assert (placed.vertices[:32] == points).all()

    def test_a_loop_comes_to_lie_on_its_stroke(self) -> None:
        fill, points = with_loop()
        (ring,) = find_loops(fill)
        drawn = ring.midline(lay_flat(fill, points))
        middle = drawn.mean(axis=0)
        placed = place(fill, points, strokes=[Stroke.loop(middle + 1.2 * (drawn - middle))])
        assert placed.strokes_after[0, 0] < 0.6 * placed.strokes_before[0, 0]
        assert len(placed.flipped) == 0

    @settings(max_examples=80, deadline=None)
    @given(
        st.sampled_from(range(len(CONVEX))),
        st.integers(0, 2**32),
        st.integers(1, 3),
        st.booleans(),
    )
    def test_no_strand_ends_farther_from_its_stroke(
        self, number: int, seed: int, count: int, curved: bool
    ) -> None:
        """Whatever was drawn: across the fill or far off, alone or in each other's way."""
        chance = random.Random(seed)
        fill = widened(CONVEX[number], chance, 4)
        if fill is None:
            return
        surface = sphere(2) if curved else None
        if surface is not None:
            points = parallel(surface, fill.perimeter, chance.uniform(-30.0, 60.0))
        else:
            points = convex_outline(fill.lengths, chance)
        size = float(np.ptp(points, axis=0).max())
        strokes: list[Stroke] = []
        for _ in range(count):
            side = chance.randrange(len(fill.lengths))
            strand = find_strand(fill, (side, chance.randrange(fill.lengths[side])))
            assert strand.ends is not None
            ends = points[strand.edges[[0, -1]]].mean(axis=1)
            off = size * np.array([chance.uniform(-0.6, 0.6) for _ in range(3)])
            strokes.append(Stroke(*strand.ends, [ends[0], points.mean(axis=0) + off, ends[1]]))
        placed = place(fill, points, surface, strokes, tolerance=chance.randrange(2))
        before, after = placed.strokes_before, placed.strokes_after
        known = ~np.isnan(before)
        assert (after[known] <= before[known]).all()
        assert (known == ~np.isnan(after)).all()

    def test_a_stroke_without_strand_or_points(self) -> None:
        fill = grid(6, 4)
        line = np.array([[0.5, 0, 0], [0, 1.5, 0]])
        strokes = [Stroke((0, 0), (3, 2), line), Stroke((0, 0), (2, 5))]
        placed = place(fill, rectangle(fill), strokes=strokes)
        assert np.isnan(placed.strokes_before).all() and np.isnan(placed.strokes_after).all()
        assert placed.pull == 0.0

    def test_no_such_edge(self) -> None:
        fill = grid(6, 4)
        with pytest.raises(InvalidQueryError, match="no edge 6 of side 2"):
            place(fill, rectangle(fill), strokes=[Stroke((0, 0), (2, 6))])
        with pytest.raises(InvalidQueryError, match="tolerance is -1"):
            place(fill, rectangle(fill), tolerance=-1)
