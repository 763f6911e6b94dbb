"""Flat caps, smooth fills, tension and n-gons."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ingest.formats import read_mesh
from patterndb._native.query.recognition import weld_quads
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.surface import Surface
from patterndb.system.documents import parse_json
from query import Stroke
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.holes import Hole, HoleFill, MeshTopology, fill_holes, find_holes, hole_of_faces
from query.holes.caps import RimPlane, find_cap, list_cap_quads
from query.holes.neighbourhood import extract_neighbourhood
from query.holes.options import SHAPES, HoleOptions, HoleRequest, Shape
from query.holes.projection import HoleProjector
from query.holes.symmetry import MOST_MIRRORS, find_mirrors
from tests.support.shared import CHECKOUT

HEAD = CHECKOUT / "docs" / "meshes" / "head.obj"

Profile = list[tuple[float, float]]

TUBE: Profile = [(1.0, 0.5 * k) for k in range(5)]


def turn_profile(n: int, profile: Profile) -> PolygonMesh:
    """The quads between circles of n points: (radius, height) of each."""
    around = 2 * np.pi * np.arange(n) / n
    circle = np.stack([np.cos(around), np.sin(around)], axis=1)
    points = np.concatenate([np.c_[r * circle, np.full(n, z)] for r, z in profile])
    faces = [
        [k * n + i, k * n + (i + 1) % n, (k + 1) * n + (i + 1) % n, (k + 1) * n + i]
        for k in range(len(profile) - 1)
        for i in range(n)
    ]
    return PolygonMesh.from_faces(points, faces)


def extrude(outline: list[tuple[float, float]], heights: list[float]) -> PolygonMesh:
    """The quads of walls over an outline."""
    n = len(outline)
    points = np.concatenate([np.c_[np.array(outline), np.full(n, z)] for z in heights])
    faces = [
        [k * n + i, k * n + (i + 1) % n, (k + 1) * n + (i + 1) % n, (k + 1) * n + i]
        for k in range(len(heights) - 1)
        for i in range(n)
    ]
    return PolygonMesh.from_faces(points, faces)


def outline_box(a: int, b: int) -> list[tuple[float, float]]:
    """A rectangle of a by b edges, from a corner."""
    corners = [(0, 0), (a, 0), (a, b), (0, b), (0, 0)]
    found: list[tuple[float, float]] = []
    for (x, y), (u, v) in pairwise(corners):
        n = abs(u - x) + abs(v - y)
        found += [(x + (u - x) * k / n, y + (v - y) * k / n) for k in range(n)]
    return found


def top_hole(mesh: PolygonMesh) -> Hole:
    return max(find_holes(mesh), key=lambda hole: hole.centre[2])


def sphere(n: int, rows: int, cut: int) -> PolygonMesh:
    """A ball of n columns, its south pole and the last ``cut`` rows left out."""
    angles = np.pi * np.arange(1, rows - cut + 1) / rows
    return turn_profile(n, [(float(np.sin(t)), float(-np.cos(t))) for t in angles])


CUBE = extrude([(0, 0), (1, 0), (1, 1), (0, 1)], [0.0, 1.0])
BOTTLE = turn_profile(
    16, [(1, 0), (1, 1), (0.95, 1.3), (0.8, 1.6), (0.55, 1.8), (0.4, 2), (0.35, 2.2), (0.35, 2.6)]
)
CONE = turn_profile(16, [(1.0, 0.0), (0.8, 0.3), (0.6, 0.6), (0.4, 0.9)])


@pytest.mark.parametrize(
    "mesh, flat",
    [
        (CUBE, True),
        (turn_profile(5, TUBE), True),
        (turn_profile(16, TUBE), True),
        (extrude(outline_box(4, 3), [0.0, 1.0, 2.0]), True),
        (BOTTLE, True),
        (CONE, True),
        (sphere(16, 12, 1), False),
        (sphere(16, 12, 3), False),
        (sphere(16, 12, 6), False),
        (sphere(32, 48, 4), False),
        (sphere(32, 48, 20), False),
    ],
    ids=["cube", "5", "tube", "lid", "bottle", "cone", "pole", "45", "half", "fine", "most"],
)
def test_caps_are_flat_and_balls_are_not(mesh: PolygonMesh, flat: bool) -> None:
    assert (find_cap(top_hole(mesh)) is not None) == flat


def test_holes_of_a_face_are_smooth() -> None:
    nose, cheek, neck = find_holes(read_mesh(HEAD))
    assert find_cap(nose) is None and find_cap(cheek) is None
    assert find_cap(nose, "flat") is not None and find_cap(neck, "smooth") is None
    # The neck is cut off in a plane.
    assert find_cap(neck) is not None


@pytest.mark.parametrize("shape", [(0.0, 0.0), (1.0, 0.0)], ids=["point", "slit"])
def test_boundaries_without_area_have_no_plane(
    source: PatternSource, shape: tuple[float, float]
) -> None:
    mesh = turn_profile(8, [(1.0, 0.0), (1.0, 1.0), (0.9, 2.0)])
    points = mesh.points.copy()
    points[16:, :2] *= shape
    hole = top_hole(PolygonMesh(points, mesh.corners, mesh.offsets))
    assert find_cap(hole) is None
    assert not next(fill_holes(source, hole, twins=False)).flat


def test_what_a_hole_replaces_decides_nothing() -> None:
    for lid in (0.0, 0.7):
        n = 8
        tube = turn_profile(n, TUBE)
        points = np.concatenate([tube.points, [[0.0, 0.0, 2.0 + lid]]])
        top = [4 * n + i for i in range(n)]
        fan = [[top[i], top[(i + 1) % n], top[(i + 2) % n], 5 * n] for i in range(0, n, 2)]
        mesh = PolygonMesh.from_faces(points, [*tube.faces(), *fan])
        removed = hole_of_faces(MeshTopology.of(mesh), range(4 * n, 4 * n + len(fan)))
        cap, other = find_cap(removed), find_cap(top_hole(tube))
        assert cap is not None and other is not None
        np.testing.assert_allclose(cap.plane.normal, other.plane.normal, atol=1e-12)


@pytest.mark.parametrize("n", [4, 6, 8, 10, 12, 16, 20, 32])
def test_a_round_cap_is_a_grid_then_rings(source: PatternSource, n: int) -> None:
    hole = top_hole(turn_profile(n, TUBE))
    fills = list(fill_holes(source, hole, limit=6, twins=False))
    a = n // 4
    grid = a * (n // 2 - a)
    expected = [grid]
    if n >= 8:
        expected.append(n + grid)
    if n > 8:
        expected.append(n + n // 2)
    if n >= 16:
        expected.append(2 * n + grid)
    assert [fill.n_quads for fill in fills][: len(expected)] == expected
    assert (fills[0].corners == 1).sum() == 4 and fills[0].n_irregular == 4
    for fill in fills:
        _, fault = weld_quads(fill.local, n + len(fill.points), n)
        assert not fault and fill.flat and not fill.flipped
        # Not a dome: the tube's radius is 1, its end at a height of 2.
        assert (fill.points[:, 2] == 2.0).all()
        assert (np.linalg.norm(fill.points[:, :2], axis=1) < 1.0).all()
        assert not find_holes(fill.weld())[1:]


@pytest.mark.parametrize("a, b", [(1, 1), (2, 1), (4, 3), (6, 1), (5, 5)])
def test_a_box_gets_its_own_corners(source: PatternSource, a: int, b: int) -> None:
    outline = outline_box(a, b)
    turned = outline[1:] + outline[:1]
    hole = top_hole(extrude(turned, [0.0, 1.0, 2.0]))
    fill = next(fill_holes(source, hole, twins=False))
    assert fill.n_quads == a * b
    at = hole.points[fill.corners == 1][:, :2].tolist()
    assert sorted(at) == sorted([[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]])
    new = {tuple(p) for p in np.round(fill.points, 6).tolist()}
    assert new == {(x, y, 2.0) for x in range(1, a) for y in range(1, b)}


def outline_cells(cells: set[tuple[int, int]]) -> list[tuple[float, float]]:
    """The boundary of unit squares that hang together, counter-clockwise."""
    ahead: dict[tuple[int, int], tuple[int, int]] = {}
    for x, y in cells:
        around = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        beyond = [(x, y - 1), (x + 1, y), (x, y + 1), (x - 1, y)]
        for i, cell in enumerate(beyond):
            if cell not in cells:
                ahead[around[i]] = around[(i + 1) % 4]
    found = [min(ahead)]
    while (following := ahead[found[-1]]) != found[0]:
        found.append(following)
    assert len(found) == len(ahead)
    return [(float(x), float(y)) for x, y in found]


@pytest.mark.parametrize(
    "rows",
    ["###.|###.|##..", "#####|..#..|..#..|..#..", ".#.|###|.#.", "#...|##..|###.|####", "#.#|###"],
    ids=["L", "T", "plus", "staircase", "U"],
)
def test_a_lid_that_turns_back_gets_its_own_corners(source: PatternSource, rows: str) -> None:
    cells = {(x, y) for y, row in enumerate(rows.split("|")) for x, c in enumerate(row) if c == "#"}
    hole = top_hole(extrude(outline_cells(cells), [0.0, 1.0, 2.0]))
    fill = next(fill_holes(source, hole, twins=False))
    corners = np.concatenate([hole.points, fill.points])[fill.local]
    assert {tuple(c) for c in np.floor(corners.mean(axis=1)[:, :2]).astype(int).tolist()} == cells
    assert fill.n_quads == len(cells) and fill.flat and not fill.flipped


@pytest.mark.parametrize(
    "stretch, slope, noise, n_quads",
    [(3, 0, 0.0, 16), (1, 0.5, 0.0, 9), (1, 0, 0.03, 9), (2, 1.0, 0.0, 0)],
    ids=["ellipse", "oblique", "uneven", "both"],
)
def test_a_cap_that_is_not_a_circle_is_a_grid(
    source: PatternSource, stretch: float, slope: float, noise: float, n_quads: int
) -> None:
    n = 16 if stretch == 3 else 12
    mesh = turn_profile(n, TUBE)
    points = mesh.points + noise * np.random.default_rng(1).normal(size=mesh.points.shape)
    points[:, 2] += np.where(points[:, 2] > 1.7, slope * points[:, 0], 0.0)
    hole = top_hole(PolygonMesh(points * [stretch, 1, 1], mesh.corners, mesh.offsets))
    fill = next(fill_holes(source, hole, twins=False))
    assert fill.flat and not fill.flipped and (fill.corners == 1).sum() == 4
    assert fill.n_quads == n_quads or not n_quads
    mirrors = find_mirrors(hole.points, extract_neighbourhood(hole).regular_valence)
    kept = [(fill.corners == fill.corners[(s - np.arange(n)) % n]).all() for s in mirrors.tolist()]
    assert any(kept) or not kept


def test_grids_are_for_four_corners() -> None:
    def list_for(outline: list[tuple[float, float]]) -> list[Any]:
        loop = np.c_[np.array(outline), np.zeros(len(outline))]
        return list_cap_quads(loop, RimPlane.of(loop), np.zeros(0, np.int32))

    def regular(sides: int, each: int) -> list[tuple[float, float]]:
        at = [(np.cos(t), np.sin(t)) for t in 2 * np.pi * np.arange(sides + 1) / sides]
        return [
            (p[0] + (q[0] - p[0]) * k / each, p[1] + (q[1] - p[1]) * k / each)
            for p, q in pairwise(at)
            for k in range(each)
        ]

    assert len(list_for(outline_box(3, 2))) == 1
    assert not list_for(regular(3, 2)) and not list_for(regular(5, 2))
    corner = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    assert not list_for(corner)


def test_flat_lies_in_the_plane_of_a_boundary_that_is_not(source: PatternSource) -> None:
    hole = find_holes(read_mesh(HEAD))[0]
    plane = RimPlane.of(hole.points)
    assert plane.off > 0.02
    for fill in fill_holes(source, hole, limit=4, shape="flat"):
        assert fill.flat and len(fill.points)
        np.testing.assert_allclose(plane.project(fill.points), fill.points, atol=1e-9)
        old = hole.topology.mesh.points
        assert fill.weld().points[: len(old)].tobytes() == old.tobytes()


def test_smooth_goes_on_and_tension_is_between(source: PatternSource) -> None:
    hole = top_hole(sphere(16, 12, 4))
    asked: dict[str, Any] = {"limit": 3, "twins": False}
    by_itself = list(fill_holes(source, hole, **asked))
    smooth = list(fill_holes(source, hole, shape="smooth", **asked))
    half = list(fill_holes(source, hole, tension=0.5, **asked))
    tight = list(fill_holes(source, hole, tension=1.0, **asked))
    rim = float(hole.points[:, 2].max())
    for a, b, c, d in zip(by_itself, smooth, half, tight, strict=True):
        assert not a.flat and (a.points == b.points).all() and (a.local == b.local).all()
        assert (c.local == a.local).all() and (d.local == a.local).all()
        np.testing.assert_allclose(c.points, (a.points + d.points) / 2, atol=1e-9)
        assert a.points[:, 2].max() > rim + 0.1
        check_membrane(d)


def check_membrane(fill: HoleFill) -> None:
    """Every new vertex lies at the mean of its neighbours."""
    n = len(fill.hole)
    vertices = np.vstack([fill.hole.points, fill.points])
    beside: list[set[int]] = [set() for _ in vertices]
    for quad in fill.local.tolist():
        for v, w in zip(quad, quad[1:] + quad[:1], strict=True):
            beside[v].add(w)
            beside[w].add(v)
    for v in range(n, len(vertices)):
        np.testing.assert_allclose(vertices[v], vertices[list(beside[v])].mean(axis=0), atol=1e-9)


def test_smooth_may_be_asked_of_a_tube(source: PatternSource) -> None:
    hole = top_hole(turn_profile(16, TUBE))
    fill = next(fill_holes(source, hole, shape="smooth", twins=False))
    assert not fill.flat and fill.points[:, 2].max() > 2.5


def test_mirror_images_lie_as_they_are_unless_one_chooses(source: PatternSource) -> None:
    n = 8
    tube = turn_profile(n, [(1.0, z) for z in (-1.0, -0.5, 0.0, 0.5, 1.0)])
    points = np.concatenate([tube.points, [[0.0, 0.0, -1.7]]])
    fan = [[(i + 2) % n, (i + 1) % n, i, 5 * n] for i in range(0, n, 2)]
    (hole,) = find_holes(PolygonMesh.from_faces(points, [*tube.faces(), *fan]))
    twin = next(fill_holes(source, hole))
    assert twin.twin and not twin.flat
    np.testing.assert_allclose(twin.points, [[0.0, 0.0, 1.7]], atol=1e-9)
    flat = next(fill_holes(source, hole, shape="flat"))
    assert flat.twin and flat.flat
    np.testing.assert_allclose(flat.points, [[0.0, 0.0, 1.0]], atol=1e-9)


def test_both_ends_of_a_tube_are_flat(source: PatternSource) -> None:
    first, second = find_holes(MeshTopology.of(turn_profile(12, TUBE)))
    one = next(fill_holes(source, first))
    two = next(fill_holes(source, second, like=[one]))
    assert two.twin and two.flat
    assert np.ptp(np.vstack([second.points, two.points])[:, 2]) < 1e-12


@pytest.mark.parametrize("n", [3, 4, 5, 12, 33])
def test_an_ngon_is_one_face(source: PatternSource, n: int) -> None:
    hole = top_hole(turn_profile(n, TUBE))
    (fill,) = fill_holes(source, hole, ngon=True)
    assert fill.ngon is not None and fill.ngon.tolist() == hole.loop.tolist()
    assert fill.n_faces == 1 and fill.n_quads == 0 and not len(fill.points)
    assert (fill.valences == 3).all()
    old, new = hole.topology.mesh, fill.weld()
    assert new.points.tobytes() == old.points.tobytes() and new.arities()[-1] == n
    assert [list(f) for f in new.faces()[:-1]] == [list(f) for f in old.faces()]
    after = MeshTopology.of(new)
    assert not after.flipped.any() and len(find_holes(after)) == 1
    document = fill.to_json()
    assert document["ngon"] == hole.loop.tolist() and document["score"] is None


def test_an_ngon_and_quads_are_welded_together(source: PatternSource) -> None:
    from query.holes import weld_fills

    first, second = find_holes(MeshTopology.of(turn_profile(8, TUBE)))
    ngon = next(fill_holes(source, first, ngon=True))
    quads = next(fill_holes(source, second, like=[ngon]))
    assert not quads.twin
    for order in ([ngon, quads], [quads, ngon]):
        new = weld_fills(order)
        assert not find_holes(new) and sorted(new.arities().tolist())[-2:] == [4, 8]


def test_an_ngon_needs_a_loop_that_runs_through_no_vertex_twice(source: PatternSource) -> None:
    points = [(x, y, 0.0) for y in range(5) for x in range(5)]
    without = {(1, 1), (2, 2)}
    faces = [
        [5 * y + x, 5 * y + x + 1, 5 * y + x + 6, 5 * y + x + 5]
        for y in range(4)
        for x in range(4)
        if (x, y) not in without
    ]
    mesh = PolygonMesh.from_faces(np.array(points), faces)
    hole = next(h for h in find_holes(mesh) if len(set(h.loop.tolist())) < len(h))
    with pytest.raises(InvalidQueryError, match="twice"):
        fill_holes(source, hole, ngon=True)


def test_what_contradicts_is_refused(source: PatternSource) -> None:
    hole = top_hole(turn_profile(8, TUBE))
    surface = Surface.from_polygons(CUBE)
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"shape": "round"}, "auto, flat, smooth"),
        ({"tension": -0.1}, "from 0 to 1"),
        ({"tension": 1.5}, "from 0 to 1"),
        ({"tension": float("nan")}, "from 0 to 1"),
        ({"shape": "flat", "tension": 0.5}, "no tension"),
        ({"shape": "flat", "surface": surface}, "surface"),
        ({"tension": 0.5, "surface": surface}, "surface"),
        ({"ngon": True, "tension": 0.5}, "no new vertices"),
        ({"ngon": True, "shape": "smooth"}, "no new vertices"),
        ({"ngon": True, "corners": {int(hole.loop[0]): 1}}, "no quads"),
        ({"ngon": True, "strokes": [Stroke.loop()]}, "no quads"),
        ({"ngon": True, "surface": surface}, "no quads"),
    ]
    for options, word in wrong:
        with pytest.raises(InvalidQueryError, match=word):
            fill_holes(source, hole, **options)


def test_a_request_is_read_from_json() -> None:
    read = parse_json(b'{"shape": "smooth", "tension": 1}', InvalidMeshError, "it").read(
        HoleRequest
    )
    assert read == HoleRequest(shape="smooth", tension=1.0)
    for text, word in (
        (b'{"shape": "round"}', '"auto" or "flat" or "smooth"'),
        (b'{"tension": 2}', "a number from 0 to 1"),
        (b'{"tension": 0.5, "shape": "flat"}', "no tension"),
    ):
        with pytest.raises(InvalidMeshError, match=word):
            parse_json(text, InvalidMeshError, "it").read(HoleRequest)
    assert HoleRequest().shape == next(iter(SHAPES)) and get_args(Shape) == tuple(SHAPES)


def test_corners_that_are_fixed_hold_in_caps(source: PatternSource) -> None:
    hole = top_hole(turn_profile(8, TUBE))
    fixed = {int(hole.loop[1]): 1, int(hole.loop[2]): 1}
    for fill in fill_holes(source, hole, corners=fixed, limit=3):
        assert fill.corners[1] == 1 and fill.corners[2] == 1 and fill.flat


def test_caps_follow_a_loop_without_faces_outside(source: PatternSource) -> None:
    mesh = turn_profile(12, [(1.0, 0.0), (0.5, 0.0)])
    hole = hole_of_faces(MeshTopology.of(mesh), range(1))
    assert (hole.edges < 0).any() and find_cap(hole) is not None
    assert next(fill_holes(source, hole)).n_quads >= 1


@settings(max_examples=30, deadline=None)
@given(
    st.integers(2, 10),
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.0, 0.03, 0.3]),
    st.sampled_from([1e-6, 1.0, 1e6]),
)
def test_moving_turning_and_scaling_change_nothing(
    half: int, seed: int, noise: float, scale: float
) -> None:
    draw = np.random.default_rng(seed)
    n = 2 * half
    profile = [TUBE, [(1.0 - 0.1 * k, 0.3 * k) for k in range(4)]][seed % 2]
    mesh = turn_profile(n, profile)
    points = mesh.points * [1.0 + draw.random(), 1.0, 1.0]
    points = points + noise * draw.normal(size=points.shape) / n
    turn = Rotation.from_quat(draw.normal(size=4))
    moved = scale * turn.apply(points) + scale * draw.normal(size=3)
    seen: list[tuple[bool, list[Any], list[NDArray[np.float64]]]] = []
    for at in (points, moved):
        hole = top_hole_of(PolygonMesh(at, mesh.corners, mesh.offsets), n * (len(profile) - 1))
        around, plane = extract_neighbourhood(hole), RimPlane.of(hole.points)
        listed = list_cap_quads(
            hole.points, plane, find_mirrors(hole.points, around.regular_valence)
        )
        projector = HoleProjector.of(hole, around, HoleOptions(shape="flat"))
        laid = [projector.place(quads, int(quads.max()) + 1)[0] for quads in listed]
        seen.append((find_cap(hole) is not None, [quads.tolist() for quads in listed], laid))
    assert seen[0][:2] == seen[1][:2]
    for before, after in zip(seen[0][2], seen[1][2], strict=True):
        expected = scale * turn.apply(before) + moved.mean(axis=0)
        expected -= scale * turn.apply(points).mean(axis=0) if len(before) else 0.0
        np.testing.assert_allclose(after, expected, atol=1e-6 * scale)


def top_hole_of(mesh: PolygonMesh, vertex: int) -> Hole:
    """The hole through a vertex."""
    return next(hole for hole in find_holes(mesh) if vertex in hole.loop)


@pytest.mark.parametrize("n", [8, 12, 16, 32])
@given(begin=st.floats(0.0, 1.0))
@settings(max_examples=20)
def test_a_round_boundary_has_the_same_mirrors_wherever_it_begins(n: int, begin: float) -> None:
    """Equally exact mirrors are not told apart by rounding: a square grid follows one of them."""
    angle = 2.0 * np.pi * (np.arange(n) + begin) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])
    mirrors = find_mirrors(ring, np.full(n, 2, np.int32)).tolist()
    assert mirrors == list(range(min(n, MOST_MIRRORS)))
    quarter = [0, n // 4, n // 2, 3 * n // 4]
    assert any(
        {(s - k - c) % n for c in quarter} == {(k + c) % n for c in quarter}
        for s in mirrors
        for k in range(n)
    )
