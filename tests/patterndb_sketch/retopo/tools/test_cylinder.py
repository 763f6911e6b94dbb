"""Loops by planes, and patches between two loops."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    AtChain,
    Network,
    NetworkBuilder,
    are_equal,
    check_network,
    find_nearest_place,
    take_samples,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.cylinder import find_rings, join_loops
from patterndb_sketch.retopo.tools.loop import cut_loop, plane_of_line
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.surfaces import plane, sphere, tube

SIZES = Sizes(snap=0.15, spine=0.3, autocompletion=0.3, brush=0.3, edge=0.3, sampling=0.02)

#: Half a degree.
NEAR = np.deg2rad(0.5)


@cache
def long_tube() -> Surface:
    return tube(around=72, along=40, length=4.0)


@cache
def ball() -> Surface:
    return sphere(4)


def circle(surface: Surface, z: float, network: Network, radius: float = 1.0) -> Network:
    """With the loop at height z, by the loop tool."""
    start = surface.nearest([[radius, 0.0, z]])
    return cut_loop(network, surface, SIZES, start, (0.0, 0.0, 1.0)).network


def two_loops(surface: Surface, low: float, high: float) -> Network:
    network = Network()
    for z in (low, high):
        network = circle(surface, z, network, float(np.sqrt(max(1.0 - z * z, 0.0))) or 1.0)
    return network


def drawn(surface: Surface, *points: tuple[float, float, float]) -> SurfaceCurve:
    return clean_stroke(points, surface, SIZES, closed=False)


def angles(network: Network, z: float) -> np.ndarray:
    """Angles, in degrees, of the nodes at a height."""
    at = [node.point for node in network.nodes.values() if abs(node.point[2] - z) < 1e-6]
    return np.sort([np.rad2deg(np.arctan2(p[1], p[0])) % 360.0 for p in at])


def near_angles(found: np.ndarray, expected: list[float]) -> bool:
    off = (np.asarray(found)[:, None] - expected + 180.0) % 360.0 - 180.0
    return len(found) == len(expected) and bool((np.abs(off).min(axis=0) < 0.5).all())


def with_corners(network: Network, z: float, degrees: list[float]) -> Network:
    """The network with corners on the loop at a height, on both of its sides."""
    for angle in np.deg2rad(degrees):
        point = (np.cos(angle), np.sin(angle), z)
        place = find_nearest_place(take_samples(network), point, point * np.array([1, 1, 0]), 0.1)
        assert place is not None
        builder = NetworkBuilder(network)
        node = builder.end_node(AtChain(place.chain, place.place), np.zeros(3), np.zeros(3))
        for half in builder.nodes[node].ends:
            builder.flag(half, True)
        network = builder.finish()
    return network


def test_a_plane_cuts_a_closed_loop() -> None:
    network = circle(long_tube(), 1.0, Network())
    (chain,) = network.chains.values()
    assert chain.is_closed_loop
    assert np.allclose(chain.points[:, 2], 1.0)
    assert chain.length == pytest.approx(72 * 2 * np.sin(np.pi / 72), rel=1e-3)


def test_a_plane_along_a_tube_cuts_from_border_to_border() -> None:
    surface = long_tube()
    edit = cut_loop(Network(), surface, SIZES, surface.nearest([[1.0, 0.0, 2.0]]), (0.0, 1.0, 0.0))
    (chain,) = edit.network.chains.values()
    assert not chain.is_closed_loop
    assert np.allclose(np.sort(chain.points[[0, -1], 2]), [0.0, 4.0])


def test_the_line_across_a_part_gives_the_plane() -> None:
    normal, limit = plane_of_line((-1.0, 0.0, 2.0), (1.0, 0.0, 2.0), (0.0, 1.0, 0.0))
    assert np.allclose(np.abs(normal) / np.linalg.norm(normal), (0.0, 0.0, 1.0))
    assert limit == 20.0
    surface = long_tube()
    found = cut_loop(Network(), surface, SIZES, surface.nearest([[0.0, -1.0, 2.0]]), normal, limit)
    assert len(found.network.chains) == 1
    with pytest.raises(RefusedError, match="longer than its limit"):
        cut_loop(Network(), surface, SIZES, surface.nearest([[0.0, -1.0, 2.0]]), normal, 2.0)
    with pytest.raises(RefusedError, match="no length"):
        plane_of_line((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def test_a_stroke_between_two_loops_makes_four_patches() -> None:
    surface = long_tube()
    edit = join_loops(two_loops_of_tube(), surface, SIZES, drawn(surface, (1, 0, 1), (1, 0, 3)))
    network = edit.network
    check_network(network)
    assert [len(p.corners) for p in network.patches.values()] == [4] * 4
    for z in (1.0, 3.0):
        assert near_angles(angles(network, z), [0, 90, 180, 270])
    # Four curves between, and each loop in four.
    assert len(network.chains) == 12


def two_loops_of_tube() -> Network:
    network = circle(long_tube(), 1.0, Network())
    return circle(long_tube(), 3.0, network)


def test_corners_of_one_loop_are_carried_over_to_the_other() -> None:
    surface = long_tube()
    before = with_corners(two_loops_of_tube(), 1.0, [0, 90, 180])
    network = join_loops(before, surface, SIZES, drawn(surface, (1, 0, 1), (1, 0, 3))).network
    check_network(network)
    assert len(network.patches) == 3
    assert near_angles(angles(network, 3.0), [0, 90, 180])
    # The same from the other end.
    turned = join_loops(before, surface, SIZES, drawn(surface, (1, 0, 3), (1, 0, 1))).network
    check_network(turned)
    assert near_angles(angles(turned, 3.0), [0, 90, 180])


def test_corners_of_both_loops_are_joined_in_order() -> None:
    surface = long_tube()
    before = with_corners(two_loops_of_tube(), 1.0, [0, 100, 200])
    before = with_corners(before, 3.0, [10, 130, 240])
    stroke = drawn(surface, (1, 0, 1), (np.cos(0.17), np.sin(0.17), 3))
    network = join_loops(before, surface, SIZES, stroke).network
    check_network(network)
    assert len(network.patches) == 3
    assert near_angles(angles(network, 3.0), [10, 130, 240])
    assert len(network.nodes) == 6


def test_other_divisions() -> None:
    surface = long_tube()
    for division in (2, 3, 6):
        stroke = drawn(surface, (1, 0, 1), (1, 0, 3))
        network = join_loops(two_loops_of_tube(), surface, SIZES, stroke, division).network
        check_network(network)
        assert len(network.patches) == division
        assert near_angles(angles(network, 1.0), [360.0 * j / division for j in range(division)])


def test_a_second_cylinder_goes_on_from_the_first() -> None:
    surface = long_tube()
    network = circle(surface, 2.0, two_loops_of_tube())
    network = join_loops(network, surface, SIZES, drawn(surface, (1, 0, 1), (1, 0, 2))).network
    network = join_loops(network, surface, SIZES, drawn(surface, (0, 1, 2), (0, 1, 3))).network
    check_network(network)
    assert len(network.patches) == 8
    assert near_angles(angles(network, 2.0), [0, 90, 180, 270])


def test_on_a_ball_the_pole_gets_a_cap() -> None:
    surface = ball()
    low, high = np.sin(np.deg2rad([30, 70]))
    before = two_loops(surface, float(low), float(high))
    c30, c70 = np.cos(np.deg2rad([30, 70]))
    mid = np.deg2rad(50)
    stroke = drawn(surface, (c30, 0, low), (np.cos(mid), 0, np.sin(mid)), (c70, 0, high))
    network = join_loops(before, surface, SIZES, stroke).network
    check_network(network)
    assert len(network.patches) == 5
    assert all(len(p.corners) == 4 for p in network.patches.values())
    without = join_loops(before, surface, SIZES, stroke, caps="never").network
    assert len(without.patches) == 4
    both = join_loops(before, surface, SIZES, stroke, caps="always").network
    check_network(both)
    assert len(both.patches) == 6


def test_nested_circles_of_a_plane_are_joined_and_the_inner_one_filled() -> None:
    surface = plane(columns=60, rows=60, step=0.1)
    network = Network()
    for radius in (1.0, 2.0):
        t = np.linspace(0, 2 * np.pi, 200, endpoint=False)
        points = np.c_[3 + radius * np.cos(t), 3 + radius * np.sin(t), 0 * t]
        closed = clean_stroke(points, surface, SIZES, closed=True)
        network = insert_stroke(network, surface, SIZES, closed).network
    stroke = drawn(surface, (4, 3, 0), (5, 3, 0))
    after = join_loops(network, surface, SIZES, stroke).network
    check_network(after)
    assert len(after.patches) == 5


def test_what_cannot_be_is_refused_and_nothing_changes() -> None:
    surface = long_tube()
    before = two_loops_of_tube()
    kept = two_loops_of_tube()
    three_and_four = with_corners(with_corners(before, 1.0, [0, 120, 240]), 3.0, [0, 90, 180, 270])
    cases = [
        (before, drawn(surface, (1, 0, 1), (1, 0, 2)), "at its end"),
        (before, drawn(surface, (1, 0, 2), (1, 0, 3)), "at its start"),
        (three_and_four, drawn(surface, (1, 0, 1), (1, 0, 3)), "3 corners and the other 4"),
        (
            before,
            drawn(surface, (1, 0, 1.02), (0.7, 0.7, 1.4), (0, 1, 1.02)),
            "begins and ends at one loop",
        ),
    ]
    for network, stroke, words in cases:
        with pytest.raises(RefusedError, match=words):
            join_loops(network, surface, SIZES, stroke)
    assert are_equal(before, kept)
    with pytest.raises(InvalidRetopoError, match="division"):
        join_loops(before, surface, SIZES, cases[0][1], division=1)


def test_curves_in_the_way_are_not_crossed() -> None:
    surface = long_tube()
    across = drawn(surface, (-0.3, -1, 2), (0.3, -1, 2))
    network = insert_stroke(two_loops_of_tube(), surface, SIZES, across).network
    with pytest.raises(RefusedError, match="cross"):
        join_loops(network, surface, SIZES, drawn(surface, (1, 0, 1), (1, 0, 3)))


def test_a_loop_has_a_ring_on_either_side_until_patches_are_there() -> None:
    surface = long_tube()
    before = two_loops_of_tube()
    assert len(find_rings(before)) == 4
    after = join_loops(before, surface, SIZES, drawn(surface, (1, 0, 1), (1, 0, 3))).network
    assert len(find_rings(after)) == 2
