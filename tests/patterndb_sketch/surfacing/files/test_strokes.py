"""Networks from drawn strokes: graphs of them and lists of them."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import KDTree

from patterndb._native.surfacing.curvenetwork.meetings import measure_deviation
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import measure_turning
from patterndb_sketch.surfacing.networkfile import (
    parse_drawing,
    read_drawing,
    read_recorded_patches,
)
from tests.support.surfacing.networkfiles import (
    GRAPHS,
    STROKES,
    bezier,
    change,
    document,
    drawing,
    parsed,
    square_graph,
)
from tests.support.surfacing.sketches import FOLDER

#: Those of the tests, and of the many that people drew every fourth.
SOME_GRAPHS, SOME_STROKES = ([*some[:3], *some[3::4]] for some in (GRAPHS, STROKES))

#: By how much joining may move curves, as a share of the diagonal.
REACH = 0.04


def sample_network(network: CurveNetwork, spacing: float) -> Points:
    """Points on all curves of a network, about so far apart."""
    return np.concatenate(
        [sample_polyline(c.points, 1 + int(4 * c.length / spacing)) for c in network.curves]
    )


class TestStrokeGraphs:
    @pytest.mark.parametrize("path", SOME_GRAPHS, ids=lambda path: path.stem)
    def test_curves_are_the_segments(self, path: Path) -> None:
        drawn, graph = drawing(path), document(path)
        assert drawn.network.cycles == ()
        whole = np.concatenate([curve.points for curve in drawn.network.curves])
        reach = REACH * float(np.linalg.norm(np.ptp(whole, axis=0)))
        stroke_of = {segment["id"]: segment["stroke_id"] for segment in graph["segments"]}
        assert all(curve.stroke == stroke_of[curve.id] for curve in drawn.network.curves)
        tree = KDTree(sample_network(drawn.network, reach))
        segments: dict[int, Points] = {}
        for segment in graph["segments"]:
            control = np.array(segment["ctrl_pts"], float)
            if np.ptp(control.reshape(-1, 3), axis=0).max() == 0:
                assert any(f"segment {segment['id']} has no length" in n for n in drawn.notes)
                continue
            points = np.concatenate([bezier(piece) for piece in control])
            segments[segment["id"]] = points
            # Every segment is there, but for overshoots, and curves do not leave their segments.
            assert np.quantile(tree.query(points)[0], 0.9) <= reach
        for curve in drawn.network.curves:
            assert isinstance(curve.id, int)
            assert measure_deviation(curve.points, segments[curve.id]) <= reach

    @pytest.mark.parametrize("path", SOME_GRAPHS, ids=lambda path: path.stem)
    def test_curves_meet_where_segments_do(self, path: Path) -> None:
        network, graph = drawing(path).network, document(path)
        reach = REACH * np.linalg.norm(np.ptp(network.nodes, axis=0))
        ends = [np.array(s["ctrl_pts"], float).reshape(-1, 3)[[0, -1]] for s in graph["segments"]]
        gaps = KDTree(network.nodes).query(np.concatenate(ends))[0]
        # Some ends lie on pieces that are there twice, or are overshoots.
        assert (gaps <= reach).mean() >= 0.9

    @pytest.mark.parametrize("path", SOME_GRAPHS, ids=lambda path: path.stem)
    def test_stages_are_the_strokes_in_their_order(self, path: Path) -> None:
        drawn = drawing(path)
        curves = drawn.network.curves
        strokes = [{curves[curve].stroke for curve in stage} for stage in drawn.stages]
        assert all(len(stroke) <= 1 for stroke in strokes)
        order = [stroke.pop() for stroke in strokes if stroke]
        assert order == sorted(order, key=int) and len(order) == len(set(order))
        assert sorted(curve for stage in drawn.stages for curve in stage) == list(
            range(len(curves))
        )
        assert drawn.after(len(drawn.stages)).curves == curves
        assert drawn.after(0).curves == ()

    def test_a_smooth_segment_turns_little_from_step_to_step(self) -> None:
        for path in GRAPHS[:12]:
            network = drawing(path).network
            for segment in document(path)["segments"]:
                control = np.array(segment["ctrl_pts"], float)
                if control.shape != (1, 4, 3):
                    continue
                # No cusp: a control polygon that never turns back.
                steps = np.diff(control[0], axis=0)
                if (steps @ (control[0, -1] - control[0, 0])).min() <= 0:
                    continue
                for curve in network.curves:
                    # Where a piece moves to its nodes, short ones turn more.
                    if curve.id == segment["id"] and curve.length > 0.3:
                        assert measure_turning(curve.points).max(initial=0) < math.radians(10)

    def test_recorded_patches(self) -> None:
        for path in GRAPHS:
            record = document(path)["patches_created"]
            patches = read_recorded_patches(path)
            assert [list(patch.strokes) for patch in patches] == [p["strokes"] for p in record]
            deleted = [patch.manually_deleted for patch in patches]
            assert deleted == [p["manually_deleted"] for p in record]
        with pytest.raises(InvalidNetworkError, match=r"ball\.json: (curves|nodes)"):
            read_recorded_patches(FOLDER / "ball.json")

    @pytest.mark.parametrize(
        ("place", "value", "message"),
        [
            (["segments", 0, "nodes", 1], 99, r"segments\[0\]\.nodes\[1\]: there is no node 99"),
            (["segments", 0, "nodes"], [0], r"segments\[0\]\.nodes: a list is not a pair"),
            (["segments", 0, "stroke_id"], 9, r"segments\[0\]\.stroke_id: there is no stroke 9"),
            (["segments", 1, "id"], 0, r"segments\[1\]\.id: the id 0 is there twice"),
            (["segments", 0, "ctrl_pts", 0], [[0, 0, 0]], "a line of 2 points|one line of 2"),
            (["segments", 1, "ctrl_pts", 0, 0, 2], "x", r"ctrl_pts\[0\]\[0\]\[2\]: \"x\""),
            (["segments", 1, "ctrl_pts", 0, 0, 2], 1e200, r"segments\[1\]\.ctrl_pts: .*beyond"),
            (["nodes", 0, "position"], [9, 9, 9], r"segments\[0\]: the segment ends 15\.6 away"),
            (["nodes", 0, "colour"], 1, r"nodes\[0\]\.colour: there is no such entry"),
            (["strokes"], 1, "strokes: 1 is not a list"),
        ],
    )
    def test_refusals(self, place: list[Any], value: object, message: str) -> None:
        graph = json.loads(json.dumps(square_graph()))
        change(graph, place, value)
        with pytest.raises(InvalidNetworkError, match=message):
            parsed(graph)

    def test_a_tolerance_joins_segments_that_the_graph_leaves_apart(self) -> None:
        graph = json.loads(json.dumps(square_graph()))
        # A node of its own, a tenth of the square away from the one that it was at.
        last = graph["segments"][-1]
        x, y, _ = last["ctrl_pts"][-1][-1]
        last["ctrl_pts"][-1][-1] = [x, y, 0.1]
        last["nodes"][-1] = 99
        graph["nodes"].append({"id": 99, "position": [x, y, 0.1]})
        data = json.dumps(graph).encode()
        apart, joined = parse_drawing(data), parse_drawing(data, tolerance=0.15)
        assert len(joined.network.nodes) == len(apart.network.nodes) - 1
        assert [join.gap for join in joined.joins] == pytest.approx([0.1])


class TestStrokeLists:
    @pytest.mark.parametrize("path", SOME_STROKES, ids=lambda path: path.stem)
    def test_strokes_are_all_there(self, path: Path) -> None:
        lines = path.read_text().splitlines()
        points = [list(map(float, line.split())) for line in lines if line[:1] != "v"]
        drawn = read_drawing(path, tolerance=0.0)
        assert len(drawn.stages) == len(lines) - len(points)
        length = sum(curve.length for curve in drawn.network.curves)
        left_out = 0.0
        starts = [i for i, line in enumerate(lines) if line[:1] == "v"] + [len(lines)]
        for first, last in pairwise(starts):
            part = np.array([list(map(float, line.split())) for line in lines[first + 1 : last]])
            left_out += float(arc_length(part)[-1])
        assert length == pytest.approx(left_out, rel=5e-4)

    @pytest.mark.parametrize("path", SOME_STROKES, ids=lambda path: path.stem)
    def test_drawn_by_hand_they_meet_within_a_tolerance(self, path: Path) -> None:
        exact, drawn = read_drawing(path, tolerance=0.0), read_drawing(path)
        ends = [np.concatenate([c.nodes for c in one.network.curves]) for one in (exact, drawn)]
        meeting = [int((np.bincount(of) >= 3).sum()) for of in ends]
        assert meeting[1] > meeting[0]
        assert {curve for stage in drawn.stages for curve in stage} == set(
            range(len(drawn.network.curves))
        )
        # What is not there is told.
        whole = sum(curve.length for curve in exact.network.curves)
        kept = sum(curve.length for curve in drawn.network.curves)
        if kept < 0.98 * whole:
            assert drawn.notes

    def test_refusals(self) -> None:
        for text, message in [
            ("v 2\n0 0 0\n", "line 1: the number of points is 2, but only 3 words follow"),
            ("v 2\n0 0 0\n1 0 x\n", "line 3: 'x' is not a coordinate of stroke 0"),
            ("v 2\n0 0 0\n1 0 0\nw 2\n", 'line 4: a polyline begins with "v"'),
            ("v 2\n0 0 0\n0 0 0\n", "stroke 0 has no length"),
            ("v 1\n0 0 0\n", "there must be 2 at least"),
        ]:
            with pytest.raises(InvalidNetworkError, match=message):
                parse_drawing(text.encode())
