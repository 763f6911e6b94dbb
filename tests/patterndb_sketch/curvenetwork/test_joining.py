"""Curves are joined where that is meant, in any unit, order and sense; what is exact stays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import find_nearest_on
from patterndb_sketch.curvenetwork.joining import JoinedCurves, join_polylines
from patterndb_sketch.curvenetwork.network import CurveNetwork

SEEDS = st.integers(0, 2**32 - 1)

#: Exact places move by this at most, as a share of the drawing's diagonal: what is put on a curve
#: within SAME_PLACE of one holds it as well.
EXACT = 2e-6


def draw_cage(chance: np.random.Generator) -> list[Points]:
    """The edges of a box of cells, its nodes moved at random; some are short, others long."""
    sizes = chance.integers(1, 4, 3)
    steps = [np.r_[0.0, np.cumsum(10.0 ** chance.uniform(-2.5, 0.0, n))] for n in sizes]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1)
    finest = min(float(np.diff(step).min()) for step in steps)
    grid = grid + chance.uniform(-0.2, 0.2, grid.shape) * finest
    edges: list[Points] = []
    for axis in range(3):
        first, last = np.delete(grid, -1, axis), np.delete(grid, 0, axis)
        edges += list(np.stack([first, last], axis=-2).reshape(-1, 2, 3))
    return edges


def draw_grid(chance: np.random.Generator) -> list[Points]:
    """The lines of a bent sheet, or the rings of a torus, with samples in common at crossings."""
    n, m = (int(k) for k in chance.integers(2, 6, 2))
    closed = chance.random() < 0.5
    fine = 8
    u = np.linspace(0.0, 1.0, fine * n + 1)
    v = np.linspace(0.0, 1.0, fine * m + 1)
    if not closed:
        # Lines at uneven distances, some of them close to each other.
        u, v = u ** chance.uniform(1.0, 3.0), v ** chance.uniform(1.0, 3.0)
    a, b = 2 * np.pi * np.array(np.meshgrid(u, v, indexing="ij"))
    if closed:
        ring = 1.0 + 0.4 * np.cos(b)
        sheet = np.stack([ring * np.cos(a), ring * np.sin(a), 0.4 * np.sin(b)], axis=-1)
        sheet[-1], sheet[:, -1] = sheet[0], sheet[:, 0]
    else:
        sheet = np.stack([a, b, chance.uniform(0, 1) * np.sin(a) * np.cos(b)], axis=-1)
    lines = [sheet[k] for k in range(0, len(u) - closed, fine)]
    return lines + [sheet[:, k] for k in range(0, len(v) - closed, fine)]


def draw_loose(chance: np.random.Generator, drawn: Sequence[Points]) -> list[Points]:
    """Curves drawn by hand along some, or from one to another, off by up to a hundredth."""
    everything = np.concatenate(drawn)
    off = 10.0 ** chance.uniform(-5, -2) * np.linalg.norm(np.ptp(everything, axis=0))
    loose: list[Points] = []
    for _ in range(int(chance.integers(1, 6))):
        if chance.random() < 0.5:
            line = drawn[int(chance.integers(len(drawn)))]
            share = np.sort(chance.uniform(0, 1, int(chance.integers(5, 30))))
            at = np.linspace(0, 1, len(line))
            line = np.stack([np.interp(share, at, line[:, k]) for k in range(3)], axis=1)
        else:
            ends = everything[chance.integers(0, len(everything), 2)]
            line = ends[0] + np.linspace(0, 1, 9)[:, None] * (ends[1] - ends[0])
        loose.append(line + off * (chance.normal(size=3) + 0.1 * chance.normal(size=line.shape)))
    return [line for line in loose if (np.ptp(line, axis=0) > 0).any()]


def shuffle(drawn: Sequence[Points], chance: np.random.Generator) -> tuple[list[Points], list[int]]:
    """Some curves in another order and sense, and which each of them is."""
    order = chance.permutation(len(drawn)).tolist()
    turned = [np.ascontiguousarray(drawn[k][:: int(chance.choice([-1, 1]))]) for k in order]
    return turned, order


def list_meetings(network: CurveNetwork) -> dict[int, set[int | str]]:
    """For every node the curves that meet there, if there are two or more."""
    at: dict[int, set[int | str]] = {}
    for curve in network.curves:
        for node in curve.nodes:
            at.setdefault(node, set()).add(curve.id)
    return {node: ids for node, ids in at.items() if len(ids) > 1}


def check_kept(alone: CurveNetwork, network: CurveNetwork, reach: float) -> None:
    """Check that the other network has all nodes where curves of one meet, with these curves."""
    meetings = list_meetings(network)
    numbers = list(meetings)
    tree = KDTree(network.nodes[numbers])
    taken: set[int] = set()
    for node, ids in list_meetings(alone).items():
        gap, nearest = tree.query(alone.nodes[node])
        assert gap <= reach
        assert ids <= meetings[numbers[int(nearest)]]
        assert int(nearest) not in taken
        taken.add(int(nearest))


class TestExactStaysExact:
    @settings(deadline=None, max_examples=40)
    @given(SEEDS, st.booleans(), st.sampled_from([None, 1e-4, 3e-3, 2e-2]))
    @example(1_692_094_933, False, None)
    @example(4194304, False, None)
    @example(4194304, False, 1e-4)
    def test_nodes_and_crossings(self, seed: int, cage: bool, tolerance: float | None) -> None:
        chance = np.random.default_rng(seed)
        drawn = draw_cage(chance) if cage else draw_grid(chance)
        diagonal = float(np.linalg.norm(np.ptp(np.concatenate(drawn), axis=0)))
        exact = join_polylines(drawn, tolerance=0.0).network
        within = None if tolerance is None else tolerance * diagonal
        alone = join_polylines(drawn, tolerance=within)
        assert len(alone.network.nodes) == len(exact.nodes)
        assert len(alone.network.curves) == len(exact.curves)
        check_kept(exact, alone.network, EXACT * diagonal)
        mixed = join_polylines([*drawn, *draw_loose(chance, drawn)], tolerance=within)
        check_kept(exact, mixed.network, EXACT * diagonal)

    @settings(deadline=None, max_examples=30)
    @given(SEEDS)
    def test_curves_drawn_exactly_do_not_move(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        drawn = draw_cage(chance)
        diagonal = float(np.linalg.norm(np.ptp(np.concatenate(drawn), axis=0)))
        result = join_polylines([*drawn, *draw_loose(chance, drawn)])
        for number, line in enumerate(drawn):
            walk = [result.network.along(step) for step in result.walks[number]]
            assert walk
            gaps = [find_nearest_on(line, point)[0] for point in np.concatenate(walk)]
            assert max(gaps) <= EXACT * diagonal
            ends = np.stack([walk[0][0], walk[-1][-1]])
            assert np.abs(ends - line[[0, -1]]).max() <= EXACT * diagonal

    @settings(deadline=None, max_examples=20)
    @given(SEEDS)
    def test_smooth_curves_with_exact_ends_meet_between_their_samples(self, seed: int) -> None:
        chance = np.random.default_rng(seed)

        def bulge(u: Points, v: Points) -> Points:
            height = 0.35 * np.exp(-(((v - 0.5) / 0.2) ** 2)) * np.sin(np.pi * u)
            return np.stack([2 * u, 1.2 * v, height], axis=1)

        drawn: list[Points] = []
        for k in range(5):
            shares = np.linspace(0, 1, int(chance.integers(45, 80)))
            drawn += [bulge(shares, np.full_like(shares, k / 4))]
            shares = np.linspace(0, 1, int(chance.integers(45, 80)))
            drawn += [bulge(np.full_like(shares, k / 4), shares)]
        network = join_polylines(drawn).network
        assert (len(network.nodes), len(network.curves)) == (25, 40)

    def test_an_exact_edge_stays_where_a_longer_stroke_runs_along_it(self) -> None:
        square = [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 1, 0]]]
        square += [[[1, 1, 0], [0, 1, 0]], [[0, 1, 0], [0, 0, 0]]]
        stroke = [[-0.5, 0.003, 0], [0.5, 0.002, 0], [1.5, 0.003, 0]]
        result = join_polylines([*square, stroke], ids=["a", "b", "c", "d", "hand"])
        curve = next(curve for curve in result.network.curves if curve.id == "a")
        assert curve.points.tolist() == [[0, 0, 0], [1, 0, 0]]
        assert [left.curve for left in result.left_out] == ["hand"]

    def test_two_edges_of_something_thin_stay_two(self) -> None:
        thin = 1e-3
        ends = np.array([[0.0, 0, 0], [1, 0, 0], [1, thin, 0], [0, thin, 0]])
        sheet = [np.stack([ends[k], ends[(k + 1) % 4]]) for k in range(4)]
        for tolerance in (None, 0.01):
            assert len(join_polylines(sheet, tolerance=tolerance).network.curves) == 4


def draw_torus(chance: np.random.Generator, off: float) -> list[Points]:
    """Rings of a torus with samples of their own, moved by up to ``off``."""
    drawn: list[Points] = []
    for along, count in ((True, 6), (False, 4)):
        for k in range(count):
            n = int(chance.integers(30, 70))
            t = 2 * np.pi * (np.arange(n + 1) / n + chance.uniform(0, 1))
            fixed = np.full_like(t, 2 * np.pi * k / count)
            a, b = (fixed, t) if along else (t, fixed)
            ring = 1.0 + 0.4 * np.cos(b)
            line = np.stack([ring * np.cos(a), ring * np.sin(a), 0.4 * np.sin(b)], axis=1)
            line += off * chance.uniform(-1, 1, 3)
            line[-1] = line[0]
            drawn.append(line)
    return drawn


def draw_ladder(chance: np.random.Generator, off: float) -> list[Points]:
    """Two rails and rungs between them whose ends miss the rails by up to ``off``; some twice."""
    x = np.linspace(0, 3, 40)
    rails = [np.stack([x, np.full_like(x, y), 0.2 * np.sin(2 * x)], axis=1) for y in (0.0, 1.0)]
    drawn = [*rails]
    for at in np.linspace(0, 3, 6):
        y = np.linspace(0, 1, int(chance.integers(4, 12)))
        rung = np.stack([np.full_like(y, at), y, np.full_like(y, 0.2 * np.sin(2 * at))], axis=1)
        rung[0, 1] += off * chance.uniform(-1, 1)
        rung[-1, 1] += off * chance.uniform(-1, 1)
        drawn.append(rung)
        if chance.random() < 0.4:
            drawn.append(rung[::-1] + off * chance.uniform(-0.3, 0.3, 3))
    return drawn


class TestJoinedByDefault:
    @settings(deadline=None, max_examples=20)
    @given(SEEDS, st.floats(0.0, 3e-3))
    def test_a_torus(self, seed: int, off: float) -> None:
        drawn = draw_torus(np.random.default_rng(seed), off)
        network = join_polylines(drawn).network
        assert (len(network.nodes), len(network.curves)) == (24, 48)

    @settings(deadline=None, max_examples=20)
    @given(SEEDS, st.sampled_from([0.0, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2]))
    def test_any_tolerance_keeps_a_torus_that_needs_none(self, seed: int, share: float) -> None:
        drawn = draw_torus(np.random.default_rng(seed), 0.0)
        network = join_polylines(drawn, tolerance=4.0 * share).network
        assert (len(network.nodes), len(network.curves)) == (24, 48)

    @settings(deadline=None, max_examples=20)
    @given(SEEDS, st.floats(1e-4, 8e-3))
    def test_a_ladder_with_gaps_overshoots_and_strokes_drawn_twice(
        self, seed: int, off: float
    ) -> None:
        result = join_polylines(draw_ladder(np.random.default_rng(seed), off))
        assert (len(result.network.nodes), len(result.network.curves)) == (12, 16)
        assert result.loose == ()
        assert all(join.gap <= 4 * off for join in result.joins)

    @pytest.mark.parametrize("shift", range(0, 64, 9))
    def test_strokes_that_overshoot_a_ring_and_cross_meet_it_wherever_it_begins(
        self, shift: int
    ) -> None:
        turns = 2 * np.pi * (np.arange(65) + shift) / 64
        ring = 0.999 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
        ring[-1] = ring[0]
        across = np.array([[2, 0, 0], [1, 0, 0], [0.995, 0, 0]], float)
        upright = np.array([[1, 0, 1], [1, 0, 0], [1, 0, -0.004]], float)
        network = join_polylines([ring, across, upright], ["ring", "across", "upright"]).network
        ends = [node for curve in network.curves for node in curve.nodes]
        assert sorted(ends.count(node) for node in set(ends)) == [1, 1, 4]
        assert sorted(curve.id for curve in network.curves) == ["across", "ring", "upright"]

    @pytest.mark.parametrize("begins", [-2.0, -1.2, 0.0, 0.7, 2.1, 90.0])
    def test_circles_drawn_a_little_too_near_meet_once_wherever_they_begin(
        self, begins: float
    ) -> None:
        rings: list[Points] = []
        for radius, height, turn in ((0.5, 0.0, 3.0), (0.3, 0.7995, np.radians(begins - 90))):
            turns = 2 * np.pi * np.arange(61) / 60 + turn
            ring = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1) * radius
            ring[-1] = ring[0]
            rings.append(ring + np.array([0.0, height, 0.0]))
        network = join_polylines(rings).network
        assert sorted((curve.id, curve.nodes) for curve in network.curves) == [
            (0, (0, 0)),
            (1, (0, 0)),
        ]

    def test_joins_and_loose_ends_are_reported_with_their_distances(self) -> None:
        rail = [[0, 0, 0], [4, 0, 0]]
        rungs = [[[x, gap, 0], [x, 1, 0]] for x, gap in ((1, 0.005), (2, 0.004), (3, 0.09))]
        top = [[0, 1, 0], [4, 1, 0]]
        result = join_polylines([rail, *rungs, top], ids=["rail", "a", "b", "c", "top"])
        assert [(set(join.curves), join.gap) for join in result.joins] == [
            ({"rail", "a"}, pytest.approx(0.005)),
            ({"rail", "b"}, pytest.approx(0.004)),
        ]
        (loose,) = result.loose
        assert (loose.curve, loose.other, loose.gap) == ("c", "rail", pytest.approx(0.09))
        assert result.notes == (
            "2 joins of curves bridge gaps of up to 0.005 (curves 'rail' and 'a' at 1, 0.0025, 0)",
            "an end of a curve stops short of another curve, by 0.09 (curve 'c' at 3, 0.09, 0 of "
            "curve 'rail'); a tolerance of 0.091 joins it",
        )
        assert join_polylines([rail, *rungs, top], tolerance=0.091).loose == ()


def shapes_of(result: JoinedCurves, names: Sequence[int]) -> dict[tuple[int, ...], list[float]]:
    """How long the pieces of every drawn curve are, by its number, whatever its sense."""
    lengths: dict[tuple[int, ...], list[float]] = {}
    for number, walk in zip(names, result.walks, strict=True):
        sizes = [result.network.curves[curve].length for curve, _ in walk]
        lengths[(number,)] = min(sizes, sizes[::-1])
    return lengths


class TestInvariance:
    @settings(deadline=None, max_examples=25)
    @given(SEEDS, st.sampled_from([1e-3, 1.0, 1e3, 25.4, 1 / 3.0]), st.integers(0, 2))
    @example(9079441, 1e-3, 1)
    def test_unit_order_and_senses(self, seed: int, unit: float, kind: int) -> None:
        chance = np.random.default_rng(seed)
        off = 10.0 ** chance.uniform(-5, -2.3)
        if kind == 2:
            drawn = [*draw_cage(chance)]
            drawn += draw_loose(chance, drawn)
        else:
            drawn = (draw_torus, draw_ladder)[kind](chance, off)
        # The same stroke twice, and once more backwards.
        drawn += [drawn[0].copy(), drawn[-1][::-1].copy()]
        mixed, order = shuffle(drawn, chance)
        one = join_polylines(drawn)
        other = join_polylines([unit * line for line in mixed])
        assert len(one.network.curves) == len(other.network.curves)
        nodes = sorted(np.round(one.network.nodes, 7).tolist())
        assert len(other.network.nodes) == len(nodes)
        gaps = KDTree(other.network.nodes / unit).query(one.network.nodes)[0]
        assert np.max(gaps) <= 1e-9
        ours, theirs = shapes_of(one, range(len(drawn))), shapes_of(other, order)
        assert len(one.joins) == len(other.joins)
        # Of strokes that are the same, their order decides which has a piece of its own.
        last = len(drawn) - 1
        same = {0: (0, last - 1), last - 2: (last - 2, last)}
        for number in range(last - 1):
            group = same.get(number, (number,))
            expected = sorted(ours[(k,)] for k in group)
            found = sorted((np.array(theirs[(k,)]) / unit).tolist() for k in group)
            for sizes, others in zip(expected, found, strict=True):
                assert others == pytest.approx(sizes, abs=1e-7)
