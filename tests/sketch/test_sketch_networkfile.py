"""Networks from files: every network beside the checkout, and what is refused."""

from __future__ import annotations

import copy
import json
import math
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from shared import SHARED

from query.polyline import Points, arc_length
from sketch.surfacing.drawing import Drawing
from sketch.surfacing.errors import InvalidNetworkError
from sketch.surfacing.files.networkjson import network_document
from sketch.surfacing.joining.junctions import network_of_polylines
from sketch.surfacing.joining.nearest import farthest
from sketch.surfacing.naming import Named, named_cycle
from sketch.surfacing.network import Cycle, Network, turning_angles
from sketch.surfacing.networkfile import (
    parse_drawing,
    read_drawing,
    read_network,
    read_recorded_patches,
    write_network,
)

CURVES = SHARED / "data" / "curves"
GRAPHS = sorted((CURVES / "cassie" / "graph").glob("*.json"))
STROKES = sorted((CURVES / "cassie" / "strokes").glob("*.curves"))
LOOPS = sorted((CURVES / "salvi").glob("*.lop"))
TREBOL = CURVES / "salvi" / "trebol_network.json"
TREBOL_PATCHES = CURVES / "salvi" / "trebol.sdm"

Document = dict[str, Any]


@cache
def drawing(path: Path) -> Drawing:
    return read_drawing(path)


@cache
def document(path: Path) -> Document:
    return json.loads(path.read_bytes())


def bezier(control: Points, n: int = 200) -> Points:
    """Points of a Bezier, by the definition."""
    t = np.linspace(0, 1, n + 1)[:, None]
    points = np.repeat(control[None], n + 1, axis=0)
    while points.shape[1] > 1:
        points = (1 - t[:, None]) * points[:, :-1] + t[:, None] * points[:, 1:]
    return np.ascontiguousarray(points[:, 0])


def parsed(content: object) -> Drawing:
    return parse_drawing(json.dumps(content).encode())


def test_the_data_is_there() -> None:
    assert len(GRAPHS) == 44 and len(STROKES) == 20 and len(LOOPS) == 4


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
            assert farthest(curve.points, np.concatenate(parts)) < 2e-3 * length + 1e-3
            if len(parts) == 1 and curve.length > 0.02:
                turning = turning_angles(curve.points)
                drawn = turning_angles(parts[0])
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
                    assert turning_angles(curve.points).max(initial=0) < math.radians(8)

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


def square_graph() -> Document:
    places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    return {
        "strokes": [{"id": 5, "segments": [0, 1]}, {"id": 2, "segments": [2, 3]}],
        "segments": [
            {
                "id": i,
                "stroke_id": 5 if i < 2 else 2,
                "ctrl_pts": [[places[i], places[i], places[(i + 1) % 4], places[(i + 1) % 4]]]
                if i
                else [[places[0], places[1]]],
                "nodes": [i, (i + 1) % 4],
            }
            for i in range(4)
        ],
        "nodes": [{"id": i, "position": p, "neighbor_edges": []} for i, p in enumerate(places)],
        "patches_created": [],
    }


def change(content: Document, place: list[Any], value: object) -> None:
    at: Any = content
    for key in place[:-1]:
        at = at[key]
    at[place[-1]] = value


