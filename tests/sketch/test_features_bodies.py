"""Car-like bodies: clean ones are closed and carry their features, messy ones keep the outside."""

from __future__ import annotations

import dataclasses
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import KDTree

from query.placing.surface import Surface
from query.polyline import arc_length
from sketch.features.bodies import (
    BOXES,
    CARS,
    COMPONENTS,
    CORNERS,
    EXTERIOR,
    INTERIOR,
    SURFACE,
    Body,
    Car,
    body,
    degrade,
    random_body,
    random_car,
    stroke,
)
from sketch.features.bodies.body import shape
from sketch.features.bodies.clutter import exterior_parts, interior_parts
from sketch.features.bodies.coons import unit
from sketch.features.bodies.rounding import Ridge, rounded
from sketch.features.errors import InvalidFeatureError

Points = NDArray[np.float64]

#: Resolution of the bodies that all tests share.
COARSE = 0.5

#: Shape by shape: the named ones, and some that lie between them.
NAMES = [*CARS, "random 0"]


@cache
def made(name: str, whole: bool = False) -> Body:
    if name.startswith("random"):
        return random_body(int(name.split()[1]), COARSE, whole)
    return body(name, COARSE, whole)


def directed(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)


def winding(surface: Body, points: Points) -> Points:
    """How often a closed body winds around points: 1 inside, 0 outside."""
    corners = [surface.points[surface.triangles[:, k]] for k in range(3)]
    result = np.zeros(len(points))
    for i, point in enumerate(points):
        a, b, c = (corner - point for corner in corners)
        la, lb, lc = (np.linalg.norm(one, axis=1) for one in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        low = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        result[i] = np.arctan2(top, low).sum() / (2.0 * np.pi)
    return result


@pytest.mark.parametrize("name", NAMES)
def test_a_half_is_open_in_the_middle_plane_alone(name: str) -> None:
    """Manifold and consistently oriented: every directed edge once, its twin unless y = 0."""
    half = made(name)
    edges = directed(half.faces)
    assert len(np.unique(edges, axis=0)) == len(edges)
    there = {tuple(edge) for edge in edges.tolist()}
    border = np.array([edge for edge in there if edge[::-1] not in there])
    assert np.all(half.points[border, 1] == 0.0)
    starts, ends = np.sort(border[:, 0]), np.sort(border[:, 1])
    assert np.array_equal(starts, np.unique(starts)) and np.array_equal(starts, ends)
    assert half.points[:, 1].max() == 0.0
    # One component, with the Euler number of a disk.
    undirected = np.unique(np.sort(edges, axis=1), axis=0)
    assert len(half.points) - len(undirected) + len(half.faces) == 1


@pytest.mark.parametrize("name", NAMES)
def test_a_whole_is_a_sphere_that_encloses_its_inside(name: str) -> None:
    whole, half = made(name, True), made(name)
    edges = directed(whole.faces)
    there = {tuple(edge) for edge in edges.tolist()}
    assert len(there) == len(edges) and all(edge[::-1] in there for edge in there)
    assert len(whole.points) - len(edges) // 2 + len(whole.faces) == 2
    a, b, c = (whole.points[whole.triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 > 3.0
    centre = np.array([[half.car.wheelbase / 2, 0.0, half.car.clearance]])
    assert np.allclose(winding(whole, centre), 1.0)
    assert np.array_equal(np.sort(np.abs(whole.points[:, 1])), np.sort(np.abs(
        np.r_[half.points[:, 1], half.points[half.points[:, 1] < 0, 1]])))  # fmt: skip
    assert set(np.unique(half.components)) == set(range(len(COMPONENTS)))


@pytest.mark.parametrize("name", NAMES)
def test_features_run_along_edges_of_the_clean_mesh(name: str) -> None:
    half = made(name)
    tree = KDTree(half.points)
    edges = {tuple(edge) for edge in np.sort(directed(half.faces), axis=1).tolist()}
    for curve in half.features:
        if curve.kind == "hidden":
            continue
        apart, ids = tree.query(curve.points)
        assert np.max(apart) < 1e-6 * half.diagonal, curve.name
        chain: list[int] = np.asarray(ids).tolist()
        assert all(tuple(sorted(pair)) in edges for pair in pairwise(chain)), curve.name
        # The chords of the mesh are those of the smooth curve.
        sagitta = KDTree(curve.smooth).query(curve.points)[0]
        spacing = np.linalg.norm(np.diff(curve.smooth, axis=0), axis=1).max()
        assert np.max(sagitta) <= 0.51 * spacing


@pytest.mark.parametrize("name", NAMES)
def test_dihedral_angles_are_greatest_on_creases_and_ridges(name: str) -> None:
    """The turn across an edge of a feature beats that across the mesh's next edges."""
    half = made(name)
    points, faces = half.points, half.faces
    flat = np.cross(points[faces[:, 2]] - points[faces[:, 0]],
                    points[faces[:, 3]] - points[faces[:, 1]])  # fmt: skip
    normals = unit(flat)
    owner = {tuple(edge): i // 4 for i, edge in enumerate(directed(faces).tolist())}
    tree = KDTree(points)

    def turn(a: int, b: int) -> float:
        return float(np.arccos(np.clip(normals[a] @ normals[b], -1.0, 1.0)))

    for curve in half.features:
        if curve.kind not in ("crease", "round", "arch"):
            continue
        ids: list[int] = np.asarray(tree.query(curve.points)[1]).tolist()
        for edge in pairwise(ids):
            left, right = owner[edge], owner[edge[::-1]]
            here = turn(left, right)
            for face, (start, _) in ((left, edge), (right, edge[::-1])):
                corners = faces[face].tolist()
                k = corners.index(start)
                across = (corners[(k + 3) % 4], corners[(k + 2) % 4])
                if across in owner:
                    assert here > turn(face, owner[across]), curve.name


def section(ridge: Ridge, ridges: dict[int, list[Ridge]], k: int) -> tuple[Points, Points]:
    """The finished surfaces across a ridge at its sample k: distances and heights."""
    along = np.gradient(ridge.points, axis=0)
    tangent = along[k] / np.linalg.norm(along[k])
    normal = ridge.bisector[k]
    across = np.cross(tangent, normal)
    parts: list[Points] = []
    reach = slice(max(0, k - 500), k + 500)
    offsets = ridge.points[reach] - ridge.points[k]
    for side in ridge.sides:
        at = side.path(ridge.parameters[k : k + 1])
        lead = side.radial * (at - side.inward) if side.radial else side.inward[None]
        dp, dq = side.surface.slopes(np.clip(at, 0.0, 1.0))
        run = (lead[:, :1] * dp + lead[:, 1:] * dq)[0]
        speed = np.linalg.norm(run - (run @ tangent) * tangent)
        steps = np.linspace(0.0, 3.0 * ridge.widths[k], 61)[:, None] / speed
        surface = side.surface
        points = rounded(surface, surface(at + steps * lead), ridges[id(surface)])
        points -= ridge.points[k]
        # Slide along the curve into the plane across it.
        drift = points @ tangent
        shift = [np.interp(drift, offsets @ tangent, offsets @ way) for way in (across, normal)]
        parts.append(np.stack([points @ across - shift[0], points @ normal - shift[1]], axis=1))
    line = np.concatenate([parts[0][::-1], parts[1][1:]])
    line = line[np.argsort(line[:, 0])]
    return line[:, 0], line[:, 1]


@pytest.mark.parametrize("name", ["sedan", "van"])
def test_curvature_across_a_ridge_is_greatest_on_the_curve(name: str) -> None:
    """Within 0.15 of the rounding's width, that is 2 mm and 0.05 % of the diagonal; and the
    radius is the one that is told, within 10 %."""
    made_of = shape(CARS[name])
    ridges = {id(one): made_of.ridges(one) for one in made_of.outline.surfaces.values()}
    seen = 0
    for line in made_of.lines:
        if line.ridge is None or not line.ridge.widths.any():
            continue
        ridge = line.ridge
        widest = ridge.widths >= 0.99 * ridge.widths.max()
        for k in np.flatnonzero(widest)[60:-60:300]:
            x, y = section(ridge, ridges, int(k))
            slope = np.gradient(y, x)
            curvature = np.abs(np.gradient(slope, x)) / (1.0 + slope**2) ** 1.5
            best = 3 + int(np.argmax(curvature[3:-3]))
            assert abs(x[best]) < 0.15 * ridge.widths[k], line.name
            assert abs(ridge.radius()[k] * curvature[60] - 1.0) < 0.1, line.name
            seen += 1
    assert seen > 25


@pytest.mark.parametrize("name", NAMES)
def test_every_edge_turns_the_same_way_all_along(name: str) -> None:
    """By six degrees or more: so every feature can be found on every body."""
    signs = {"windscreen_base": -1.0, "rear_window_base": -1.0, "belt_line": -1.0}
    signs |= {"front_inner_arch": -1.0, "rear_inner_arch": -1.0}
    for line in shape(made(name).car).lines:
        if line.ridge is not None:
            turn = 2.0 * np.degrees(np.arcsin(np.clip(line.ridge.sines, -1.0, 1.0)))
            assert (signs.get(line.name, 1.0) * turn).min() > 6.0, line.name


@pytest.mark.parametrize("name", NAMES)
def test_network_endpoints_coincide(name: str) -> None:
    """Curves meet in the corners, edges run from corner to corner, and faces close."""
    half = made(name)
    curves = {one.name: one for one in half.features}
    for corner in CORNERS:
        at = half.corners[corner.name]
        first, *others = (curves[one].points for one in corner.curves)
        assert np.linalg.norm(first[[0, -1]] - at, axis=1).min() < 1e-9
        for other in others:
            assert np.linalg.norm(other - at, axis=1).min() < 2e-6, (corner.name, corner.curves)
    for box in BOXES:
        for edge in box.edges:
            chain = [curves[one].points for one in edge.curves]
            for one, two in pairwise(chain):
                assert np.linalg.norm(one[-1] - two[0]) < 2e-6
            line = np.concatenate(chain)
            start, end = (
                int(np.argmin(np.linalg.norm(line - half.corners[which], axis=1)))
                for which in (edge.start, edge.end)
            )
            assert start < end, edge
            assert np.linalg.norm(line[[start, end]] - [half.corners[edge.start],
                                  half.corners[edge.end]]) < 4e-6  # fmt: skip


def test_the_boxes_are_boxes_without_their_open_faces() -> None:
    assert [box.component for box in BOXES] == list(COMPONENTS)
    used = [name for box in BOXES for edge in box.edges for name in edge.curves]
    named = {curve.name for curve in made("sedan").features}
    assert set(used) == named
    for box in BOXES:
        assert len(box.faces) + len(box.open) == 6
        ends = [frozenset((edge.start, edge.end)) for edge in box.edges]
        assert len(set(ends)) == len(ends)
        assert len(frozenset().union(*ends)) == 8
        sides = [
            frozenset((a, b))
            for face in box.faces
            for a, b in pairwise([*face.corners, face.corners[0]])
        ]
        assert set(sides) == set(ends)
        assert all(sides.count(end) <= 2 for end in ends)
        # Two that share an edge pass it in opposite senses.
        directed = [
            pair for face in box.faces for pair in pairwise([*face.corners, face.corners[0]])
        ]
        assert len(set(directed)) == len(directed)
        # An open face leaves out what no face has: edges with both faces open are left out.
        assert sum(sides.count(end) for end in ends) == 4 * len(box.faces)


@pytest.mark.parametrize("name", NAMES)
def test_box_faces_are_seen_from_outside(name: str) -> None:
    half = made(name)
    for box in BOXES:
        corners = {end for edge in box.edges for end in (edge.start, edge.end)}
        middle = np.mean([half.corners[one] for one in corners], axis=0)
        sign = -1.0 if box.component.endswith("wheelhouse") else 1.0
        for face in box.faces:
            a, b, c, d = (half.corners[one] for one in face.corners)
            out = np.cross(c - a, d - b) @ ((a + b + c + d) / 4.0 - middle)
            assert sign * out > 0.0, (box.component, face.name)


def test_all_bodies_have_one_network_and_no_two_are_alike() -> None:
    lists = [[(one.name, one.component) for one in made(name).features] for name in NAMES]
    assert all(one == lists[0] for one in lists)
    assert len(CARS) == 13
    shapes = np.array([
        np.concatenate([made(name).corners[corner.name] for corner in CORNERS]) for name in NAMES
    ])  # fmt: skip
    apart = np.linalg.norm(shapes[:, None] - shapes[None], axis=2)
    assert apart[~np.eye(len(NAMES), dtype=bool)].min() > 0.1
    # No few of them explain the rest: a shape model has many directions.
    values = np.linalg.svd(shapes[:13] - shapes[:13].mean(axis=0), compute_uv=False) ** 2
    assert values[0] < 0.8 * values.sum() and (values > 1e-4 * values.sum()).sum() >= 8


def test_the_frame_is_the_papers() -> None:
    """Origin in the front axle, x to the tail, z up, the driver's half at y <= 0."""
    half = made("sedan")
    car = half.car
    low, high = half.points.min(axis=0), half.points.max(axis=0)
    assert np.isclose(low[0], -car.front_overhang, atol=0.13) and low[0] < 0.0
    assert np.isclose(high[0], car.wheelbase + car.rear_overhang, atol=0.13)
    assert np.isclose(-low[1], car.width / 2.0, atol=0.1) and high[1] == 0.0
    assert np.isclose(high[2], car.height - car.tyre_radius, atol=0.03)
    for house, centre in (("front", 0.0), ("rear", car.wheelbase)):
        arch = half.feature(f"{house}_arch").points[:, [0, 2]] - [centre, 0.0]
        assert np.allclose(np.linalg.norm(arch, axis=1), car.arch_radius, atol=1e-9)


def test_the_same_seed_gives_the_same_body() -> None:
    one, other = random_body(5, COARSE), random_body(6, COARSE)
    shape.cache_clear()
    two = random_body(5, COARSE)
    assert np.array_equal(one.points, two.points) and np.array_equal(one.faces, two.faces)
    assert random_car(5) == random_car(5) != random_car(6)
    assert not np.allclose(one.corners["roof_front_centre"], other.corners["roof_front_centre"])


def test_resolution_refines_the_same_shape() -> None:
    coarse, fine = body("coupe", 0.5), body("coupe", 1.8)
    assert len(fine.faces) > 10 * len(coarse.faces)
    for name, at in coarse.corners.items():
        assert np.allclose(at, fine.corners[name], atol=2e-6)
    assert 4_000 < len(body("coupe").triangles) < 9_000


def test_edges_may_be_sharp() -> None:
    kinds = {curve.name: curve.kind for curve in made("off-roader").features}
    assert kinds["roof_rail"] == "crease" and "round" not in kinds.values()
    assert made("sedan").feature("roof_rail").kind == "round"
    assert made("off-roader").feature("roof_rail").radius.max() == 0.0
    radius = made("sedan").feature("roof_rail").radius
    assert radius[0] == 0.0 and 0.01 < radius[len(radius) // 2] < 0.2


# Messy bodies.


def near(half: Body, points: Points) -> Points:
    """Distances of points to the clean body."""
    surface = Surface.from_arrays(half.points, half.triangles)
    return np.linalg.norm(surface.nearest(points).points - points, axis=1)


def sagitta(half: Body) -> float:
    """What edges of the clean mesh and of a patch may cut off, in metres."""
    return 0.0025 * half.diagonal


def test_without_faults_the_patches_are_the_clean_body() -> None:
    half = made("hatchback")
    mess = degrade(half, mirror=False)
    assert len(mess.triangles) == len(half.triangles)
    assert mess.parts.max() + 1 == len(half.patch_names)
    mine = np.sort(mess.points[mess.triangles].mean(axis=1), axis=0)
    clean = np.sort(half.points[half.triangles].mean(axis=1), axis=0)
    assert np.allclose(mine, clean, atol=1e-5)
    # No two patches share vertices.
    owners = np.full(len(mess.points), -1)
    for part in range(mess.parts.max() + 1):
        mine = np.unique(mess.triangles[mess.parts == part])
        assert (owners[mine] == -1).all()
        owners[mine] = part


def test_patches_meshed_on_their_own_do_not_meet_along_borders() -> None:
    half = made("hatchback")
    mess = degrade(half, 3, uneven=True, mirror=False)
    assert near(half, mess.points).max() < sagitta(half)
    vertices = [np.unique(mess.triangles[mess.parts == p]) for p in range(mess.parts.max() + 1)]
    tree = KDTree(mess.points)
    shared = sum(len(one) > 1 for one in tree.query_ball_point(mess.points, 1e-6))
    rail = half.feature("roof_rail").smooth
    along = KDTree(rail).query(mess.points)[0] < 0.01
    glass, roof = (half.patch_names.index(name) for name in ("glass", "roof"))
    counts = [int(along[vertices[part]].sum()) for part in (glass, roof)]
    assert counts[0] != counts[1] and min(counts) > 3
    assert shared < 0.1 * len(mess.points)


def test_gaps_end_patches_short_of_their_borders() -> None:
    half = made("wagon")
    mess = degrade(half, 1, gaps=0.004, mirror=False)
    gap = 0.004 * half.diagonal / 2.0
    clean = KDTree(half.points)
    lines = np.concatenate([
        clean.query(one.points)[0][:, None] * 0 + one.points
        for one in half.features if one.kind not in ("hidden", "profile", "seam")
    ])  # fmt: skip
    apart = KDTree(lines).query(mess.points)[0]
    assert apart.min() > 0.15 * gap
    assert near(half, mess.points).max() < sagitta(half) and mess.reach == 0.0
    area = _area(mess.points, mess.triangles)
    clean_area = _area(half.points, half.triangles)
    assert 0.85 * clean_area < area < 0.995 * clean_area


def test_crossings_reach_beyond_borders_by_no_more_than_told() -> None:
    half = made("wagon")
    mess = degrade(half, 1, crossings=0.006, mirror=False)
    apart = near(half, mess.points)
    assert apart.max() <= mess.reach + 1e-9
    assert apart.max() > 0.3 * 0.006 * half.diagonal
    assert _area(mess.points, mess.triangles) > 1.01 * _area(half.points, half.triangles)


def test_flips_turn_whole_patches() -> None:
    half = made("sedan")
    plain, turned = degrade(half, 4, mirror=False), degrade(half, 4, flips=0.5, mirror=False)
    assert not plain.flipped.any() and 0.2 < turned.flipped.mean() < 0.8
    flipped = turned.flipped[turned.parts]
    assert np.array_equal(turned.triangles[~flipped], plain.triangles[~flipped])
    assert np.array_equal(turned.triangles[flipped], plain.triangles[flipped][:, ::-1])
    assert degrade(half, 4, flips=1.0, mirror=False).flipped.all()


def test_cuts_make_more_patches_of_the_same_triangles() -> None:
    half = made("sedan")
    plain, cut = degrade(half, 2, mirror=False), degrade(half, 2, cuts=4, mirror=False)
    assert cut.parts.max() > 1.5 * plain.parts.max()
    mine, other = (np.sort(one.points[one.triangles].mean(axis=1), axis=0) for one in (plain, cut))
    assert np.allclose(mine, other, atol=1e-12)


def test_shuffled_triangles_are_the_same_soup() -> None:
    half = made("sedan")
    plain, soup = (degrade(half, 2, mirror=False, shuffle=on) for on in (False, True))
    assert np.array_equal(np.sort(soup.triangles.ravel()), np.arange(3 * len(soup.triangles)))
    keys = [
        sorted(tuple(map(tuple, sorted(t))) for t in one.points[one.triangles].tolist())
        for one in (plain, soup)
    ]
    assert keys[0] == keys[1]
    assert not np.array_equal(plain.parts, soup.parts)


def test_a_mirrored_mess_has_both_halves() -> None:
    half = made("sedan")
    one, both = degrade(half, 2, mirror=False), degrade(half, 2)
    assert len(both.triangles) == 2 * len(one.triangles)
    assert np.allclose(np.sort(both.points[:, 1]), np.sort(-both.points[:, 1]))
    a, b, c = (both.points[both.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    whole = made("sedan", True)
    a, b, c = (whole.points[whole.triangles[:, k]] for k in range(3))
    assert np.isclose(volume, np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)
    assert one.points[:, 1].max() == 0.0 < both.points[:, 1].max()


@pytest.mark.parametrize("name", NAMES)
def test_interior_clutter_is_inside_and_exterior_clutter_reaches_out(name: str) -> None:
    whole = made(name, True)
    inner = np.unique(np.concatenate([points for points, _ in interior_parts(whole)]), axis=0)
    chosen = np.random.default_rng(0).permutation(len(inner))[:25]
    boxes = inner[np.isin(np.round(inner[:, 1], 9), np.round(inner[chosen, 1], 9))][:25]
    assert winding(whole, np.r_[inner[chosen], boxes]).min() > 0.99
    outer = np.concatenate([points for points, _ in exterior_parts(whole)])
    assert near(whole, outer).max() > 0.1
    if name != "sedan":
        return
    plain = degrade(whole)
    for options, kind, points in (
        ({"interior": True}, INTERIOR, inner), ({"exterior": True}, EXTERIOR, outer)
    ):  # fmt: skip
        mess = degrade(whole, **options)
        assert set(np.unique(mess.kinds)) == {SURFACE, kind}
        assert np.array_equal(mess.triangles[mess.kinds == SURFACE], plain.triangles)
        clutter = mess.points[np.unique(mess.triangles[mess.kinds == kind])]
        both = np.r_[points, points * [1.0, -1.0, 1.0]]
        assert KDTree(both).query(clutter)[0].max() == 0.0


def test_everything_at_once_keeps_the_outside() -> None:
    whole = made("van", True)
    mess = degrade(
        whole, 7, uneven=True, cuts=3, gaps=0.002, crossings=0.004, flips=0.4, interior=True,
        exterior=True, shuffle=True,
    )  # fmt: skip
    skin = mess.triangles[mess.kinds == SURFACE]
    used = np.unique(mess.points[skin].reshape(-1, 3), axis=0)
    assert near(whole, used).max() < mess.reach + sagitta(whole)
    # Nowhere is more than the gaps and an edge missing.
    covered = Surface.from_arrays(mess.points, skin)
    missing = np.linalg.norm(covered.nearest(whole.points).points - whole.points, axis=1)
    assert missing.max() < 2.0 * 0.002 * whole.diagonal + sagitta(whole)
    assert 100 <= mess.parts.max() + 1 <= 300
    again = degrade(
        whole, 7, uneven=True, cuts=3, gaps=0.002, crossings=0.004, flips=0.4, interior=True,
        exterior=True, shuffle=True,
    )  # fmt: skip
    assert np.array_equal(mess.points, again.points)


def _area(points: Points, triangles: NDArray[np.int64]) -> float:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


# Strokes.


@pytest.mark.parametrize("error", [0.0, 0.01, 0.03])
def test_strokes_lie_on_the_body_near_their_feature(error: float) -> None:
    half = made("suv")
    for seed, curve in enumerate(half.features):
        if curve.kind == "hidden":
            continue
        drawn = stroke(half, curve.name, error, seed)
        assert 4 <= len(drawn) <= 8
        assert near(half, drawn).max() < 1e-9
        tree = KDTree(curve.smooth)
        apart, foot = tree.query(drawn)
        spacing = np.linalg.norm(np.diff(curve.smooth, axis=0), axis=1).max()
        assert np.max(apart) <= 2.0 * error * half.diagonal + spacing + sagitta(half)
        if error == 0.0:
            total = arc_length(curve.smooth)
            assert np.all(np.diff(total[foot]) > 0.05 * total[-1])
        assert np.array_equal(drawn, stroke(half, curve.name, error, seed))


# What cannot be.


def test_errors_name_what_is_wrong() -> None:
    half = made("sedan")
    with pytest.raises(InvalidFeatureError, match="no car 'tank'"):
        body("tank")
    with pytest.raises(InvalidFeatureError, match="resolution"):
        body("sedan", 0.0)
    with pytest.raises(InvalidFeatureError, match="no curve 'wing'"):
        half.feature("wing")
    with pytest.raises(InvalidFeatureError, match="hidden"):
        stroke(half, "cabin_profile")
    with pytest.raises(InvalidFeatureError, match="error"):
        stroke(half, "a_pillar", 0.5)
    for options in ({"cuts": 0}, {"flips": 1.5}, {"gaps": -0.1}, {"crossings": 0.5}):
        with pytest.raises(InvalidFeatureError):
            degrade(half, **options)  # pyright: ignore[reportArgumentType]
    for change in (
        {"roof_front": 3.0}, {"nose_height": 0.5}, {"front_overhang": 0.5}, {"edge": -1.0},
        {"height": 1.0}, {"clearance": 0.7}, {"rear_bow": 1.0},
    ):  # fmt: skip
        with pytest.raises(InvalidFeatureError):
            dataclasses.replace(Car(), **change)
