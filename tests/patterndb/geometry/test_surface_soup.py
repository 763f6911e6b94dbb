"""Models of any quality: the same for every soup, and each query against all triangles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import read_mesh
from patterndb._native.geometry.triangulation import write_once
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.surface import Surface
from patterndb.geometry.triangulation import MOST_EXACT, SHORTER, cut_faces, triangulate_faces, weld
from patterndb_sketch.features.registration.mapping import find_outermost
from tests.support.features.drawnbodies import DRAWN, find_body
from tests.support.features.models import soup, sphere, sphere_model, to_model, together
from tests.support.shared import MESHES, SHARED, list_shared

#: Names of bodies that are drawn, and files of others where they are.
CARS = [
    Path("torn-sedan"),
    Path("coupe"),
    *list_shared(SHARED / "data" / "cad", "gclass_chrono.obj", "uazbus_chrono.obj"),
    *list_shared(MESHES, "q_car_sportscar.obj"),
]


def same(one: Surface, other: Surface) -> bool:
    """Bit by bit."""
    arrays = [(one.vertices, other.vertices), (one.triangles, other.triangles)]
    arrays += [(one.corners, other.corners), (one.components, other.components)]
    arrays += zip(one.boxes, other.boxes, strict=True)
    equal = all(a.dtype == b.dtype and a.tobytes() == b.tobytes() for a, b in arrays)
    return equal and one.diagonal == other.diagonal


def polygons(faces: list[list[int]], points: np.ndarray) -> PolygonMesh:
    offsets = np.r_[0, np.cumsum([len(face) for face in faces])].astype(np.int64)
    return PolygonMesh(points, np.array([v for f in faces for v in f], np.int32), offsets)


def random_triangles(seed: int, n: int = 60) -> np.ndarray:
    """(n, 3, 3) triangles on a coarse lattice: needles, points, and many that touch."""
    rng = np.random.default_rng(seed)
    return rng.integers(-4, 5, (n, 1, 3)) + rng.integers(-2, 3, (n, 3, 3)) / 2.0


def of_corners(corners: np.ndarray) -> Surface:
    return Surface.from_soup(
        PolygonMesh.from_faces(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    )


class TestSoup:
    """The shuffled, unoriented triangle soup of a mesh is the mesh."""

    @pytest.mark.parametrize("path", CARS, ids=lambda path: path.stem)
    def test_of_a_car(self, path: Path) -> None:
        mesh = read_mesh(find_body(path.name, ".obj") if path.name in DRAWN else path)
        model = Surface.from_soup(mesh)
        apart = Surface.from_soup(PolygonMesh.from_faces(*soup(model.vertices, model.triangles, 1)))
        assert same(model, apart)
        assert (apart.repairs.dropped, apart.repairs.repeated) == (0, 0)
        # The faces themselves shuffled, turned and flipped, on points of their own.
        rng = np.random.default_rng(2)
        places, faces = [], []
        for f in rng.permutation(mesh.n_faces):
            face = np.roll(mesh.corners[mesh.offsets[f] : mesh.offsets[f + 1]], rng.integers(9))
            faces.append([*range(len(places), len(places) + len(face))])
            places += list(mesh.points[face[:: rng.choice([-1, 1])]])
        assert same(model, Surface.from_soup(polygons(faces, np.array(places))))

    def test_answers_are_the_same(self) -> None:
        model = Surface.from_soup(read_mesh(find_body("torn-sedan", ".obj")))
        apart = Surface.from_soup(PolygonMesh.from_faces(*soup(model.vertices, model.triangles, 3)))
        rng = np.random.default_rng(4)
        asked, way = rng.normal(size=(50, 3)), rng.normal(size=(50, 3))
        for one, other in (
            (model.nearest(asked), apart.nearest(asked)),
            (model.cast_rays(asked, way), apart.cast_rays(asked, way)),
            (model.cast_lines(asked, way)[1], apart.cast_lines(asked, way)[1]),
        ):
            assert one.points.tobytes() == other.points.tobytes()
            assert (one.triangles == other.triangles).all()

    @settings(max_examples=40)
    @given(st.integers(0, 2**32))
    def test_of_anything(self, seed: int) -> None:
        corners = random_triangles(seed)
        model = of_corners(corners)
        points, faces = soup(corners.reshape(-1, 3), np.arange(len(corners) * 3).reshape(-1, 3), 5)
        apart = Surface.from_soup(PolygonMesh.from_faces(points, faces))
        assert same(model, apart)
        left_out = model.repairs.dropped, model.repairs.repeated
        assert left_out == (apart.repairs.dropped, apart.repairs.repeated)
        n = len(model.triangles) + sum(left_out)
        assert n == len(corners)


class TestWelding:
    @settings(max_examples=60)
    @given(st.integers(0, 2**32), st.integers(1, 40))
    def test_against_all_pairs(self, seed: int, n: int) -> None:
        rng = np.random.default_rng(seed)
        points = rng.integers(0, 3, (n, 3)) + rng.integers(-1, 2, (n, 3)) * 0.7e-3
        places, place = weld(points, 1e-3)
        # Sets of points, merged as long as two of them are close.
        sets = [{i} for i in range(n)]
        for i in range(n):
            for j in range(i):
                if np.linalg.norm(points[i] - points[j]) <= 1e-3 and sets[i] is not sets[j]:
                    sets[i] |= sets[j]
                    for k in sets[j]:
                        sets[k] = sets[i]
        for i in range(n):
            assert {j for j in range(n) if place[j] == place[i]} == sets[i]
            assert tuple(places[place[i]]) == min(tuple(points[j]) for j in sets[i])
        assert [tuple(p) for p in places] == sorted({tuple(p) for p in places})

    def test_nearly_the_same_place_is_the_same(self) -> None:
        points, faces = sphere()
        exact = Surface.from_soup(PolygonMesh.from_faces(points, faces))
        apart, alone = soup(points, faces, 6)
        shaken = apart + 1e-10 * np.random.default_rng(7).uniform(-1, 1, apart.shape)
        loose = Surface.from_soup(PolygonMesh.from_faces(shaken, alone))
        assert len(loose.vertices) == len(points)
        assert loose.n_components == 1
        assert np.abs(loose.vertices[:, None] - exact.vertices).max(axis=2).min(axis=1).max() < 1e-9
        zero = Surface.from_soup(
            PolygonMesh.from_faces([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        )
        minus = Surface.from_soup(
            PolygonMesh.from_faces([[-0.0, -0.0, 0], [1, -0.0, 0], [0, 1, 0]], [[0, 1, 2]])
        )
        assert same(zero, minus)


def all_cuts(face: tuple[int, ...]) -> Iterator[list[tuple[int, int, int]]]:
    """All ways to cut a face into triangles."""
    if len(face) < 3:
        yield []
        return
    for k in range(1, len(face) - 1):
        for left in all_cuts(face[: k + 1]):
            for right in all_cuts(face[k:]):
                yield [*left, (face[0], face[k], face[-1]), *right]


def cost(points: np.ndarray, a: int, b: int, c: int) -> float:
    u, v = points[b] - points[a], points[c] - points[a]
    edges = u @ u + v @ v + (u - v) @ (u - v)
    return float(np.linalg.norm(np.cross(u, v)) / 2.0 + SHORTER * edges)


class TestTriangulating:
    @settings(max_examples=60)
    @given(st.integers(0, 2**32), st.integers(4, 8))
    def test_is_the_least_of_all(self, seed: int, n: int) -> None:
        points = np.random.default_rng(seed).normal(size=(n, 3))
        points = points[np.lexsort(points.T[::-1])]
        order = np.random.default_rng(seed + 1).permutation(n)
        found, dropped = triangulate_faces(points, order, np.array([0, n]))
        assert dropped == 0 and len(found) == n - 2
        least = min(sum(cost(points, *t) for t in cut) for cut in all_cuts(tuple(order.tolist())))
        assert sum(cost(points, *t) for t in found) == pytest.approx(least, rel=1e-12)

    @settings(max_examples=60)
    @given(st.integers(0, 2**32), st.integers(4, 60))
    def test_concave_faces_are_covered_once(self, seed: int, n: int) -> None:
        rng = np.random.default_rng(seed)
        turn = 2.0 * np.pi * (np.arange(n) + rng.uniform(0.0, 0.5, n)) / n
        reach = rng.uniform(0.2, 1.0, n)
        flat = np.stack([reach * np.cos(turn), reach * np.sin(turn)], axis=1)
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        model = Surface.from_soup(polygons([[*range(n)]], flat @ axes[:2]))
        u = model.corners[:, 1] - model.corners[:, 0]
        v = model.corners[:, 2] - model.corners[:, 0]
        x, y = flat.T
        area = 0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
        assert np.linalg.norm(np.cross(u, v), axis=1).sum() / 2.0 == pytest.approx(area, rel=1e-4)
        assert len(model.triangles) == n - 2

    def test_shorter_diagonals_of_a_flat_face_win(self) -> None:
        points = np.array([[0.0, 0, 0], [3, 0, 0], [4, 1, 0], [1, 1, 0]])
        model = Surface.from_soup(polygons([[0, 1, 2, 3]], points))
        assert [0, 0, 0] in model.vertices.tolist() and len(model.triangles) == 2
        shared = set(model.triangles[0].tolist()) & set(model.triangles[1].tolist())
        ends = {tuple(model.vertices[v]) for v in shared}
        assert ends == {(3.0, 0.0, 0.0), (1.0, 1.0, 0.0)}

    def test_what_is_left_out_is_counted(self) -> None:
        points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [5, 5, 5]])
        faces = [[0, 1, 2, 3], [3, 2, 1, 0], [0, 1], [0, 0, 1], [0, 1, 4]]
        model = Surface.from_soup(polygons(faces, points))
        assert (model.repairs.dropped, model.repairs.repeated) == (2, 2)
        # The triangle without area stays; the point that no face has does not.
        assert len(model.triangles) == 3 and len(model.vertices) == 5
        assert model.diagonal == math.sqrt(5.0)

    @settings(max_examples=30)
    @given(st.integers(0, 2**32), st.integers(MOST_EXACT + 1, 600), st.booleans())
    def test_large_concave_faces_are_covered_once(self, seed: int, n: int, flip: bool) -> None:
        rng = np.random.default_rng(seed)
        turn = 2.0 * np.pi * (np.arange(n) + rng.uniform(0.0, 0.5, n)) / n
        reach = rng.uniform(0.2, 1.0, n)
        x, y = reach * np.cos(turn), reach * np.sin(turn)
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        face = [*range(n)][:: -1 if flip else 1]
        mesh = polygons([face], np.stack([x, y], axis=1) @ axes[:2])
        triangles, _ = cut_faces(mesh)
        corners = mesh.points[triangles]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
        area = 0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
        # Counter-clockwise all, as the face, so that areas without a sign add up to its own.
        assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(area, rel=1e-6)
        assert np.linalg.norm(areas.sum(axis=0)) == pytest.approx(area, rel=1e-6)
        assert sorted(map(sorted, edges_once(triangles))) == sorted(map(sorted, pairs_of(face)))
        turned = polygons([np.roll(face[::-1], 7).tolist()], mesh.points)
        one, two = Surface.from_soup(mesh), Surface.from_soup(turned)
        assert (one.triangles == two.triangles).all() and (one.vertices == two.vertices).all()

    def test_an_outline_with_a_bridge_to_its_hole_is_covered_once(self) -> None:
        n = 400
        turn = 2.0 * np.pi * np.arange(n) / n
        ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
        points = np.concatenate([2.0 * ring, ring])
        face = [*range(n), 0, n, *range(2 * n - 1, n - 1, -1)]
        triangles, _ = cut_faces(polygons([face], points))
        corners = points[triangles]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2.0
        assert areas.min() > -1e-12
        assert areas.sum() == pytest.approx(1.5 * n * math.sin(2.0 * math.pi / n), rel=1e-9)

    def test_no_number_of_corners_is_too_large(self) -> None:
        n = 100_000
        turn = 2.0 * np.pi * np.arange(n) / n
        gear = 1.0 + 0.01 * (np.arange(n) // 2 % 2)
        points = np.stack([gear * np.cos(turn), gear * np.sin(turn), 0.0 * turn], axis=1)
        triangles, face = cut_faces(polygons([[*range(n)]], points))
        assert len(triangles) == n - 2 and not face.any()
        # No corner gathers a part of all triangles, as that of a fan does.
        assert np.bincount(triangles.ravel()).max() < 100

    def test_a_face_without_a_plane_or_that_crosses_itself_is_cut(self) -> None:
        n = 1000
        rng = np.random.default_rng(1)
        for points in (
            rng.normal(size=(n, 3)),
            np.zeros((n, 3)),
            np.outer(np.arange(n), [1.0, 2.0, 3.0]),
        ):
            triangles, _ = cut_faces(polygons([[*range(n)]], points))
            assert sorted(map(sorted, edges_once(triangles))) == sorted(
                map(sorted, pairs_of([*range(n)]))
            )

    def test_small_concave_faces_keep_their_sense_and_are_covered_once(self) -> None:
        points = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [3, 1, 0], [0, 1, 0]])
        for turn in range(5):
            face = np.roll(np.arange(5), turn).tolist()
            corners = points[cut_faces(polygons([face, face[::-1]], points))[0]]
            areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
            assert (areas[:3] > 0).all() and (areas[3:] < 0).all()
            assert areas[:3].sum() == -areas[3:].sum() == pytest.approx(5.5)

    @given(st.lists(st.integers(0, 3), min_size=1, max_size=12))
    def test_the_way_to_write_a_face_is_the_first_of_all(self, face: list[int]) -> None:
        n = len(face)
        ways = [np.roll(one, k).tolist() for one in (face, face[::-1]) for k in range(n)]
        assert write_once(np.array(face, np.int32)).tolist() == min(ways)


def pairs_of(face: list[int]) -> list[tuple[int, int]]:
    """The edges of a face."""
    return [*zip(face, [*face[1:], face[0]], strict=True)]


def edges_once(triangles: np.ndarray) -> list[tuple[int, int]]:
    """The edges that an odd number of triangles have."""
    found: set[tuple[int, int]] = set()
    for triangle in triangles.tolist():
        for a, b in pairs_of(triangle):
            found ^= {(min(a, b), max(a, b))}
    return [*found]


def hit_by(corners: np.ndarray, origin: np.ndarray, way: np.ndarray) -> list[tuple[float, int]]:
    """(how far, triangle) of all hits of a line, triangle by triangle, by Cramer's rule."""
    found = []
    for f, (a, b, c) in enumerate(corners):
        system = np.stack([b - a, c - a, -way], axis=1)
        if abs(np.linalg.det(system)) > 1e-12:
            v, w, s = np.linalg.solve(system, origin - a)
            if v >= 0 and w >= 0 and v + w <= 1:
                found.append((s, f))
    return sorted(found)