class TestTrebol:
    def test_it_comes_out_exact(self) -> None:
        network, given = read_network(TREBOL), document(TREBOL)
        assert len(network.curves) == 36 and len(network.nodes) == 18 and len(network.cycles) == 20
        assert network.nodes.tolist() == given["nodes"]
        for curve, one in zip(network.curves, given["curves"], strict=True):
            assert (curve.id, list(curve.nodes)) == (one["id"], one["nodes"])
            assert curve.points.tolist() == one["points"]
        for cycle, one in zip(network.cycles, given["cycles"], strict=True):
            assert cycle.steps == tuple((step["curve"], step["reversed"]) for step in one)

    def test_its_polylines_alone_meet_at_the_same_nodes(self) -> None:
        given = document(TREBOL)
        drawn = {
            "curves": [{"id": c["id"], "points": c["points"]} for c in given["curves"]],
            "cycles": [[step["curve"] for step in cycle] for cycle in given["cycles"]],
        }
        network = parsed(drawn).network
        assert len(network.curves) == 36 and len(network.nodes) == 18
        whole = read_network(TREBOL)
        for cycle, exact in zip(network.cycles, whole.cycles, strict=True):
            assert cycle.key == exact.key

    def test_the_patches_it_was_made_from_give_the_same(self) -> None:
        network, exact = read_network(TREBOL_PATCHES), read_network(TREBOL)
        assert network.nodes.tolist() == exact.nodes.tolist()
        assert [c.nodes for c in network.curves] == [c.nodes for c in exact.curves]
        assert [c.key for c in network.cycles] == [c.key for c in exact.cycles]
        for curve, one in zip(network.curves, document(TREBOL)["curves"], strict=True):
            line = bezier(np.array(one["bezier"]))
            assert farthest(curve.points, line) < 1e-4 * curve.length
            assert farthest(line, curve.points) < 1e-3 * curve.length
            assert turning_angles(curve.points).max(initial=0) <= math.radians(5)


class TestLoops:
    @pytest.mark.parametrize("path", LOOPS, ids=lambda path: path.stem)
    def test_the_loop_is_the_cycle(self, path: Path) -> None:
        network = read_network(path)
        (cycle,) = network.cycles
        assert cycle.curves == tuple(range(len(network.curves)))
        assert len(network.nodes) == len(network.curves)
        numbers = path.read_text().split()
        assert len(network.curves) == int(numbers[0])
        assert len(network.walk(cycle)) == len(network.curves)
        at = 1
        for curve in network.curves:
            degree, n_knots = int(numbers[at]), int(numbers[at + 1])
            knots = np.array(numbers[at + 2 : at + 2 + n_knots], float)
            at += 2 + n_knots
            n = int(numbers[at])
            control = np.array(numbers[at + 1 : at + 1 + 3 * n], float).reshape(-1, 3)
            at += 1 + 3 * n
            spline = BSpline(knots, control, degree)
            line = np.ascontiguousarray(spline(np.linspace(knots[degree], knots[n], 2000)))
            assert farthest(line, curve.points) < 1.5e-3 * curve.length
            assert farthest(curve.points, line) < 1e-4 * curve.length
            assert turning_angles(curve.points).max() <= math.radians(5)

    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            ("3\n3\n", "4\n3\n", r"line \d+: .* is not|ends where"),
            ("3\n3\n10 0", "3\n3\n10 x", "line 3: 'x' is not a knot"),
            ("0.266543", "0.9", "line 4: .*descend"),
            ("3\n3\n10", "3\n99\n10", "line 2: the degree is 99|only"),
            ("53.9182 -100 8.47485 56", "99 -100 8.47485 56", "curve 2 ends .* away from"),
            ("53.9182 -100 8.47485 56", "nan -100 8.47485 56", "'nan' is not a finite number"),
            ("10 0 0 0 0 0.26", "999999 0 0 0 0 0.26", "only .* words follow"),
        ],
    )
    def test_refusals(self, old: str, new: str, message: str) -> None:
        text = (CURVES / "salvi" / "pocket3sided.lop").read_text()
        assert text.count(old) == 1
        with pytest.raises(InvalidNetworkError, match=message):
            parse_drawing(text.replace(old, new).encode())


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


#: A square, and a stroke that crosses two of its sides.
CROSSED: Document = {
    "curves": [
        {"points": [[0, 0], [2, 0]]},
        {"points": [[2, 0], [2, 2]]},
        {"points": [[2, 2], [0, 2]]},
        {"points": [[0, 2], [0, 0]]},
        {"id": "across", "points": [[1, -1], [1, 3]], "stroke": 7},
    ],
    "cycles": [[0, "across", 2, 3], [2, 1, {"curve": 0, "reversed": True}, "across"]],
    "stages": [[0, 1], [2, 3], ["across"]],
}


