"""Networks from curves as drawn: the nodes and curves of a known network are found again."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.spatial import KDTree

from patterndb._native.surfacing.curvenetwork.meetings import (
    find_nearest_of_edges,
    measure_deviation,
)
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.curvenetwork import meetings
from patterndb_sketch.curvenetwork.joining import (
    JoinedCurves,
    join_polylines,
    network_of_polylines,
)
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import measure_turning

SEEDS = st.integers(0, 2**32 - 1)

#: Edges of a drawn curve between two nodes.
EDGES = 12


def curved(first: Points, last: Points, bulge: NDArray[np.float64]) -> Points:
    """A curve from first to last that bulges out."""
    share = np.linspace(0, 1, EDGES + 1)[:, None]
    points = (1 - share) * first + share * last + np.sin(np.pi * share) * bulge
    points[0], points[-1] = first, last
    return points


def known_grid(
    chance: np.random.Generator, rows: int, columns: int
) -> tuple[list[Points], dict[tuple[int, int], Points], list[tuple[Points, Points]]]:
    """A curved grid drawn in strokes that run through some of its nodes.

    Returns the strokes, the places of the nodes, and the ends of the pieces between them.
    """
    at = {
        (i, j): np.array([i, j, 0.0]) + chance.uniform(-0.15, 0.15, 3)
        for i in range(rows)
        for j in range(columns)
    }
    strokes: list[list[tuple[int, int]]] = []
    lines = [[(i, j) for j in range(columns)] for i in range(rows)]
    lines += [[(i, j) for i in range(rows)] for j in range(columns)]
    for line in lines:
        stroke = [line[0]]
        for node in line[1:]:
            if chance.random() < 0.15:
                strokes.append(stroke)
                stroke = [node]
                continue
            stroke.append(node)
            if chance.random() < 0.3:
                strokes.append(stroke)
                stroke = [node]
        strokes.append(stroke)
    strokes = [stroke for stroke in strokes if len(stroke) > 1]
    met = [node for stroke in strokes for node in stroke]
    ends = {node for stroke in strokes for node in (stroke[0], stroke[-1])}
    nodes = {node: at[node] for node in met if node in ends or met.count(node) > 1}
    drawn: list[Points] = []
    pieces: list[tuple[Points, Points]] = []
    for stroke in strokes:
        parts = [curved(at[a], at[b], chance.uniform(-0.07, 0.07, 3)) for a, b in pairwise(stroke)]
        drawn.append(np.concatenate([parts[0], *(part[1:] for part in parts[1:])]))
        cuts = [i for i, node in enumerate(stroke) if node in nodes]
        pieces += [(at[stroke[a]], at[stroke[b]]) for a, b in pairwise(cuts)]
    return drawn, nodes, pieces


def shuffled(drawn: list[Points], chance: np.random.Generator) -> list[Points]:
    order = chance.permutation(len(drawn))
    return [drawn[i][:: chance.choice([-1, 1])] for i in order]


def check_found(
    network: CurveNetwork,
    nodes: dict[tuple[int, int], Points],
    pieces: list[tuple[Points, Points]],
    reach: float,
) -> None:
    """The network has these nodes and pieces, and no others."""
    places = np.array(list(nodes.values()))
    assert len(network.nodes) == len(places)
    gaps, nearest = KDTree(places).query(network.nodes)
    number = np.asarray(nearest, np.int64)
    assert sorted(number.tolist()) == list(range(len(places)))
    assert np.max(gaps) <= reach
    found = sorted(tuple(sorted(int(number[n]) for n in c.nodes)) for c in network.curves)
    tree = KDTree(places)
    ends = np.asarray(tree.query(np.array(pieces))[1], np.int64)
    wanted = sorted(tuple(sorted(pair)) for pair in ends.tolist())
    assert found == wanted


def check_walks(drawn: list[Points], result: JoinedCurves, reach: float) -> None:
    """Every drawn curve is its walk, and every curve of the network is in one."""
    network = result.network
    for points, walk in zip(drawn, result.walks, strict=True):
        assert all(network.ends(a)[1] == network.ends(b)[0] for a, b in pairwise(walk))
        walked = np.concatenate([network.along(step) for step in walk])
        assert (
            measure_deviation(np.ascontiguousarray(walked), np.ascontiguousarray(points)) <= reach
        )
    covered = {curve for walk in result.walks for curve, _ in walk}
    assert covered == set(range(len(network.curves)))


class TestKnownNetworks:
    @settings(deadline=None, max_examples=40)
    @given(SEEDS)
    def test_a_grid_drawn_exactly(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        drawn, nodes, pieces = known_grid(chance, *chance.integers(2, 6, 2))
        if not drawn:
            return
        drawn = shuffled(drawn, chance)
        result = join_polylines(drawn)
        check_found(result.network, nodes, pieces, 1e-9)
        check_walks(drawn, result, 1e-9)
        assert result.notes == ()

    @settings(deadline=None, max_examples=40)
    @given(SEEDS)
    @example(67312)
    def test_a_grid_drawn_by_hand(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        drawn, nodes, pieces = known_grid(chance, *chance.integers(2, 5, 2))
        if not drawn:
            return
        tolerance = 0.04
        # Strokes miss each other, end early, or go on too far.
        moved: list[Points] = []
        for points in shuffled(drawn, chance):
            points = points + chance.uniform(-0.2, 0.2, 3) * tolerance
            ends = chance.uniform(-0.3, 0.3, 2) * tolerance
            for end, beside, by in ((0, 1, ends[0]), (-1, -2, ends[1])):
                step = points[end] - points[beside]
                points[end] += by * step / np.linalg.norm(step)
            moved.append(points)
        result = join_polylines(moved, tolerance=tolerance)
        check_found(result.network, nodes, pieces, tolerance)
        check_walks(moved, result, tolerance)
        assert all(left.reason == "overshoot" for left in result.left_out)
        assert all(left.length <= tolerance for left in result.left_out)

    @settings(deadline=None, max_examples=40)
    @given(SEEDS)
    def test_a_graph_in_space(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        n = int(chance.integers(2, 12))
        places = chance.uniform(0, 1, (n, 3))
        pairs = [(a, b) for a in range(n) for b in range(a) if chance.random() < 0.4]
        # Straight, as smooth curves may meet between their samples.
        drawn = [curved(places[a], places[b], np.zeros(3)) for a, b in pairs]
        if not drawn:
            return
        drawn = shuffled(drawn, chance)
        network = join_polylines(drawn, tolerance=1e-6).network
        assert len(network.curves) == len(drawn)
        for points, curve in zip(drawn, network.curves, strict=True):
            assert np.array_equal(points, curve.points)
        assert len(network.nodes) == len({node for pair in pairs for node in pair})

    @settings(deadline=None, max_examples=25)
    @given(SEEDS, st.sampled_from([None, 0.05]))
    def test_order_and_senses_change_nothing(self, seed: int, tolerance: float | None) -> None:
        chance = np.random.default_rng(seed)
        drawn = [chance.uniform(0, 1, (chance.integers(2, 8), 3)) for _ in range(6)]
        drawn = [np.c_[points[:, :2], 0.03 * points[:, 2]] for points in drawn]
        results = [
            join_polylines(lines, tolerance=tolerance) for lines in (drawn, shuffled(drawn, chance))
        ]
        one, other = (result.network for result in results)
        assert sorted(map(tuple, one.nodes)) == sorted(map(tuple, other.nodes))

        def shapes(network: CurveNetwork) -> list[bytes]:
            return sorted(
                min(c.points.tobytes(), np.ascontiguousarray(c.points[::-1]).tobytes())
                for c in network.curves
            )

        assert shapes(one) == shapes(other)
        told = [sorted((x.reason, x.length) for x in result.left_out) for result in results]
        assert told[0] == told[1]


def circle(n: int = 64, radius: float = 1.0) -> Points:
    turn = 2 * np.pi * np.arange(n + 1) / n
    points = radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    points[-1] = points[0]
    return points


class TestSingleCases:
    def test_an_end_that_meets_a_curve_on_its_way_leaves_that_where_it_is(self) -> None:
        rail = [[0, 0, 0], [2, 0, 0]]
        result = join_polylines([rail, [[1, 0.01, 0], [1, 1, 0]]], tolerance=0.02)
        network = result.network
        assert sorted(network.nodes.tolist()) == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 0, 0]]
        assert [curve.id for curve in network.curves] == [0, 0, 1]
        assert result.walks == (((0, False), (1, False)), ((2, False),))
        (join,) = result.joins
        assert set(join.curves) == {0, 1} and join.gap == pytest.approx(0.01)
        assert result.notes == (
            "a join of curves bridges a gap of 0.01 (curves 0 and 1 at 1, 0.005, 0)",
        )

    def test_an_overshoot_is_left_out_and_told(self) -> None:
        result = join_polylines(
            [[[0, 0, 0], [2, 0, 0]], [[1, -0.01, 0], [1, 1, 0]]], tolerance=0.02
        )
        assert len(result.network.nodes) == 4 and len(result.network.curves) == 3
        (left,) = result.left_out
        assert left.reason == "overshoot" and left.curve == 1
        assert left.length == pytest.approx(0.01)
        assert "curve 1 goes on beyond a node" in result.notes[0]

    def test_longer_than_the_tolerance_it_is_a_curve(self) -> None:
        network = network_of_polylines(
            [[[0, 0, 0], [2, 0, 0]], [[1, -0.03, 0], [1, 1, 0]]], tolerance=0.02
        )
        assert len(network.curves) == 4

    def test_what_a_curve_moves_by_is_spread_along_it(self) -> None:
        bow = circle()[:17]
        network = network_of_polylines(
            [bow, [[1.05, 0, 0], [2, 0, 0]], [[0, 1.05, 0], [0, 2, 0]]], tolerance=0.1
        )
        moved = network.curves[0].points
        assert moved[0].tolist() == [1.025, 0, 0]
        assert np.abs(measure_turning(moved) - measure_turning(bow)).max() < math.radians(0.5)

    def test_a_closed_curve_alone_has_one_node(self) -> None:
        (curve,) = network_of_polylines([circle()]).curves
        assert curve.closed and len(curve.points) == 65

    def test_a_closed_curve_is_cut_where_others_meet_it_alone(self) -> None:
        result = join_polylines([circle(), [[0, -2, 0], [0, 2, 0]]])
        network = result.network
        assert len(network.nodes) == 4
        assert [curve.id for curve in network.curves] == [0, 0, 1, 1, 1]
        halves = [curve for curve in network.curves if curve.id == 0]
        assert [len(half.points) for half in halves] == [33, 33]
        assert halves[0].nodes == halves[1].nodes[::-1]

    def test_a_closed_curve_that_another_meets_where_it_begins(self) -> None:
        network = network_of_polylines([circle(), [[1, 0, 0], [3, 0, 0]]])
        assert len(network.nodes) == 2
        assert [curve.closed for curve in network.curves] == [True, False]

    def test_a_curve_that_crosses_itself(self) -> None:
        turn = np.linspace(0, 2 * np.pi, 101) + 0.5
        eight = np.stack([np.sin(2 * turn), np.sin(turn), 0 * turn], axis=1)
        eight[-1] = eight[0]
        network = network_of_polylines([eight], ids=["8"])
        assert [curve.id for curve in network.curves] == ["8", "8"]
        assert all(curve.closed for curve in network.curves)
        assert network.nodes == pytest.approx(np.zeros((1, 3)), abs=1e-3)

    def test_the_same_curve_twice_is_told_and_there_once(self) -> None:
        bow = circle()[:20]
        result = join_polylines([bow, bow[::-1]], ids=["a", "b"])
        assert [curve.id for curve in result.network.curves] == ["a"]
        assert result.walks == (((0, False),), ((0, True),))
        (left,) = result.left_out
        assert (left.curve, left.reason) == ("b", "twice")

    @pytest.mark.parametrize("n", [2, 200])
    def test_a_common_stretch_is_one_curve_between_two_nodes(self, n: int) -> None:
        first = sample_polyline(np.array([[0.0, 0, 0], [10, 0, 0]]), n - 1)
        second = sample_polyline(np.array([[3.0, 0.01, 0], [15, 0.01, 0]]), n - 1)
        result = join_polylines([first, second], tolerance=0.02)
        lengths = sorted(curve.length for curve in result.network.curves)
        assert lengths == pytest.approx([3, 5, 7], abs=0.02)
        assert len(result.network.nodes) == 4
        (left,) = result.left_out
        assert left.reason == "twice" and left.length == pytest.approx(7, abs=0.02)

    def test_curves_that_touch_have_one_node(self) -> None:
        line = sample_polyline(np.array([[-2.0, 1.0, 0.0], [2.0, 1.0, 0.0]]), 80)
        network = network_of_polylines([circle(200), line], tolerance=0.002)
        assert len(network.nodes) == 3
        assert [curve.id for curve in network.curves] == [0, 1, 1]

    def test_three_curves_through_one_place(self) -> None:
        star = [[[math.cos(a), math.sin(a), 0], [-math.cos(a), -math.sin(a), 0]] for a in range(3)]
        network = network_of_polylines(star)
        assert len(network.nodes) == 7 and len(network.curves) == 6

    def test_nodes_that_gather_much_are_told(self) -> None:
        rungs = [[[0.015 * i, 0, 0], [0.015 * i, 1, 0]] for i in range(12)]
        result = join_polylines([[[-1, 0, 0], [1, 0, 0]], *rungs], tolerance=0.02)
        assert any("gathers" in note for note in result.notes)

    @pytest.mark.parametrize("scale", [1e-90, 1e90, 2.0**-40])
    def test_the_unit_does_not_matter(self, scale: float) -> None:
        chance = np.random.default_rng(5)
        drawn, _, _ = known_grid(chance, 4, 4)
        one = network_of_polylines(drawn)
        other = network_of_polylines([scale * points for points in drawn])
        assert [c.nodes for c in one.curves] == [c.nodes for c in other.curves]
        assert other.nodes / scale == pytest.approx(one.nodes, rel=1e-9)

    def test_no_curves_are_a_network_without_curves(self) -> None:
        assert network_of_polylines([]).curves == ()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"polylines": [[[0, 0], [1, 0]], [[1, 1], [1, 1]]]}, "curve 1 has no length"),
        ({"polylines": [[[0, 0], [1, 0]]], "ids": ["a", "b"]}, "1 polylines, 2 ids"),
        ({"polylines": [[[0, 0], [1, 0]]] * 2, "ids": ["a", "a"]}, "'a' is there twice"),
        ({"polylines": [[[0, 0], [1, 0]]], "tolerance": -1}, "tolerance is -1"),
        ({"polylines": [[[0, 0], [1, 0]]], "tolerance": math.nan}, "tolerance is nan"),
        ({"polylines": [[[0, 0], [1, 0]]], "tolerance": 9}, "nothing is left"),
        ({"polylines": [[[0, 0], [1e200, 0]]]}, "beyond 1e.100"),
        ({"polylines": [[[0, 0], [math.inf, 0]]]}, "not finite"),
    ],
)
def test_refusals(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidNetworkError, match=message):
        join_polylines(**arguments)  # pyright: ignore[reportArgumentType]


def test_curves_that_touch_too_much_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meetings, "MAX_CONTACTS", 20_000)
    scribble = np.random.default_rng(1).uniform(0, 1, (300, 3))
    with pytest.raises(InvalidNetworkError, match="20,000 pairs of edges touch; give a smaller"):
        join_polylines([scribble], tolerance=2.0)


@settings(deadline=None, max_examples=100)
@given(SEEDS)
def test_nearest_places_of_edges_are_those_of_a_solver(seed: int) -> None:
    chance = np.random.default_rng(seed)
    points = chance.integers(-3, 4, (4, 3)).astype(float)
    s, u, gap = find_nearest_of_edges(points, 0, 2, 0.0)
    along, beside = points[1] - points[0], points[3] - points[2]
    there = np.linalg.norm(points[0] + s * along - points[2] - u * beside)
    solved = lsq_linear(
        np.stack([along, -beside], axis=1), points[2] - points[0], (0, 1), method="bvls"
    )
    assert gap == pytest.approx(there, abs=1e-12)
    assert gap == pytest.approx(math.sqrt(2 * solved.cost), abs=1e-6)
