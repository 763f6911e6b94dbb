"""Cycles found from the curves alone."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing import InvalidNetworkError, find_cycles, network_of_polylines
from patterndb_sketch.surfacing.networkfile import read_network, read_recorded_patches
from tests.support.meshes import models, shared_meshes
from tests.support.surfacing.networkfiles import CLOSED, GRAPHS, PATCHES, list_graphs
from tests.support.surfacing.networks import cube, faces_network, prism, ring, shuffled, torus

#: Coarse meshes whose faces are the cycles.
CAGES = [
    *(path for path in models() if path.stem in ("chair", "knot")),
    *shared_meshes("spot", "penguin"),
]

#: Sketches of the tests, and small ones that people drew: their means must be above what a greedy
#: program had on twelve.
DRAWN = list_graphs()
SKETCHES = [
    path
    for path in GRAPHS
    if path.stem
    in ("01-2-1", "01-2-2", "02-2-1", "04-2-2", "07-2-1", "08-2-1", "computer-mouse", "shield")
]


def bare(network: CurveNetwork) -> CurveNetwork:
    return CurveNetwork(network.curves, network.nodes)


def keys(cycles: tuple[Cycle, ...]) -> set[object]:
    return {cycle.key for cycle in cycles}


def cage(path: Path) -> CurveNetwork:
    """A coarse mesh's edges, with its faces as cycles."""
    mesh = read_mesh(path)
    faces = [face.tolist() for face in np.split(mesh.corners, mesh.offsets[1:-1])]
    return faces_network(mesh.points, faces)


@cache
def exact() -> dict[str, CurveNetwork]:
    """Networks whose patches are known."""
    return {
        "cube": cube(),
        "prism": prism(),
        "torus": torus(),
        "lean torus": torus(12, 5),
        "fine torus": torus(16, 12),
        **{path.stem: read_network(path) for path in CLOSED},
        **{path.stem: cage(path) for path in CAGES},
    }


@pytest.mark.parametrize("name", exact())
def test_the_patches_of_closed_networks_are_found_exactly(name: str) -> None:
    network = exact()[name]
    found = find_cycles(bare(network))
    assert keys(found.cycles) == keys(network.cycles)
    assert found.once == found.unused == found.dangling == ()
    assert found.orientable
    assert found.proven


@pytest.mark.parametrize("name", ["cube", "torus", *(path.stem for path in CLOSED)])
@pytest.mark.parametrize("seed", range(3))
def test_order_and_sense_of_the_curves_change_no_cycle(name: str, seed: int) -> None:
    network = exact()[name]
    other = shuffled(network, seed)
    found = find_cycles(bare(other))
    names = {frozenset(other.names(cycle)) for cycle in found.cycles}
    assert names == {frozenset(network.names(cycle)) for cycle in network.cycles}


@pytest.mark.parametrize("name", ["cube", *(path.stem for path in [*CLOSED, *CAGES[:-1]])])
def test_neighbours_walk_the_curve_between_them_in_opposite_senses(name: str) -> None:
    network = exact()[name]
    senses: dict[int, list[bool]] = {}
    for cycle in find_cycles(bare(network)).cycles:
        network.walk(cycle)
        for curve, backward in cycle.steps:
            senses.setdefault(curve, []).append(backward)
    assert all(sorted(both) == [False, True] for both in senses.values())


@pytest.mark.parametrize("points", [4, 9, 40])
@pytest.mark.parametrize("path", [*CLOSED, *PATCHES], ids=lambda path: path.name)
def test_how_finely_curves_are_drawn_changes_no_cycle(path: Path, points: int) -> None:
    network = read_network(path)
    assert keys(find_cycles(bare(network)).cycles) == keys(network.cycles)
    curves = tuple(
        Curve(sample_polyline(c.points, points), c.nodes, c.id, c.stroke) for c in network.curves
    )
    found = find_cycles(CurveNetwork(curves, network.nodes))
    assert keys(found.cycles) == keys(network.cycles)