class TestPlainJson:
    def test_cycles_take_the_parts_between_their_neighbours(self) -> None:
        # The second cycle names curve 0 against the walk that the others make.
        content = copy.deepcopy(CROSSED)
        content["cycles"][1][2] = 0
        drawn = parsed(content)
        network = drawn.network
        assert len(network.nodes) == 8 and len(network.curves) == 9
        areas = [network.polyline(cycle) for cycle in network.cycles]
        assert all(arc_length(np.r_[a, a[:1]])[-1] == pytest.approx(6) for a in areas)
        assert [len(drawn.after(i).curves) for i in range(4)] == [0, 3, 6, 9]
        assert len(drawn.after(2).cycles) == 0 and len(drawn.after(3).cycles) == 2
        assert {c.stroke for c in network.curves if c.id == "across"} == {7}

    def test_a_closed_curve_is_walked_the_shorter_way_round(self) -> None:
        turn = np.linspace(0, 2 * np.pi, 41)
        ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        ring[-1] = ring[0]
        curves = [{"id": "ring", "points": ring.tolist()}]
        curves.append({"id": "cut", "points": [[-2, 0.5], [2, 0.5]]})
        network = parsed({"curves": curves, "cycles": [["ring", "cut"], ["ring"]]}).network
        assert len(network.cycles[0].steps) == 2
        assert len(network.cycles[1].steps) == 2
        parts = [network.curves[curve] for curve in network.cycles[0].curves]
        assert sum(part.length for part in parts) == pytest.approx(
            2 * math.pi / 3 + math.sqrt(3), rel=0.01
        )

    @pytest.mark.parametrize(
        ("place", "value", "message"),
        [
            (["colour"], "red", "colour: there is no such entry; entries are curves, cycles"),
            (["curves", 0, "name"], 1, r"curves\[0\]\.name: there is no such entry"),
            (["curves", 0], {"id": 0}, r'curves\[0\]: "points" is missing'),
            (["curves", 0, "points"], [[0, 0], [0, 0]], r"curves\[0\]: curve 0 has no length"),
            (["curves", 0, "points", 1, 0], "x", r'curves\[0\]\.points\[1\]\[0\]: "x" is not'),
            (["curves", 0, "id"], "across", "'across' is there twice"),
            (["curves", 0, "id"], True, r"curves\[0\]\.id: true is not a name"),
            (["curves", 0, "nodes"], [0, 1], r'curves\[0\]\.nodes: there are no "nodes"'),
            (["cycles"], [[0, 9]], r"cycles\[0\]: there is no curve 9; curves are 0, 1"),
            (["cycles"], [[0, 2]], r"cycles\[0\]: curves 2 and 0 do not meet"),
            (["cycles"], [[]], r"cycles\[0\]: a cycle needs at least one curve"),
            (["cycles"], [[0, 1]], r"cycles\[0\]: .*do not close"),
            (["cycles"], [[{"curve": 0, "part": 5}]], "has 2 parts, and no part 5"),
            (["cycles"], [[{"part": 5}]], r'cycles\[0\]\[0\]: "curve" is missing'),
            (["stages"], [[0], [9]], r"stages\[1\]\[0\]: there is no curve 9"),
            (["tolerance"], -1, "the tolerance is -1"),
            (["tolerance"], "1", 'tolerance: "1" is not a number'),
            (["nodes"], [[0, 0, 0]], r'curves\[0\]: "nodes" is missing'),
        ],
    )
    def test_refusals(self, place: list[Any], value: object, message: str, tmp_path: Path) -> None:
        content = copy.deepcopy(CROSSED)
        change(content, place, value)
        path = tmp_path / "network.json"
        path.write_text(json.dumps(content))
        with pytest.raises(InvalidNetworkError, match=message) as caught:
            read_network(path)
        assert str(caught.value).startswith(f"{path}: ")

    @pytest.mark.parametrize(
        ("place", "value", "message"),
        [
            (["curves", 3, "nodes", 0], 99, r"curves\[3\]\.nodes\[0\]: there is no node 99"),
            (["curves", 3, "nodes", 0], 9, r"curves\[3\]\.nodes\[0\]: the curve ends .* away"),
            (["curves", 3, "nodes"], [1], r"curves\[3\]\.nodes: a list is not a pair"),
            (["tolerance"], 1, "a tolerance has nothing to do"),
            (["cycles", 0, 0, "reversed"], True, r"cycles\[0\]: .*do not close"),
        ],
    )
    def test_refusals_with_given_nodes(self, place: list[Any], value: object, message: str) -> None:
        content = copy.deepcopy(document(TREBOL))
        change(content, place, value)
        with pytest.raises(InvalidNetworkError, match=message):
            parsed(content)

    def test_names_may_be_given_as_text(self) -> None:
        network = parsed(CROSSED | {"cycles": []}).network
        assert named_cycle(network, ["0", "across", "2", "3"]).key == (
            named_cycle(network, [0, "across", 2, 3]).key
        )
        with pytest.raises(InvalidNetworkError, match="there is no curve '9'"):
            named_cycle(network, ["9"])
        whole = named_cycle(network, [0, 1, 2, 3])
        assert len(whole.steps) == 6
        with pytest.raises(InvalidNetworkError):
            named_cycle(network, [Named(0, backward=True), Named(1, backward=False), 2, 3])


