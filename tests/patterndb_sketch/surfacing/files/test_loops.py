"""Networks from patches and loops of curves."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline

from patterndb._native.surfacing.curvenetwork.meetings import measure_deviation
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import measure_turning
from patterndb_sketch.surfacing.networkfile import parse_drawing, read_network
from tests.support.surfacing.networkfiles import CLOSED, COUNTS, LOOPS, bezier, document, parsed
from tests.support.surfacing.sketches import FOLDER


@pytest.mark.parametrize("path", CLOSED, ids=lambda path: path.stem)
class TestClosedNetworks:
    def test_it_comes_out_exact(self, path: Path) -> None:
        network, given = read_network(path), document(path)
        counts = (len(network.nodes), len(network.curves), len(network.cycles))
        assert counts == COUNTS[path.stem]
        assert network.nodes.tolist() == given["nodes"]
        for curve, one in zip(network.curves, given["curves"], strict=True):
            assert (curve.id, list(curve.nodes)) == (one["id"], one["nodes"])
            assert curve.points.tolist() == one["points"]
        for cycle, one in zip(network.cycles, given["cycles"], strict=True):
            assert cycle.steps == tuple((step["curve"], step["reversed"]) for step in one)

    def test_its_polylines_alone_meet_at_the_same_nodes(self, path: Path) -> None:
        given = document(path)
        drawn = {
            "curves": [{"id": c["id"], "points": c["points"]} for c in given["curves"]],
            "cycles": [[step["curve"] for step in cycle] for cycle in given["cycles"]],
        }
        network = parsed(drawn).network
        assert (len(network.nodes), len(network.curves)) == COUNTS[path.stem][:2]
        whole = read_network(path)
        for cycle, exact in zip(network.cycles, whole.cycles, strict=True):
            assert cycle.key == exact.key

    def test_the_patches_it_was_made_from_give_the_same(self, path: Path) -> None:
        patches = path.with_name(path.stem.removesuffix("_network") + ".sdm")
        network, exact = read_network(patches), read_network(path)
        # Patches number nodes and curves as they come.
        place = {tuple(node): i for i, node in enumerate(exact.nodes.tolist())}
        node = [place[tuple(one)] for one in network.nodes.tolist()]
        assert sorted(node) == list(range(len(exact.nodes)))
        number = {frozenset(c.nodes): i for i, c in enumerate(exact.curves)}
        own = [number[frozenset(node[end] for end in c.nodes)] for c in network.curves]
        assert sorted(own) == list(range(len(exact.curves)))
        around = [{own[curve] for curve in cycle.curves} for cycle in network.cycles]
        assert around == [set(cycle.curves) for cycle in exact.cycles]
        given = document(path)["curves"]
        for curve, one in zip(network.curves, [given[i] for i in own], strict=True):
            line = bezier(np.array(one["bezier"]))
            assert measure_deviation(curve.points, line) < 1e-4 * curve.length
            assert measure_deviation(line, curve.points) < 1e-3 * curve.length
            assert measure_turning(curve.points).max(initial=0) <= math.radians(5)


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
            assert measure_deviation(line, curve.points) < 1.5e-3 * curve.length
            assert measure_deviation(curve.points, line) < 1e-4 * curve.length
            assert measure_turning(curve.points).max() <= math.radians(5)

    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            ("3\n3\n", "4\n3\n", r"line \d+: .* is not|ends where"),
            ("3\n3\n9 0", "3\n3\n9 x", "line 3: 'x' is not a knot"),
            ("0 0.3 1", "0 1.3 1", "line 4: .*descend"),
            ("3\n3\n9", "3\n99\n9", "line 2: the degree is 99|only"),
            ("\n5 40 0 0 ", "\n5 99 0 0 ", "curve 2 ends .* away from"),
            ("\n5 40 0 0 ", "\n5 nan 0 0 ", "'nan' is not a finite number"),
            ("9 0 0 0 0 0.3", "999999 0 0 0 0 0.3", "only .* words follow"),
        ],
    )
    def test_refusals(self, old: str, new: str, message: str) -> None:
        text = (FOLDER / "loop3.lop").read_text()
        assert text.count(old) == 1
        with pytest.raises(InvalidNetworkError, match=message):
            parse_drawing(text.replace(old, new).encode())