@pytest.mark.parametrize("paths", [DRAWN, *([SKETCHES] if SKETCHES else [])], ids=len)
def test_sketches_are_met_better_than_by_a_greedy_program(paths: list[Path]) -> None:
    recall, precision = [], []
    for path in paths:
        network = read_network(path)
        strokes = {curve.stroke for curve in network.curves}
        recorded = {
            frozenset(patch.strokes)
            for patch in read_recorded_patches(path)
            if not patch.manually_deleted and strokes.issuperset(patch.strokes)
        }
        found = find_cycles(network)
        count = np.zeros(len(network.curves), int)
        for cycle in found.cycles:
            network.walk(cycle)
            count[list(cycle.curves)] += 1
        # Two, and a wall that stands on them.
        assert count.max() <= 3
        assert set(np.flatnonzero(count == 1).tolist()) == set(found.once)
        assert set(np.flatnonzero(count == 0).tolist()) == {*found.unused, *found.dangling}
        around = [frozenset(network.curves[c].stroke for c in y.curves) for y in found.cycles]
        recall.append(len(recorded & set(around)) / len(recorded))
        precision.append(np.mean([strokes_of in recorded for strokes_of in around]))
    assert np.mean(recall) > 0.54
    assert np.mean(precision) > 0.82


def test_banned_cycles_are_not_there_and_added_ones_are() -> None:
    network = cube()
    faces = network.cycles
    without = find_cycles(bare(network), banned=[faces[0]])
    assert keys(without.cycles) == keys(faces[1:])
    assert len(without.once) == 4
    # The outline of three faces at a corner, which nobody would take for a patch.
    corner = [cycle for cycle in faces if 0 in network.walk(cycle)]
    once = {c for c in range(12) if sum(c in cycle.curves for cycle in corner) == 1}
    outline = around(network, once)
    assert len(outline.steps) == 6
    added = find_cycles(bare(network), added=[outline])
    assert outline.key in keys(added.cycles)
    count = np.zeros(12, int)
    for cycle in added.cycles:
        count[list(cycle.curves)] += 1
    assert count.max() <= 2


def around(network: CurveNetwork, curves: set[int]) -> Cycle:
    """The closed walk along curves that meet two by two."""
    walk = [(min(curves), False)]
    while len(walk) < len(curves):
        node = network.ends(walk[-1])[1]
        rest = curves - {curve for curve, _ in walk}
        steps = [(c, backward) for c in sorted(rest) for backward in (False, True)]
        walk.append(next(step for step in steps if network.ends(step)[0] == node))
    return Cycle(tuple(walk))


def test_added_and_banned_cycles_must_go_together() -> None:
    network = cube()
    face = network.cycles[0]
    with pytest.raises(InvalidNetworkError, match="both added and banned"):
        find_cycles(network, added=[face], banned=[face.turned])
    with pytest.raises(InvalidNetworkError, match="breaks"):
        find_cycles(network, added=[Cycle(((0, False), (1, False), (2, False)))])


def test_dangling_curves_bound_nothing_and_are_told() -> None:
    network = cube()
    far = np.array([[3.0, 3, 3], [4, 3, 3]])
    nodes = np.concatenate([network.nodes, far])
    lead = Curve(np.array([network.nodes[7], far[0]]), (7, 8), "lead", "lead")
    tip = Curve(far, (8, 9), "tip", "tip")
    found = find_cycles(CurveNetwork((*network.curves, lead, tip), nodes))
    assert keys(found.cycles) == keys(network.cycles)
    assert found.dangling == (12, 13)
    assert any("dangle" in note for note in found.notes)