def same(one: Network, other: Network) -> bool:
    return (
        one.nodes.tobytes() == other.nodes.tobytes()
        and one.cycles == other.cycles
        and len(one.curves) == len(other.curves)
        and all(
            (a.nodes, a.id, a.stroke) == (b.nodes, b.id, b.stroke)
            and a.points.tobytes() == b.points.tobytes()
            for a, b in zip(one.curves, other.curves, strict=True)
        )
    )


class TestWriting:
    @pytest.mark.parametrize(
        "path",
        [GRAPHS[0], GRAPHS[-1], STROKES[0], *LOOPS, TREBOL, TREBOL_PATCHES],
        ids=lambda path: path.name,
    )
    def test_what_is_written_is_read_back_exactly(self, path: Path, tmp_path: Path) -> None:
        drawn = read_drawing(path)
        written = tmp_path / "written.json"
        stages = drawn.stages if path in (TREBOL, STROKES[0]) else ()
        write_network(written, drawn.network, stages)
        again = read_drawing(written)
        assert same(again.network, drawn.network)
        assert again.stages == stages and again.notes == ()

    def test_cycles_over_parts_of_one_curve_come_back(self, tmp_path: Path) -> None:
        drawn = parsed(CROSSED | {"cycles": [[0, 1, 2, 3], [0, "across", 2, 3]]})
        write_network(tmp_path / "n.json", drawn.network, drawn.stages)
        again = read_drawing(tmp_path / "n.json")
        assert same(again.network, drawn.network)
        assert [set(stage) for stage in again.stages] == [set(stage) for stage in drawn.stages]

    def test_both_halves_of_a_ring_are_told_apart(self) -> None:
        ring = [[math.cos(t), math.sin(t)] for t in np.linspace(0, 2 * math.pi, 33)[:-1]]
        ring.append(ring[0])
        network = network_of_polylines([ring, [[-2, 0.3], [2, 0.3]]])
        arcs = [i for i, c in enumerate(network.curves) if c.id == 0]
        chord = max(
            (i for i, c in enumerate(network.curves) if c.id == 1),
            key=lambda i: network.curves[i].length,
        )
        cycles = []
        for arc in arcs:
            turned = network.curves[arc].nodes[0] != network.curves[chord].nodes[1]
            cycles.append(Cycle(((chord, False), (arc, turned))))
        whole = Network(network.curves, network.nodes, tuple(cycles))
        assert same(parsed(network_document(whole)).network, whole)

    def test_a_stage_of_parts_is_refused(self) -> None:
        network = parsed(CROSSED | {"cycles": []}).network
        with pytest.raises(InvalidNetworkError, match="some parts of a curve"):
            network_document(network, [[0]])


