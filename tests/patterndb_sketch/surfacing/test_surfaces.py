"""Whole networks: patches that share their vertices, each by a method that is named."""

from __future__ import annotations

import math

import numpy as np
import pytest

import patterndb
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.surfacing import find_cycles, network_of_polylines
from patterndb_sketch.surfacing.patch import Surfacing, as_triangles
from patterndb_sketch.surfacing.surfaces import (
    STAGES_KEPT,
    LoopMemory,
    SurfaceRequest,
    find_start,
    surface,
    turn_loop,
)
from patterndb_sketch.surfacing.tessellation import area
from tests.support.surfacing.networks import cube, faces_network, prism, ring, shuffled, torus


def half_edges(faces: np.ndarray) -> list[tuple[int, int]]:
    return [
        (int(face[i]), int(face[(i + 1) % len(face)])) for face in faces for i in range(len(face))
    ]


def is_disk(faces: np.ndarray) -> bool:
    """Consistently turned, every edge in at most two faces, one boundary, Euler sum 1."""
    directed = half_edges(faces)
    known = set(directed)
    if len(known) != len(directed):
        return False
    edges = {frozenset(edge) for edge in directed}
    rim = {a: b for a, b in directed if (b, a) not in known}
    start = next(iter(rim))
    around, at = 1, rim[start]
    while at != start:
        at = rim[at]
        around += 1
    vertices = len({v for edge in directed for v in edge})
    return around == len(rim) and vertices - len(edges) + len(faces) == 1


def is_watertight(surfacing: Surfacing) -> bool:
    """Does every edge lie between two faces that turn the same way?"""
    pieces = [piece for patch in surfacing.patches for piece in patch.faces]
    directed = [edge for piece in pieces for edge in half_edges(piece)]
    known = set(directed)
    return len(known) == len(directed) and all((b, a) in known for a, b in directed)


@pytest.fixture(scope="module")
def db() -> patterndb.Database:
    return patterndb.open(None)


@pytest.mark.parametrize("method", ["chords", "area", "smooth", "quads"])
@pytest.mark.parametrize(("network", "euler"), [(cube(), 2), (prism(), 2), (torus(), 0)])
def test_closed_networks_have_closed_surfaces(
    network: CurveNetwork, euler: int, method: str, db: patterndb.Database
) -> None:
    made = surface(network, method=method, db=db)
    assert [patch.method for patch in made.patches] == [method] * len(network.cycles)
    assert all(patch.note == "" for patch in made.patches)
    assert is_watertight(made)
    for patch in made.patches:
        assert all(is_disk(piece) for piece in patch.faces)
        assert is_disk(as_triangles(patch.faces))
    triangles = made.triangles
    edges = {frozenset(edge) for edge in half_edges(triangles)}
    assert len(np.unique(triangles)) - len(edges) + len(triangles) == euler
    # Flat faces of straight edges: nothing passes through anything.
    assert made.intersections == 0
    assert made.area == pytest.approx(area(made.points, triangles), rel=1e-9)


def test_the_result_does_not_depend_on_how_the_network_is_handed_over() -> None:
    network = torus()
    plain = surface(network)
    for seed in range(3):
        other = shuffled(network, seed)
        made = surface(other)
        by_names = {frozenset(other.names(p.cycle)): p for p in made.patches}
        for patch in plain.patches:
            twin = by_names[frozenset(network.names(patch.cycle))]
            assert patch.surface is not None
            assert twin.surface is not None
            assert twin.surface.area == pytest.approx(patch.surface.area, rel=1e-9)
            assert twin.surface.cost == pytest.approx(patch.surface.cost, abs=1e-9, nan_ok=True)
            assert len(twin.chords) == len(patch.chords)
            assert twin.surface.n_subproblems == patch.surface.n_subproblems


def test_triangles_and_quads_have_the_same_vertices_on_the_curves(db: patterndb.Database) -> None:
    network = cube()
    quads = surface(network, method="quads", db=db)
    # The same counts, forced by one patch of quads: vertices of the curves are the same.
    some = {network.cycles[0]: "quads"}
    mixed = surface(network, methods=some, spacing=quads.sampling.spacing, db=db)
    n = len(quads.sampling.points)
    assert np.array_equal(quads.sampling.points, mixed.sampling.points)
    assert [patch.method for patch in mixed.patches] == ["quads"] + ["smooth"] * 5
    assert is_watertight(mixed)
    for patch, other in zip(quads.patches, mixed.patches, strict=True):
        on_curves = [np.unique(as_triangles(p.faces)) for p in (patch, other)]
        assert np.array_equal(*(v[v < n] for v in on_curves))


def test_loops_met_before_are_not_surfaced_again() -> None:
    memory = LoopMemory()
    network = cube()
    first = surface(network, memory=memory)
    assert not any(patch.reused for patch in first.patches)
    again = surface(shuffled(network, 1), memory=memory)
    assert all(patch.reused for patch in again.patches)
    assert again.area == pytest.approx(first.area)
    other = surface(network, alpha=0.5, memory=memory)
    assert not any(patch.reused for patch in other.patches)


