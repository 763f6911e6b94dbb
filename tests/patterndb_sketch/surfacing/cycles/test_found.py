"""What holds of all cycles found: on closed, open, twisted and torn networks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
from patterndb_sketch.surfacing.cycles.found import find_pinches, list_users, orient_cycles
from patterndb_sketch.surfacing.networkfile import read_network
from tests.support.surfacing.networkfiles import CLOSED, GRAPHS, list_graphs
from tests.support.surfacing.networks import cube, faces_network, prism, ring, shuffled, torus


def keys(cycles: tuple[Cycle, ...]) -> set[object]:
    return {cycle.key for cycle in cycles}


def names(network: CurveNetwork, cycles: tuple[Cycle, ...]) -> set[frozenset[object]]:
    return {frozenset(network.names(cycle)) for cycle in cycles}


def bare(network: CurveNetwork) -> CurveNetwork:
    return CurveNetwork(network.curves, network.nodes)


def polygon_prism(n: int) -> CurveNetwork:
    at = [2 * math.pi * i / n for i in range(n)]
    points = [[math.cos(a), math.sin(a), z] for z in (0.0, 1.3) for a in at]
    sides = [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
    return faces_network(points, [list(range(n))[::-1], list(range(n, 2 * n)), *sides])


def checked(network: CurveNetwork, most: int = 2) -> FoundCycles:
    """What is found, after all that must hold of any result. most: cycles at a curve."""
    found = find_cycles(bare(network))
    for cycle in found.cycles:
        network.walk(cycle)
    walks = list_users(found.cycles)
    assert max(map(len, walks.values()), default=0) <= most
    assert found.once == tuple(sorted(c for c, both in walks.items() if len(both) == 1))
    groups = [set(found.dangling), set(found.unused), set(walks)]
    assert sum(map(len, groups)) == len(network.curves)
    assert set[int]().union(*groups) == set(range(len(network.curves)))
    # Nothing was added by hand, so it is a surface: two sides, and one sheet at every node.
    assert found.orientable and not orient_cycles(found.cycles).twisted
    assert found.pinches == () and find_pinches(network, found.cycles) == []
    # Where a wall stands on two others, no turning of all cycles agrees at every curve.
    if max(map(len, walks.values()), default=0) <= 2:
        for both in walks.values():
            assert len(both) < 2 or both[0][1] != both[1][1]
    return found


@pytest.mark.parametrize(
    "network",
    [polygon_prism(4), polygon_prism(6), torus(4, 5), torus(5, 4), torus(6, 8), torus(12, 16)],
)
def test_faces_of_prisms_and_of_torus_grids_are_found_exactly(network: CurveNetwork) -> None:
    found = checked(network)
    assert keys(found.cycles) == keys(network.cycles)
    assert found.proven and not found.notes


@pytest.mark.parametrize(
    "path",
    list_graphs("01-2-1", "02-2-2", "08-2-2", "11-2-1", "shield"),
    ids=lambda path: path.stem,
)
def test_what_is_found_in_sketches_is_a_surface(path: Path) -> None:
    # A wall may stand on two others.
    assert checked(read_network(path), most=3).cycles


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("make", ["torus", "prism", *(p.stem for p in list_graphs("01-2-2"))])
def test_order_sense_and_numbers_of_the_curves_do_not_matter(make: str, seed: int) -> None:
    made = {"torus": torus, "prism": lambda: polygon_prism(5)}
    if make in made:
        network = made[make]()
    else:
        network = read_network(next(path for path in GRAPHS if path.stem == make))
    named = CurveNetwork(
        tuple(Curve(c.points, c.nodes, i, c.stroke) for i, c in enumerate(network.curves)),
        network.nodes,
    )
    expected = find_cycles(named).cycles
    other = shuffled(named, seed)
    assert names(other, find_cycles(other).cycles) == names(named, expected)
    order = np.random.default_rng(seed).permutation(len(named.nodes))
    place = np.argsort(order).tolist()
    renumbered = CurveNetwork(
        tuple(
            Curve(c.points, (place[c.nodes[0]], place[c.nodes[1]]), c.id, c.stroke)
            for c in named.curves
        ),
        named.nodes[order],
    )
    assert keys(find_cycles(renumbered).cycles) == keys(expected)


@pytest.mark.parametrize("path", CLOSED, ids=lambda path: path.stem)
def test_moved_turned_and_scaled_the_cycles_stay(path: Path) -> None:
    network = read_network(path)
    rotation, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))

    def moved(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return 0.01 * points @ rotation + np.array([5.0, -7.0, 2.0])

    nodes = moved(network.nodes)
    curves: list[Curve] = []
    for curve in network.curves:
        points = moved(curve.points)
        points[0], points[-1] = nodes[curve.nodes[0]], nodes[curve.nodes[1]]
        curves.append(Curve(points, curve.nodes, curve.id, curve.stroke))
    assert keys(find_cycles(CurveNetwork(tuple(curves), nodes)).cycles) == keys(network.cycles)


def test_the_same_network_gives_the_same_result() -> None:
    assert find_cycles(torus(4, 5)) == find_cycles(torus(4, 5))


@pytest.mark.parametrize("face", range(6))
def test_a_banned_face_stays_away_and_the_others_remain(face: int) -> None:
    network = cube()
    found = find_cycles(network, banned=[network.cycles[face].turned])
    assert keys(found.cycles) == keys(network.cycles) - {network.cycles[face].key}
    assert set(found.once) == set(network.cycles[face].curves)


def test_a_cross_section_is_taken_only_if_added() -> None:
    network = torus()
    number = {frozenset(curve.nodes): i for i, curve in enumerate(network.curves)}
    steps: list[tuple[int, bool]] = []
    for a, b in zip(range(6), [1, 2, 3, 4, 5, 0], strict=True):
        curve = number[frozenset((a, b))]
        steps.append((curve, network.curves[curve].nodes != (a, b)))
    section = Cycle(tuple(steps))
    assert section.key not in keys(find_cycles(network).cycles)
    found = find_cycles(network, added=[section, section.turned])
    assert section.key in keys(found.cycles)
    assert [cycle.key for cycle in found.cycles].count(section.key) == 1
    # Where it parts the tube, cells of the tube may stand on it as walls do.
    assert max(map(len, list_users(found.cycles).values())) <= 3


def test_all_faces_added_are_the_result() -> None:
    network = torus(4, 5)
    assert keys(find_cycles(network, added=network.cycles).cycles) == keys(network.cycles)


def test_a_third_added_cycle_at_a_curve_is_refused() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0.5], [0, 0, 1]]
    fan = faces_network(points, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(InvalidNetworkError, match="in 3 added"):
        find_cycles(fan, added=fan.cycles)
    assert keys(find_cycles(fan, added=fan.cycles[:2]).cycles) == keys(fan.cycles[:2])
    with pytest.raises(InvalidNetworkError, match="closings is 0"):
        find_cycles(fan, closings=0)


def circle(radius: float) -> NDArray[np.float64]:
    at = np.linspace(0, 2 * math.pi, 41)
    points = radius * np.stack([1 - np.cos(at), np.sin(at), 0 * at], axis=1)
    points[-1] = points[0]
    return points


def test_a_closed_curve_is_a_cycle() -> None:
    network = ring(circle(1.0)[:-1])
    found = checked(network)
    assert keys(found.cycles) == keys(network.cycles)
    assert found.once == (0,)


def test_two_closed_curves_at_a_node_are_two_cycles() -> None:
    left, right = circle(1.0), -circle(2.0)
    curves = (Curve(left, (0, 0), "left", "left"), Curve(right, (0, 0), "right", "right"))
    assert [cycle.curves for cycle in checked(CurveNetwork(curves, left[:1])).cycles] == [
        (0,),
        (1,),
    ]


def test_two_curves_on_one_another_enclose_nothing() -> None:
    found = checked(CurveNetwork.from_edges([[0, 0, 0], [1, 0, 0]], [[0, 1], [0, 1]]))
    assert found.cycles == ()
    assert found.unused == (0, 1)


def test_parts_that_do_not_hang_together_are_found_each() -> None:
    one, other = cube(), prism()
    points = np.concatenate([one.nodes, other.nodes + np.array([5.0, 0.0, 0.0])])
    shift = len(one.nodes)
    edges = [c.nodes for c in one.curves]
    edges += [(c.nodes[0] + shift, c.nodes[1] + shift) for c in other.curves]
    found = checked(CurveNetwork.from_edges(points, edges))
    expected = {frozenset(c.curves) for c in one.cycles}
    expected |= {frozenset(i + len(one.curves) for i in c.curves) for c in other.cycles}
    assert {frozenset(cycle.curves) for cycle in found.cycles} == expected


def test_the_boundary_of_an_open_sheet_is_not_filled() -> None:
    m = 5
    points = [[i, j, 0.1 * (i - 2) ** 2] for i in range(m) for j in range(m)]
    corners = [i * m + j for i in range(m - 1) for j in range(m - 1)]
    network = faces_network(points, [[c, c + m, c + m + 1, c + 1] for c in corners])
    found = checked(network)
    assert keys(found.cycles) == keys(network.cycles)
    assert len(found.once) == 4 * (m - 1)


def moebius_strip(n: int) -> CurveNetwork:
    points: list[list[float]] = []
    for i in range(n):
        u = 2 * math.pi * i / n
        for side in (-1, 1):
            r = 3 + side * math.cos(u / 2)
            points.append([r * math.cos(u), r * math.sin(u), side * math.sin(u / 2)])
    rungs = [(2 * i, 2 * i + 1) for i in range(n)] + [(1, 0)]
    faces = [[rungs[i][0], rungs[i + 1][0], rungs[i + 1][1], rungs[i][1]] for i in range(n)]
    return faces_network(points, faces)


@pytest.mark.parametrize("n", [8, 10])
def test_a_strip_that_turns_over_is_found_and_told(n: int) -> None:
    network = moebius_strip(n)
    for added in ((), network.cycles):
        whole = find_cycles(bare(network), added=added)
        assert keys(whole.cycles) == keys(network.cycles)
        assert not whole.orientable
        assert any("Moebius" in note for note in whole.notes)
