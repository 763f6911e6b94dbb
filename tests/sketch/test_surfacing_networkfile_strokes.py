"""Networks from drawn strokes: graphs of them and lists of them, every one beside the checkout."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from networkfile_cases import bezier, change, document, drawing, parsed, square_graph
from shared import SHARED

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.surfacing.joining.meetings import measure_deviation
from patterndb_sketch.surfacing.network import InvalidNetworkError, measure_turning
from patterndb_sketch.surfacing.networkfile import (
    parse_drawing,
    read_drawing,
    read_recorded_patches,
)

CURVES = SHARED / "data" / "curves"
GRAPHS = sorted((CURVES / "cassie" / "graph").glob("*.json"))
STROKES = sorted((CURVES / "cassie" / "strokes").glob("*.curves"))
TREBOL = CURVES / "salvi" / "trebol_network.json"


class TestStrokeGraphs:
    @pytest.mark.parametrize("path", GRAPHS, ids=lambda path: path.stem)
    def test_curves_are_the_segments(self, path: Path) -> None:
        network, graph = drawing(path).network, document(path)
        assert network.cycles == ()
        curves = {curve.id: curve for curve in network.curves}
        left_out = 0
        for segment in graph["segments"]:
            control = np.array(segment["ctrl_pts"], float)
            curve = curves.pop(segment["id"], None)
            if curve is None:
                assert np.ptp(control.reshape(-1, 3), axis=0).max() == 0
                left_out += 1
                continue
            assert curve.stroke == segment["stroke_id"]
            parts = [bezier(piece) for piece in control]
            length = sum(float(arc_length(part)[-1]) for part in parts)
            # Ends move by up to 0.001, and chords are a little shorter than arcs.
            assert curve.length == pytest.approx(length, rel=2e-3, abs=3e-3)
            # The same curve apart from that, and nowhere a corner that it does not have.
            assert measure_deviation(curve.points, np.concatenate(parts)) < 2e-3 * length + 1e-3
            if len(parts) == 1 and curve.length > 0.02:
                turning = measure_turning(curve.points)
                drawn = measure_turning(parts[0])
                assert (turning > math.radians(20)).sum() <= (drawn > math.radians(2)).sum()
        assert not curves
        assert len(drawing(path).notes) == left_out

    @pytest.mark.parametrize("path", GRAPHS, ids=lambda path: path.stem)
    def test_curves_meet_at_the_nodes_of_the_graph(self, path: Path) -> None:
        network, graph = drawing(path).network, document(path)
        place = {node["id"]: node["position"] for node in graph["nodes"]}
        curves = {curve.id: curve for curve in network.curves}
        for segment in graph["segments"]:
            if segment["id"] in curves:
                ends = curves[segment["id"]].points[[0, -1]]
                assert ends.tolist() == [place[node] for node in segment["nodes"]]
        if not drawing(path).notes:
            assert network.nodes.tolist() == [node["position"] for node in graph["nodes"]]

    @pytest.mark.parametrize("path", GRAPHS, ids=lambda path: path.stem)
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
                (curve,) = (c for c in network.curves if c.id == segment["id"])
                if curve.length > 0.05:
                    assert measure_turning(curve.points).max(initial=0) < math.radians(8)

    def test_recorded_patches(self) -> None:
        for path in GRAPHS:
            record = document(path)["patches_created"]
            patches = read_recorded_patches(path)
            assert [list(patch.strokes) for patch in patches] == [p["strokes"] for p in record]
            deleted = [patch.manually_deleted for patch in patches]
            assert deleted == [p["manually_deleted"] for p in record]
        with pytest.raises(InvalidNetworkError, match=r"trebol_network\.json: source"):
            read_recorded_patches(TREBOL)

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
        with pytest.raises(InvalidNetworkError, match="tolerance has nothing to do"):
            parse_drawing(json.dumps(square_graph()).encode(), tolerance=0.1)


class TestStrokeLists:
    @pytest.mark.parametrize("path", STROKES, ids=lambda path: path.stem)
    def test_strokes_are_all_there(self, path: Path) -> None:
        lines = path.read_text().splitlines()
        points = [list(map(float, line.split())) for line in lines if line[:1] != "v"]
        drawn = read_drawing(path)
        assert len(drawn.stages) == len(lines) - len(points)
        length = sum(curve.length for curve in drawn.network.curves)
        left_out = 0.0
        starts = [i for i, line in enumerate(lines) if line[:1] == "v"] + [len(lines)]
        for first, last in pairwise(starts):
            part = np.array([list(map(float, line.split())) for line in lines[first + 1 : last]])
            left_out += float(arc_length(part)[-1])
        assert length == pytest.approx(left_out, rel=1e-4)

    @pytest.mark.parametrize("path", STROKES, ids=lambda path: path.stem)
    def test_drawn_by_hand_they_meet_within_a_tolerance(self, path: Path) -> None:
        exact, drawn = read_drawing(path), read_drawing(path, tolerance=0.01)
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