def test_loops_long_unmet_are_forgotten() -> None:
    memory = LoopMemory()
    surface(cube(), memory=memory)
    known = len(memory)
    for _ in range(STAGES_KEPT):
        memory.end_stage()
    assert len(memory) == known
    memory.end_stage()
    assert len(memory) == 0


def test_a_cycle_that_cannot_be_surfaced_has_a_note_and_spares_the_others() -> None:
    # A curve there and a straight one back, on the same line: too few vertices to enclose.
    points = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    network = CurveNetwork.from_edges(points, [[0, 1], [1, 2], [2, 3], [3, 0], [0, 1]])
    from patterndb_sketch.curvenetwork.network import Cycle

    square = Cycle(tuple((i, False) for i in range(4)))
    sliver = Cycle(((0, False), (4, True)))
    made = surface(network, [square, sliver], spacing=2.0)
    assert made.patches[0].method == "smooth"
    assert made.patches[1].method is None
    assert made.patches[1].faces == ()
    assert "encloses nothing" in made.patches[1].note


def test_a_search_too_large_is_answered_by_the_least_area() -> None:
    t = np.linspace(0, 2 * math.pi, 60, endpoint=False)
    wavy = np.c_[3 * np.cos(t), np.sin(t), np.sin(4 * t)]
    network = ring(wavy)
    options = SurfaceRequest(method="chords", area_price=math.inf, max_subproblems=3)
    (patch,) = surface(network, request=options).patches
    assert patch.method == "area"
    assert "3 sub-problems" in patch.note
    (patch,) = surface(network, method="chords").patches
    assert patch.method == "chords"
    assert patch.note == ""


def test_a_flat_loop_stays_within_its_outline() -> None:
    # A comb, of which a grid would leave the gaps between the teeth covered.
    teeth = [(x, y) for k in range(4) for x, y in ((k, 1), (k, 4), (k + 0.5, 4), (k + 0.5, 1))]
    outline = np.array([(0, 0), *teeth, (4, 1), (4, 0)], np.float64)
    network = ring(np.c_[outline, np.zeros(len(outline))])
    (patch,) = surface(network).patches
    x, y = outline[:, 0], outline[:, 1]
    around = abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) / 2
    assert patch.method == "smooth"
    assert patch.surface is not None and patch.surface.self_intersections == 0
    assert patch.surface.area == pytest.approx(around, rel=1e-9)


def test_slips_are_refused() -> None:
    network = cube()
    bare = CurveNetwork(network.curves, network.nodes)
    with pytest.raises(InvalidNetworkError, match="no cycles"):
        surface(bare)
    with pytest.raises(InvalidNetworkError, match="pattern database"):
        surface(network, method="quads")
    with pytest.raises(InvalidNetworkError, match="spacing"):
        surface(network, spacing=0.0)
    with pytest.raises(InvalidNetworkError, match="alpha"):
        SurfaceRequest(alpha=-1)
    with pytest.raises(InvalidNetworkError, match="method"):
        SurfaceRequest(method="lofting")  # pyright: ignore[reportArgumentType]


def test_a_loop_is_walked_by_convention() -> None:
    from patterndb_sketch.surfacing.sampling import (
        loop_of,
        sample,
    )

    network = ring([[0, 0, 0], [2, 0, 1], [2, 2, 0], [0, 2, 3]])
    loop = loop_of(network, sample(network), network.cycles[0])
    upright = turn_loop(loop, *find_start(loop.points))
    for k in (0, 3, 7):
        for backward in (False, True):
            moved = turn_loop(loop, k, backward)
            same = turn_loop(moved, *find_start(moved.points))
            assert np.array_equal(same.points, upright.points)
            assert np.array_equal(same.corners, upright.corners)
            assert np.array_equal(same.vertices, upright.vertices)


def test_patches_that_pass_through_each_other_are_told_by_pair() -> None:
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    upright = square[:, [0, 2, 1]] * 0.5
    aside = upright + np.array([0.1, 0.0, 5.0])
    points = np.concatenate([square, upright, aside, aside[:, [1, 0, 2]] + [0.1, -0.1, 0.0]])
    made = surface(faces_network(points, [[4 * k + i for i in range(4)] for k in range(4)]))
    assert {(i, j) for i, j, _ in made.crossings} == {(0, 1), (2, 3)}
    assert [n for _, _, n in made.crossings] == sorted(
        (n for *_, n in made.crossings), reverse=True
    )
    assert made.intersections == sum(n for _, _, n in made.crossings) > 0


@pytest.mark.parametrize("method", ["smooth", "quads"])
def test_a_lone_loop_is_followed_as_closely_as_four_quarters(
    method: str, db: patterndb.Database
) -> None:
    """The number of edges of a median curve is one for a quarter circle."""
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    loop = np.stack([np.cos(turn), np.sin(turn), 0.2 * np.cos(2.0 * turn)], axis=1)
    loop[-1] = loop[0]
    network = network_of_polylines([loop])
    made = surface(network, find_cycles(network).cycles, method=method, db=db)
    rim = made.points[np.linalg.norm(made.points[:, :2], axis=1) > 0.999]
    assert len(rim) >= 4 * (12 if method == "smooth" else 4)
