"""Ribs: the outer contour of clean meshes, its samples and normals, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import body, degrade
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.mapping import find_outermost
from patterndb_sketch.features.ribs import build_rib, build_ribs, slice_model
from tests.support.features.models import soup, sphere, together
from tests.support.features.ribs import ACROSS, BOX, BOX_FACES, bumpy, sound, to_polyline, torus


class TestCleanMeshes:
    def test_never_take_the_raster_path(self) -> None:
        rng = np.random.default_rng(2)
        for points, faces in (sphere(30, 60), torus(), bumpy(3), (BOX, BOX_FACES)):
            model = Surface.from_soup(PolygonMesh.from_faces(points, faces))
            feet = model.nearest(rng.normal(size=(60, 3)))
            a, b, c = model.corners[feet.triangles].transpose(1, 0, 2)
            tangents = np.cross(np.cross(b - a, c - a), rng.normal(size=(60, 3)))
            for radius in (None, 0.3 * model.diagonal, 2 * model.diagonal):
                for rib in build_ribs(model, (a + b + c) / 3, tangents, radius):
                    assert not rib.repaired and rib.away < 1e-6
                    sound(rib)

    def test_car_body(self) -> None:
        car = body("sedan", whole=True)
        model = Surface.from_soup(PolygonMesh.from_faces(car.points, car.triangles))
        for name in ("roof_rail", "shoulder", "front_arch"):
            line = car.feature(name).smooth[10:-10:10]
            ribs = build_ribs(model, line[1:-1], line[2:] - line[:-2])
            assert not any(rib.repaired for rib in ribs)
            for rib in ribs:
                sound(rib)


class TestNormals:
    def test_radial_on_a_sphere(self) -> None:
        """A cap of 1 in 600 edges, and the rest of the globe to close it."""
        height = np.r_[np.linspace(0.0, 0.3, 180)[1:], np.linspace(0.3, np.pi, 12)[1:-1]]
        turn = np.linspace(0, 2 * np.pi, 800, endpoint=False)
        h, t = np.meshgrid(height, turn, indexing="ij")
        points = np.stack([np.sin(h) * np.cos(t), np.sin(h) * np.sin(t), np.cos(h)], axis=2)
        rows, around = h.shape
        i = np.arange((rows - 1) * around)
        j = i - i % around + (i + 1) % around
        ring = np.arange(around)
        n = rows * around
        faces = np.concatenate([
            np.stack([i, j, i + around], 1), np.stack([j, j + around, i + around], 1),
            np.stack([ring, (ring + 1) % around, np.full(around, n)], 1),
            np.stack([n - around + ring, n - around + (ring + 1) % around,
                      np.full(around, n + 1)], 1),
        ])  # fmt: skip
        model = Surface.from_soup(
            PolygonMesh.from_faces(np.r_[points.reshape(-1, 3), [[0, 0, 1], [0, 0, -1.0]]], faces)
        )
        rib = build_rib(model, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        assert np.abs(rib.normals - rib.points).max() < 1e-3
        assert rib.backbone == 100
        sound(rib)

    @settings(max_examples=20)
    @given(st.integers(0, 2**32))
    def test_outward_on_closed_shapes(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        model = Surface.from_soup(PolygonMesh.from_faces(*bumpy(seed)))
        ways = rng.normal(size=(12, 3))
        outer, _ = find_outermost(model, np.zeros((12, 3)), ways)
        tangents = np.cross(ways, rng.normal(size=3))
        for rib in build_ribs(model, outer, tangents):
            assert np.einsum("ij,ij->i", rib.points, rib.normals).min() > 0.0
            step = np.diff(rib.points, axis=0)[rib.backbone % 200]
            assert np.cross(step, rib.axes[2]) @ rib.normals[rib.backbone] > 0.0
        closed = build_rib(model, outer[0], tangents[0], 5.0)
        assert closed.closed and np.allclose(closed.points[0], closed.points[-1])
        assert 95 <= closed.backbone <= 105

    def test_outward_on_a_box(self) -> None:
        model = Surface.from_soup(PolygonMesh.from_faces(BOX, BOX_FACES))
        for origin in ([0.4, 0.5, 1.0], [1.0, 0.5, 0.3], [1.0, 0.5, 1.0], [0.0, 0.5, 0.0]):
            for radius in (None, 0.3, 3.0):
                rib = build_rib(model, origin, ACROSS, radius)
                assert ((rib.points - 0.5) * rib.normals).sum(axis=1).min() > 0.0

    def test_of_inner_shells_and_open_halves(self) -> None:
        """Clutter inside and a missing floor do not turn the outside in."""
        points, faces = sphere(30, 60)
        upper = faces[points[faces][:, :, 2].mean(axis=1) > -0.2]
        inner = (0.7 * points, faces[::3])
        model = Surface.from_soup(PolygonMesh.from_faces(*together((points, upper), inner)))
        turn = np.linspace(0.2, 1.5, 40)
        ways = np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=1)
        origins, _ = find_outermost(model, np.zeros((40, 3)), ways)
        for rib in build_ribs(model, origins, np.gradient(origins, axis=0)):
            assert np.einsum("ij,ij->i", rib.points, rib.normals).min() > 0.0


class TestSamples:
    def test_equal_arc_length(self) -> None:
        model = Surface.from_soup(PolygonMesh.from_faces(*bumpy(5)))
        hit = find_outermost(model, np.zeros((1, 3)), np.array([[1.0, 2, 3]]))[0][0]
        for count in (2, 50, 201):
            rib = build_rib(model, hit, [1.0, 1.0, 0.0], samples=count)
            along = arc_length(rib.polygon)
            places = [
                along[k] + np.linalg.norm(p - rib.polygon[k])
                for p in rib.points
                for k in [int(np.argmin([to_polyline(p[None], rib.polygon[i : i + 2])[0]
                                         for i in range(len(rib.polygon) - 1)]))]
            ]  # fmt: skip
            assert places == pytest.approx(np.linspace(0, along[-1], count), abs=1e-9)
            sound(rib, count)

    def test_the_same_for_every_soup(self) -> None:
        """Shuffled, unoriented triangles of their own: bit by bit, raster path and all."""
        car = body("city car")
        mess = degrade(car, seed=3, gaps=0.001, crossings=0.003, interior=True, exterior=True)
        line = car.feature("shoulder").smooth[20:-20:20]
        model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
        ribs = build_ribs(model, line[1:-1], line[2:] - line[:-2])
        assert any(rib.repaired for rib in ribs)
        other = Surface.from_soup(PolygonMesh.from_faces(*soup(mess.points, mess.triangles, 4)))
        for one, two in zip(ribs, build_ribs(other, line[1:-1], line[2:] - line[:-2]), strict=True):
            assert one.points.tobytes() == two.points.tobytes()
            assert one.normals.tobytes() == two.normals.tobytes()
            assert one.backbone == two.backbone and one.rounds == two.rounds


class TestRefusals:
    def test_nothing_near(self) -> None:
        rib = build_rib(
            Surface.from_soup(PolygonMesh.from_faces(*sphere())), [9.0, 0, 0], [0, 0, 1.0]
        )
        assert len(rib) == 0 and rib.backbone == -1 and "nothing within" in rib.note

    def test_what_is_none(self) -> None:
        model = Surface.from_soup(PolygonMesh.from_faces(*sphere()))
        with pytest.raises(InvalidFeatureError, match="must have a length"):
            build_rib(model, [1.0, 0, 0], [0.0, 0, 0])
        with pytest.raises(InvalidFeatureError, match="above 0"):
            build_rib(model, [1.0, 0, 0], ACROSS, -1.0)
        with pytest.raises(InvalidFeatureError, match="above 0"):
            slice_model(model, [1.0, 0, 0], ACROSS, np.inf)
        with pytest.raises(InvalidFeatureError, match="2 origins and 1 tangents"):
            build_ribs(model, np.zeros((2, 3)), [ACROSS])
        with pytest.raises(InvalidFeatureError, match="at least 2 samples"):
            build_rib(model, [1.0, 0, 0], ACROSS, samples=1)
        with pytest.raises(InvalidFeatureError, match="rounds are 1 to 11"):
            build_rib(model, [1.0, 0, 0], ACROSS, rounds=12)
