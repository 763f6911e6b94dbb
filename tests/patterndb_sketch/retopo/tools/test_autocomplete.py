"""The autocompletion tool in a network on the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Network, check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.autocomplete import (
    autocomplete,
    find_completions,
)
from patterndb_sketch.retopo.tools.closing import close_patch, find_boundaries
from tests.support.retopo.boundaries import same_corners
from tests.support.retopo.planes import SIZES, corners_of, plane_surface, polygons
from tests.support.shared import EXAMPLES

UP = (0.0, 0.0, 1.0)

#: The tolerance of the cases: two samples, and what the parameterisation is off.
NEAR = 0.11

LOW = [(-3.0, -3.0, True), (3.0, -3.0, True), (3.0, 0.0, True), (-3.0, 0.0, True)]
POST = [(-0.5, -3.0, True), (0.5, -3.0, True), (0.5, 0.0, True), (-0.5, 0.0, True)]
WALL = [(-3.0, 0.0, True), (0.0, 0.0, True), (0.0, 3.0, True), (-3.0, 3.0, True)]
OTHER_WALL = [(0.5, 0.0, True), (3.0, 0.0, True), (3.0, 3.0, True), (0.5, 3.0, True)]
ROOF = [(-3.0, 1.5, True), (3.0, 1.5, True), (3.0, 4.0, True), (-3.0, 4.0, True)]
HANGING = [(-0.6, 1.5, True), (0.6, 1.5, True), (0.6, 4.0, True), (-0.6, 4.0, True)]


@pytest.mark.parametrize(
    ("drawn", "cursor", "case", "corners", "curves"),
    [
        ([LOW], (0, 0), "a", [(-1, 0), (1, 0), (1, 2), (-1, 2)], 3),
        ([POST], (0, 0), "c", [(-0.5, 0), (0.5, 0), (0.5, 1), (-0.5, 1)], 3),
        ([LOW, ROOF], (0, 0), "i", [(-1, 0), (1, 0), (1, 1.5), (-1, 1.5)], 2),
        ([POST, HANGING], (0, 0), "k", [(-0.5, 0), (0.5, 0), (0.6, 1.5), (-0.6, 1.5)], 2),
        ([POST, ROOF], (0, 0), "j", [(-0.5, 0), (0.5, 0), (0.5, 1.5), (-0.5, 1.5)], 2),
    ],
)
def test_a_suggestion_becomes_a_patch(
    drawn: list[list[tuple[float, float, bool]]],
    cursor: tuple[float, float],
    case: str,
    corners: list[tuple[float, float]],
    curves: int,
) -> None:
    before = polygons(*drawn)
    found = find_completions(before, plane_surface(), (*cursor, 0.0), UP, SIZES)
    assert found[0].case == case
    assert len(found[0].curves(SIZES)) == curves
    edit = close_patch(before, found[0], SIZES)
    check_network(edit.network)
    assert len(edit.network.patches) == len(before.patches) + 1
    assert any(
        same_corners(corners_of(edit.network, p), corners, NEAR) for p in edit.network.patches
    )
    assert np.allclose(
        np.sort(found[0].corners()[:, 0]), np.sort([c[0] for c in corners]), atol=NEAR
    )


def test_between_two_patches_at_a_corner_the_gap_is_filled() -> None:
    # Two walls on a floor leave a notch with two sharp corners, where three patches meet twice.
    floor = [(-3.0, -3.0, True), (3.0, -3.0, True), (3.0, 0.0, True), (-3.0, 0.0, True)]
    network = polygons(floor)
    network = _with(network, WALL)
    network = _with(network, OTHER_WALL)
    check_network(network)
    edit = autocomplete(network, plane_surface(), (0.25, 0.05, 0.0), UP, SIZES)
    check_network(edit.network)
    assert len(edit.network.patches) == 4
    assert any(
        same_corners(corners_of(edit.network, p), [(0, 0), (0.5, 0), (0.5, 2), (0, 2)], NEAR)
        for p in edit.network.patches
    )


def _with(network: Network, polygon: list[tuple[float, float, bool]]) -> Network:
    """The network with three strokes that make a patch on the floor y = 0."""
    from patterndb_sketch.retopo.network import (
        AtChain,
        AtNode,
        NetworkBuilder,
        find_nearest_place,
        take_samples,
    )
    from tests.support.retopo.planes import line, up

    (x0, _, _), (x1, _, _), _, (_, y1, _) = polygon
    builder = NetworkBuilder(network)
    corners = []
    for x in (x0, x1):
        place = find_nearest_place(take_samples(network), (x, 0.0, 0.0), UP, 0.1)
        assert place is not None
        corners.append(builder.end_node(AtChain(place.chain, place.place), *([np.zeros(3)] * 2)))
    points = line((x1, 0.0), (x1, y1), (x0, y1), (x0, 0.0))
    builder.add_chain(points, up(points), AtNode(corners[1]), AtNode(corners[0]))
    return builder.finish()


def test_nothing_far_from_all_patches_and_no_more_choices_than_there_are() -> None:
    network = polygons(LOW)
    far = (0.0, 1.1 * SIZES.autocompletion, 0.0)
    assert find_completions(network, plane_surface(), far, UP, SIZES) == []
    with pytest.raises(RefusedError, match="nothing can be completed"):
        autocomplete(network, plane_surface(), far, UP, SIZES)
    # Within the patch the brush reaches its border, but that is free on the other side.
    within = (0.0, -2.0 * SIZES.snap, 0.0)
    assert find_completions(network, plane_surface(), within, UP, SIZES) == []
    count = len(find_completions(network, plane_surface(), (0.0, 0.1, 0.0), UP, SIZES))
    with pytest.raises(RefusedError, match=f"there are {count}"):
        autocomplete(network, plane_surface(), (0.0, 0.1, 0.0), UP, SIZES, choice=count)


def test_all_choices_make_sound_networks() -> None:
    network = polygons(LOW, ROOF)
    for one in find_completions(network, plane_surface(), (0.4, 0.1, 0.0), UP, SIZES):
        edit = close_patch(network, one, SIZES)
        check_network(edit.network)
        assert len(edit.network.patches) == 3


def test_completing_again_and_again_grows_a_row() -> None:
    network = polygons(POST)
    for y in (0.0, 1.0, 2.0, 3.0):
        network = autocomplete(network, plane_surface(), (0.0, y, 0.0), UP, SIZES).network
        check_network(network)
    assert len(network.patches) == 5
    tops = [corners_of(network, p)[:, 1].max() for p in network.patches]
    assert np.allclose(sorted(tops), [0, 1, 2, 3, 4], atol=NEAR)


@pytest.mark.parametrize("half", [0.6, 1.0, 1.5], ids=["small", "middle", "large"])
@pytest.mark.parametrize("name", ["jug", "ball of 80"])
def test_all_around_a_square_on_coarse_triangles_something_is_suggested(
    name: str, half: float
) -> None:
    """Beside every stretch of all four sides, wherever triangles are large against the radius."""
    if name == "jug":
        surface = Surface.from_polygons(read_mesh(EXAMPLES / "jug.obj")).orient()
        middle, down = np.array([0.0, -6.5, 5.0]), np.array([0.0, 0.0, -1.0])
    else:
        surface = Surface.of(trimesh.creation.icosphere(subdivisions=1, radius=12.0)).orient()
        middle, down = np.array([0.0, -12.0, 0.0]), np.array([0.0, 0.0, -1.0])
    sizes = replace(Sizes.of(surface.diagonal), spine=half, snap=0.3 * half)
    with patterndb.open() as source:
        editor = Retopology(surface, source, sizes)
        line = [(middle + t * half * down).tolist() for t in (-1.0, 0.0, 1.0)]
        outcome = editor.do(Call("spine", {"points": line}))
        assert outcome.changed, outcome.refused
        network = editor.network
    (edge,) = find_boundaries(network)
    for k in range(0, len(edge.points), 5):
        step = edge.points[(k + 1) % len(edge.points)] - edge.points[k]
        aside = np.cross(edge.normals[k], step / np.linalg.norm(step))
        foot = surface.nearest((edge.points[k] + 0.3 * sizes.snap * aside)[None])
        found = find_completions(network, surface, foot.points[0], foot.normals[0], sizes)
        assert found, edge.points[k]
        edit = close_patch(network, found[0], sizes)
        check_network(edit.network)
        assert len(edit.network.patches) == 2


def example(name: str) -> Surface:
    """A mesh of the examples."""
    mesh = read_mesh(EXAMPLES / name)
    faces = np.split(mesh.corners, mesh.offsets[1:-1])
    fans = [[f[0], f[k], f[k + 1]] for f in faces for k in range(1, len(f) - 1)]
    return Surface.from_arrays(mesh.points, np.array(fans)).orient()


def ball() -> Surface:
    """A round ball of 5,120 triangles."""
    made = trimesh.creation.icosphere(subdivisions=4)
    return Surface.from_arrays(np.array(made.vertices), np.array(made.faces)).orient()


@pytest.mark.parametrize("side", [0.6, 1.2, 3.0])
@pytest.mark.parametrize("surface", ["plane", "ball", "jug.obj", "head.obj"])
def test_something_can_be_closed_beside_every_straight_side(surface: str, side: float) -> None:
    """Squares at random places, as wide as so many radii of the brush: from next to each side to
    where the brush just reaches it there is a suggestion, and the first can be taken."""
    made = {"plane": lambda: plane_surface(spacing=0.5), "ball": ball}
    on = made[surface]() if surface in made else example(surface)
    rng, asked = np.random.default_rng(7), 0
    with patterndb.open() as source:
        for _ in range(3):
            editor = Retopology(on, source)
            sizes, network = editor.state.sizes, editor.network
            corners, middle, up = square_somewhere(on, 0.5 * side * sizes.autocompletion, rng)
            lines = [
                lay(on, a + np.linspace(0.0, 1.0, 25)[:, None] * (b - a), up)
                for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
            ]
            for line in lines:
                assert editor.do(Call("stroke", {"points": line.tolist()})).refused is None
            if len(editor.network.patches) != 1:
                continue
            network, free = editor.network, find_boundaries(editor.network)
            for line in lines:
                out = line[12] - middle
                out /= np.linalg.norm(out)
                for share in (0.1, 0.5, 0.9):
                    aimed = line[12] + share * sizes.autocompletion * out
                    point = lay(on, aimed[None], on.nearest(line[12:13]).normals[0])[0]
                    normal = on.nearest(point[None]).normals[0]
                    beside = np.linalg.norm(
                        point - np.concatenate([e.points for e in free]), axis=1
                    )
                    if beside.min() > 0.95 * sizes.autocompletion or is_on_border(on, line[12]):
                        continue
                    found = find_completions(network, on, point, normal, sizes)
                    assert found, f"{share} radii beside {line[12]}"
                    check_network(close_patch(network, found[0], sizes).network)
                    asked += 1
    assert asked > 10


def lay(surface: Surface, points: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Points (n, 3) laid on the surface where it looks the way of ``up``: walls may be thin."""
    return surface.nearest_facing(points, np.tile(up, (len(points), 1))).points


def square_somewhere(
    surface: Surface, half: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(4, 3) corners, counter-clockwise, (3,) the middle, and what is up there; well within the
    surface."""
    while True:
        triangle = surface.triangles[rng.integers(len(surface.triangles))]
        foot = surface.nearest(surface.vertices[triangle].mean(axis=0)[None])
        middle, up = foot.points[0], foot.normals[0]
        across = np.cross(up, rng.normal(size=3))
        across *= half / np.linalg.norm(across)
        along = np.cross(up, across)
        corners = middle + np.array(
            [-across - along, across - along, across + along, along - across]
        )
        feet = lay(surface, corners, up)
        flat = float(np.linalg.norm(feet - corners, axis=1).max()) < 0.5 * half
        if flat and not any(is_on_border(surface, foot) for foot in feet):
            return feet, middle, up


def is_on_border(surface: Surface, point: np.ndarray) -> bool:
    """Is a point where the surface ends, or nearly?"""
    edges = np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    rim = surface.vertices[unique[count == 1]].mean(axis=1)
    near = 0.1 * surface.diagonal
    return bool(len(rim)) and float(np.linalg.norm(rim - point, axis=1).min()) < near