class TestQueries:
    @settings(max_examples=15)
    @given(st.integers(0, 2**32))
    def test_nearest_against_all_triangles(self, seed: int) -> None:
        model = of_corners(random_triangles(seed))
        rng = np.random.default_rng(seed + 1)
        asked = np.concatenate([rng.normal(size=(10, 3)) * 4.0, rng.integers(-4, 5, (10, 3))])
        feet = model.nearest(asked)
        off = model.measure_distances(asked)
        assert off == pytest.approx(to_model(asked, model.corners), abs=1e-12)
        assert np.linalg.norm(feet.points - asked, axis=1) == pytest.approx(off)
        own = [
            to_model(p[None], model.corners[[f]])[0]
            for p, f in zip(feet.points, feet.triangles, strict=True)
        ]
        assert max(own) < 1e-12

    def test_nearest_on_needles(self) -> None:
        rng = np.random.default_rng(8)
        for width in (1e-3, 1e-6, 1e-9, 1e-12, 0.0):
            flat = np.array([[0.0, 0, 0], [1, 0, 0], [0.3, width, 0]])
            axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            corners = (flat @ axes + rng.normal(size=3))[None]
            asked = rng.normal(size=(200, 3)) + corners[0, 0]
            model = of_corners(corners)
            off = model.measure_distances(asked)
            assert np.abs(off - to_model(asked, corners)).max() < 1e-9
            assert to_model(model.nearest(asked).points, corners).max() < 1e-14

    @settings(max_examples=20)
    @given(st.integers(0, 2**32))
    def test_lines_against_all_triangles(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        corners = rng.normal(size=(60, 1, 3)) + rng.normal(size=(60, 3, 3))
        model = of_corners(corners)
        origins = rng.normal(size=(30, 3))
        ways = rng.normal(size=(30, 3))
        ways[:3] = np.eye(3)
        units = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        offsets, hits = model.cast_lines(origins, ways)
        first = model.cast_rays(origins, ways)
        outer = find_outermost(model, origins, ways)
        for i in range(30):
            wanted = hit_by(model.corners, origins[i], units[i])
            mine = hits[offsets[i] : offsets[i + 1]]
            assert mine.triangles.tolist() == [f for _, f in wanted]
            assert mine.distances == pytest.approx([s for s, _ in wanted], abs=1e-9)
            ahead = [(s, f) for s, f in wanted if s >= 0]
            assert first.triangles[i] == (ahead[0][1] if ahead else -1)
            assert outer[1][i] == pytest.approx(wanted[-1][0] if wanted else np.inf)
            for points, lengths in ((first.points, first.distances), outer):
                if np.isfinite(lengths[i]):
                    along = origins[i] + lengths[i] * units[i]
                    assert points[i] == pytest.approx(along, abs=1e-9)
                else:
                    assert np.isnan(points[i]).all() and lengths[i] == np.inf

    def test_no_line_slips_through_an_edge_or_a_corner(self) -> None:
        points, faces = sphere()
        model = Surface.from_soup(PolygonMesh.from_faces(points, faces))
        rng = np.random.default_rng(9)
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
        share = rng.uniform(size=(len(edges), 1))
        share[::2] = 0.5
        aims = [points, (1 - share) * points[edges[:, 0]] + share * points[edges[:, 1]]]
        aim = np.concatenate(aims)
        for eye in ([0.0, 0, 0], [0.1, 0.2, -0.3], [0.0, 0, 0.5]):
            origins = np.broadcast_to(eye, aim.shape)
            hit = model.cast_rays(origins, aim - eye)
            assert hit.found.all()
            assert np.linalg.norm(hit.points - aim, axis=1).max() < 1e-12
            offsets, both = model.cast_lines(origins, aim - eye)
            before = np.minimum.reduceat(both.distances, offsets[:-1])
            after = np.maximum.reduceat(both.distances, offsets[:-1])
            assert (before < 0).all() and (after > 0).all()

    def test_from_far_away(self) -> None:
        points, faces = sphere()
        far = np.array([3e6, -2e6, 1e6])
        model = Surface.from_soup(PolygonMesh.from_faces(points, faces))
        hit = model.cast_rays(np.broadcast_to(far, points.shape), points - far)
        facing = points @ far > 0.4 * np.linalg.norm(far)
        assert facing.sum() > 50 and hit.found[facing].all()
        # Lengths have seven digits left there, places more.
        assert np.linalg.norm(hit.points - points, axis=1)[facing].max() < 1e-7

    def test_outermost_of_nested_spheres_is_the_outer(self) -> None:
        model = Surface.from_soup(
            PolygonMesh.from_faces(*together(sphere(radius=1.0), sphere(radius=0.6)))
        )
        rng = np.random.default_rng(10)
        ways = rng.normal(size=(200, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        for reach in (0.0, 0.5, 0.8, 1.7):  # inside, in between, and outside: gamma below 0
            points, lengths = find_outermost(model, reach * ways, ways)
            size = np.linalg.norm(points, axis=1)
            assert (size > 0.95).all()
            assert lengths == pytest.approx(size - reach, abs=1e-9)
        aside = find_outermost(model, np.array([[3.0, 0, 0]]), np.array([[0.0, 1, 0]]))
        assert np.isnan(aside[0]).all() and aside[1][0] == np.inf

    @settings(max_examples=15)
    @given(st.integers(0, 2**32))
    def test_components_are_what_points_connect(self, seed: int) -> None:
        model = of_corners(random_triangles(seed, 25))
        label = list(range(len(model.triangles)))
        for _ in label:
            for f, one in enumerate(model.triangles):
                for g, other in enumerate(model.triangles):
                    if set(one) & set(other):
                        label[f] = label[g] = min(label[f], label[g])
        first = sorted(set(label))
        assert model.components.tolist() == [first.index(k) for k in label]
        assert model.n_components == len(first)


class TestRefusals:
    def test_models(self) -> None:
        three = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
        for points, faces, what in (
            (three, np.zeros((0, 3), int), "no faces"),
            (three, [[0, 1, 3]], "outside 0..2"),
            (three, [[0, 1, 1]], "no triangle"),
            ([[0.0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "vertex 2 of the mesh"),
            (three, [[0.0, 1.0, 2.0]], "whole numbers"),
            ([[0.0, 0]], [[0, 0, 0]], r"\(v, 3\)"),
        ):
            with pytest.raises(InvalidMeshError, match=what):
                Surface.from_soup(PolygonMesh.from_faces(points, faces))

    def test_questions(self) -> None:
        model = sphere_model()
        with pytest.raises(InvalidMeshError, match="not finite"):
            model.nearest([[0.0, np.nan, 0]])
        with pytest.raises(InvalidMeshError, match="direction 1 has no length"):
            model.cast_rays(np.zeros((2, 3)), [[1.0, 0, 0], [0, 0, 0]])
        with pytest.raises(InvalidMeshError, match="2 origins and 1 directions"):
            model.cast_lines(np.zeros((2, 3)), [[1.0, 0, 0]])
