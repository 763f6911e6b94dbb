"""What stays open: rims and curves without a patch, against what topology says of them."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing import find_cycles, find_openings
from patterndb_sketch.surfacing.networkfile import read_network
from patterndb_sketch.surfacing.openings import Openings
from tests.support.surfacing.networkfiles import list_graphs
from tests.support.surfacing.networks import cube, faces_network, torus


def assert_open(network: CurveNetwork, cycles: list[Cycle]) -> Openings:
    """Find what is open, and hold it to what it must be of any cycles."""
    openings = find_openings(network, cycles)
    uses = Counter(curve for cycle in cycles for curve in cycle.curves)
    assert openings.idle == tuple(c for c in range(len(network.curves)) if not uses[c])
    walked = Counter(curve for rim in openings.rims for curve, _ in rim.steps)
    assert walked == Counter({c: 1 for c, n in uses.items() if n == 1}), "each in one rim, once"
    for rim in openings.rims:
        for step, following in zip(rim.steps, rim.steps[1:], strict=False):
            assert network.ends(step)[1] == network.ends(following)[0]
        if rim.closed:
            assert network.ends(rim.steps[-1])[1] == network.ends(rim.steps[0])[0]
        assert rim.length == pytest.approx(sum(network.curves[c].length for c, _ in rim.steps))
    assert [rim.length for rim in openings.rims] == sorted(rim.length for rim in openings.rims)
    return openings


@given(st.sets(st.integers(0, 19)))
def test_rims_of_any_part_of_a_torus_are_closed_and_as_many_as_euler_s_sum_says(
    left: set[int],
) -> None:
    network = torus(4, 5)
    cycles = [network.cycles[i] for i in sorted(left)]
    openings = assert_open(network, cycles)
    assert all(rim.closed for rim in openings.rims)
    # Fans of faces at a node are vertices of their own: a surface with a rim through each once.
    corners = {(i, node): (i, node) for i, c in enumerate(cycles) for node in network.walk(c)}

    def root(corner: tuple[int, int]) -> tuple[int, int]:
        while corners[corner] != corner:
            corner = corners[corner]
        return corner

    faces = list(range(len(cycles)))

    def part(face: int) -> int:
        while faces[face] != face:
            face = faces[face]
        return face

    at: dict[int, list[int]] = {}
    for i, cycle in enumerate(cycles):
        for curve in cycle.curves:
            at.setdefault(curve, []).append(i)
    for curve, both in at.items():
        if len(both) == 2:
            faces[part(both[0])] = part(both[1])
            for node in network.curves[curve].nodes:
                corners[root((both[0], node))] = root((both[1], node))
    vertices = len({root(corner) for corner in corners})
    euler = vertices - len(at) + len(cycles)
    parts = len({part(face) for face in faces})
    # euler = sum over parts of 2 - 2 genus - rims, and a torus is of genus 1 as a whole at most.
    genus, odd = divmod(2 * parts - len(openings.rims) - euler, 2)
    assert not odd and 0 <= genus <= 1


def test_a_cube_without_a_face_has_the_rim_that_closes_it() -> None:
    network = cube()
    assert assert_open(network, list(network.cycles)) == Openings((), ())
    for missing in network.cycles:
        left = [cycle for cycle in network.cycles if cycle is not missing]
        openings = assert_open(network, left)
        (rim,) = openings.rims
        assert Cycle(rim.steps).key == missing.key and not openings.idle
        assert rim.list_names(network) == network.names(Cycle(rim.steps))
    openings = assert_open(network, [])
    assert openings.idle == tuple(range(12)) and not openings.rims


def test_rims_that_touch_in_a_node_stay_apart() -> None:
    points = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    network = faces_network(points, [[0, 1, 2], [0, 3, 4]])
    openings = assert_open(network, list(network.cycles))
    assert [len(rim.steps) for rim in openings.rims] == [3, 3]


def test_a_rim_ends_where_a_curve_bounds_three_patches() -> None:
    points = [[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]]
    network = faces_network(points, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    openings = assert_open(network, list(network.cycles))
    assert [(len(rim.steps), rim.closed) for rim in openings.rims] == [(2, False)] * 3


def test_a_closed_curve_is_a_rim_by_itself() -> None:
    turn = np.linspace(0, 2 * np.pi, 33)
    ring = np.c_[np.cos(turn), np.sin(turn), 0 * turn]
    ring[-1] = ring[0]
    network = CurveNetwork((Curve(ring, (0, 0), "ring", "ring"),), ring[:1])
    (rim,) = assert_open(network, [Cycle(((0, True),))]).rims
    assert rim.closed and rim.list_names(network) == ["ring"]


@pytest.mark.parametrize(
    "path", list_graphs("computer-mouse", "01-2-1", "08-2-2"), ids=lambda path: path.stem
)
def test_rims_of_sketches_are_closed(path: Path) -> None:
    network = read_network(path)
    found = find_cycles(network)
    openings = assert_open(network, list(found.cycles))
    assert all(rim.closed for rim in openings.rims)
    assert set(openings.idle) == {*found.unused, *found.dangling}