def places_in(value: object, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [at] if at else []
    if isinstance(value, dict):
        found += [p for key, inner in value.items() for p in places_in(inner, (*at, key))]
    if isinstance(value, list):
        found += [p for i, inner in enumerate(value) for p in places_in(inner, (*at, i))]
    return found


SMALL: list[Document] = [
    CROSSED,
    square_graph(),
    {
        "nodes": [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        "curves": [
            {"id": 0, "nodes": [0, 1], "points": [[0, 0, 0], [1, 0, 0]]},
            {"id": 0, "nodes": [1, 2], "points": [[1, 0, 0], [1, 1, 0]]},
            {"id": 1, "nodes": [2, 0], "points": [[1, 1, 0], [0, 0, 0]]},
        ],
        "cycles": [[{"curve": 0, "part": 0}, {"curve": 0, "part": 1}, {"curve": 1}]],
        "stages": [[0], [1]],
    },
]
ODD = st.sampled_from(
    [
        *(None, True, -1, 0, 1, 2, 3, 0.5, 1e308, -1e99, 1e-300, 10**30, "", "0", "across"),
        *([], {}, [0, 0], [0, 0, 0], [[0, 0], [1, 1]], [[0, 0, 0]] * 4, {"curve": 0}),
    ]
)


@settings(deadline=None, max_examples=400)
@given(st.data())
def test_a_changed_document_is_read_or_refused_by_name(data: st.DataObject) -> None:
    content = json.loads(json.dumps(data.draw(st.sampled_from(SMALL))))
    for _ in range(data.draw(st.integers(1, 3))):
        place = list(data.draw(st.sampled_from(places_in(content))))
        if data.draw(st.booleans()):
            change(content, place, copy.deepcopy(data.draw(ODD)))
        else:
            change(content, place, copy.deepcopy(value_at(content, place[:1])))
    try:
        parse_drawing(json.dumps(content).encode())
    except InvalidNetworkError as error:
        assert str(error)


def value_at(content: object, place: list[Any]) -> object:
    at: Any = content
    for key in place:
        at = at[key]
    return at


TEXTS = [
    (CURVES / "salvi" / "pocket3sided.lop").read_text(),
    "v 3\n0 0 0\n1 0 0\n1 1 0\nv 2\n0 0.5 0\n2 0.5 0\n",
    "1\n3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n.5 -1 0\n1.5 .5 0\n.5 .5 0\n",
]
ODD_WORDS = ["", "0", "-1", "1", "2", "7", "x", "v", "nan", "1e308", "1e-300", "9" * 30, "\n", "²"]


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_a_changed_text_is_read_or_refused_by_name(data: st.DataObject) -> None:
    lines = [line.split() for line in data.draw(st.sampled_from(TEXTS)).splitlines()]
    for _ in range(data.draw(st.integers(1, 3))):
        line = data.draw(st.integers(0, len(lines) - 1))
        if lines[line]:
            word = data.draw(st.integers(0, len(lines[line]) - 1))
            lines[line][word] = data.draw(st.sampled_from(ODD_WORDS))
        if data.draw(st.integers(0, 9)) == 0:
            del lines[line:]
            lines.append(["0"])
    try:
        parse_drawing("\n".join(map(" ".join, lines)).encode())
    except InvalidNetworkError as error:
        assert str(error)


@pytest.mark.parametrize("data", [b"", b"\xff\xfe", b"1\n\xff", b"[]", b"7", b"null", b'"v"', b"v"])
def test_what_is_no_network(data: bytes) -> None:
    with pytest.raises(InvalidNetworkError):
        parse_drawing(data)