def test_small_networks_have_what_closes() -> None:
    assert find_cycles(CurveNetwork((), np.zeros((0, 3)))).cycles == ()
    t = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    circle = ring(np.c_[np.cos(t), np.sin(t), 0 * t])
    assert keys(find_cycles(bare(circle)).cycles) == keys(circle.cycles)
    ends = np.array([[0.0, 0, 0], [1, 0, 0]])
    bow = Curve(np.array([[0.0, 0, 0], [0.5, 0.5, 0], [1, 0, 0]]), (0, 1), "bow", "bow")
    string = Curve(ends, (0, 1), "string", "string")
    (digon,) = find_cycles(CurveNetwork((bow, string), ends)).cycles
    assert set(digon.curves) == {0, 1}
    one, other = cube(), cube()
    shift = np.array([5.0, 0, 0])
    moved = other.nodes + shift
    curves = tuple(
        Curve(c.points + shift, (c.nodes[0] + 8, c.nodes[1] + 8), f"b{c.id}", f"b{c.id}")
        for c in other.curves
    )
    both = find_cycles(CurveNetwork((*one.curves, *curves), np.concatenate([one.nodes, moved])))
    assert len(both.cycles) == 12


def strip(degrees: float, height: float, *, middle: bool = False) -> CurveNetwork:
    """The four curves around a piece of a cylinder of radius 1; and the line in its middle."""
    t = np.linspace(0.0, np.radians(degrees), 33)
    low = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    high = np.add(low, [0.0, 0.0, height])
    joins = [np.array([low[i], high[i]]) for i in ((0, 16, 32) if middle else (0, 32))]
    halves = [curve[part] for curve in (low, high) for part in (slice(17), slice(16, 33))]
    return network_of_polylines([*(halves if middle else [low, high]), *joins])


@pytest.mark.parametrize("degrees", [90, 180, 270, 330])
@pytest.mark.parametrize("height", [0.1, 1.0, 3.0])
def test_a_lone_loop_is_a_cycle_however_it_bends(degrees: float, height: float) -> None:
    network = strip(degrees, height)
    (cycle,) = find_cycles(network).cycles
    assert set(cycle.curves) == set(range(len(network.curves)))
    assert find_cycles(network, banned=[cycle]).cycles == ()


@pytest.mark.parametrize("degrees", [90, 180, 270])
@pytest.mark.parametrize("height", [0.5, 1.0, 3.0])
def test_strips_that_hang_together_are_cycles_where_nothing_else_is(
    degrees: float, height: float
) -> None:
    network = strip(degrees, height)
    lines = [curve.points for curve in network.curves]
    shift = [0.0, 0.0, height]
    both = network_of_polylines([*lines, *(line + shift for line in lines[1:])])
    found = find_cycles(both)
    # Where the strips are long, what is left open is closed by a sixth side, too.
    sizes = sorted(len(cycle.curves) for cycle in found.cycles)
    assert sizes in ([4, 4], [4, 4, 6])


def test_what_is_not_taken_is_told_with_its_curves() -> None:
    network = strip(180, 1.0, middle=True)
    found = find_cycles(network, worst=0.0)
    missed = found.nearest_miss
    assert found.cycles == () and missed is not None and missed.badness > 0.0
    told = missed.tell(network)
    names = ",".join(map(str, network.names(missed.cycle)))
    assert names in told and "most allowed is 0" in told and told in found.notes
    kept = find_cycles(network, worst=0.0, added=[missed.cycle])
    assert keys(kept.cycles) == {missed.cycle.key}


def test_two_bent_curves_on_one_another_enclose_nothing() -> None:
    t = np.linspace(0.0, 2.0, 20)
    arc = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    nodes = arc[[0, -1]]
    same = CurveNetwork((Curve(arc, (0, 1), 1, 1), Curve(arc[::-1], (1, 0), 2, 2)), nodes)
    assert find_cycles(same).cycles == ()
    other = np.column_stack([np.cos(t), np.sin(t), 0.3 * np.sin(t * np.pi / 2)])
    other[-1] = arc[-1]
    apart = CurveNetwork((Curve(arc, (0, 1), 1, 1), Curve(other[::-1], (1, 0), 2, 2)), nodes)
    assert len(find_cycles(apart).cycles) == 1
