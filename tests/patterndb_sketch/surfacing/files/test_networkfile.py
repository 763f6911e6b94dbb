"""Networks of plain JSON: what is read, what is refused, and what is written and read back."""

from __future__ import annotations

import copy
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.joining import network_of_polylines
from patterndb_sketch.curvenetwork.naming import NamedCurve, named_cycle
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.files.networkjson import network_document
from patterndb_sketch.surfacing.networkfile import read_drawing, read_network, write_network
from tests.support.surfacing.networkfiles import (
    CLOSED,
    COUNTS,
    CROSSED,
    CURVES,
    GRAPHS,
    LOOPS,
    PATCHES,
    STROKES,
    change,
    document,
    list_graphs,
    parsed,
)
from tests.support.surfacing.sketches import FOLDER, list_files


def test_the_data_is_there() -> None:
    assert list_graphs() and STROKES and LOOPS
    assert {path.stem for path in CLOSED} <= set(COUNTS)
    if CURVES.is_dir():
        assert (len(list_files()), len(GRAPHS), len(STROKES), len(LOOPS)) == (15, 47, 23, 7)


@pytest.mark.parametrize(("path", "text"), list_files().items(), ids=list(list_files()))
def test_the_files_are_what_the_script_draws(path: str, text: str) -> None:
    written = re.split(r"[\s,\[\]{}:]+", (FOLDER / path).read_text())
    for word, other in zip(written, re.split(r"[\s,\[\]{}:]+", text), strict=True):
        # Up to rounding, which may differ between platforms.
        assert word == other or float(word) == pytest.approx(float(other), abs=2e-5)


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
        content = copy.deepcopy(document(FOLDER / "gem.json"))
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
            named_cycle(
                network, [NamedCurve(0, backward=True), NamedCurve(1, backward=False), 2, 3]
            )


def same(one: CurveNetwork, other: CurveNetwork) -> bool:
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
        [GRAPHS[0], GRAPHS[-1], STROKES[0], *LOOPS, *CLOSED, *PATCHES],
        ids=lambda path: path.name,
    )
    def test_what_is_written_is_read_back_exactly(self, path: Path, tmp_path: Path) -> None:
        drawn = read_drawing(path)
        written = tmp_path / "written.json"
        stages = drawn.stages if path in (*CLOSED, STROKES[0]) else ()
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
        whole = CurveNetwork(network.curves, network.nodes, tuple(cycles))
        assert same(parsed(network_document(whole)).network, whole)

    def test_a_stage_of_parts_is_refused(self) -> None:
        network = parsed(CROSSED | {"cycles": []}).network
        with pytest.raises(InvalidNetworkError, match="some parts of a curve"):
            network_document(network, [[0]])
