"""Slices of models by planes, and the segments that they are stitched to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.ribs import STITCH, build_rib, segments_of, slice_model
from tests.support.features.models import sphere
from tests.support.features.ribs import (
    ACROSS,
    BOX,
    BOX_FACES,
    arc,
    bumpy,
    sheets,
    slow_length,
    torus,
)


class TestSlices:
    def test_a_sphere_gives_a_circle(self) -> None:
        """Planar to 1e-9, and a circle as far as the mesh is a sphere."""
        model = Surface.from_soup(PolygonMesh.from_faces(*sphere(60, 120)))
        for normal in ([0.0, 0, 1], [1.0, 0, 0], [0.3, -0.5, 0.8]):
            cut = slice_model(model, [0.2, 0.1, 0.3], normal, 10.0)
            found = segments_of(cut, STITCH * model.diagonal)
            assert len(found) == 1 and found.closed[0]
            points = cut.in_space(found[0])
            unit = np.array(normal) / np.linalg.norm(normal)
            assert np.abs((points - [0.2, 0.1, 0.3]) @ unit).max() < 1e-9
            # Edges of the mesh are 0.075 long at most: that is their sagitta.
            assert np.abs(np.linalg.norm(points, axis=1) - 1.0).max() < 0.075**2 / 8
            height = unit @ [0.2, 0.1, 0.3]
            wanted = 2 * np.pi * np.sqrt(1 - height**2)
            assert arc_length(points)[-1] == pytest.approx(wanted, rel=2e-3)

    def test_what_is_farther_than_the_radius_is_dropped(self) -> None:
        model = Surface.from_soup(PolygonMesh.from_faces(*sphere(30, 60)))
        cut = slice_model(model, [1.0, 0, 0], [0, 0, 1.0])
        away = np.linalg.norm(cut.ends, axis=2)
        radius = 0.05 * model.diagonal
        assert away.max() == pytest.approx(radius, rel=1e-12)
        found = segments_of(cut, STITCH * model.diagonal)
        assert len(found) == 1 and found.rims.all() and not found.closed[0]

    def test_vertices_on_the_plane(self) -> None:
        """Cuts of closed meshes are closed, wherever their vertices are."""
        for points, faces in (sphere(12, 24), torus(), (BOX, BOX_FACES)):
            model = Surface.from_soup(PolygonMesh.from_faces(points, faces))
            rng = np.random.default_rng(1)
            for k in rng.integers(0, len(model.triangles), 40):
                a, b, c = model.corners[k]
                normals = [[0.0, 0, 1], b - a, np.cross(b - a, c - a), rng.normal(size=3)]
                for normal in normals:
                    found = segments_of(slice_model(model, a, normal, 10.0), 1e-9)
                    assert found.closed.all()

    @settings(max_examples=25)
    @given(st.integers(0, 2**32))
    def test_lengths_against_a_slow_slicer(self, seed: int) -> None:
        """Any plane through any closed shape: every triangle for itself, in space."""
        rng = np.random.default_rng(seed)
        model = Surface.from_soup(PolygonMesh.from_faces(*bumpy(seed)))
        origin, normal = rng.normal(scale=0.4, size=3), rng.normal(size=3)
        radius = float(rng.uniform(0.3, 2.5))
        found = segments_of(slice_model(model, origin, normal, radius), 1e-9)
        total = sum(float(arc_length(np.c_[line, 0 * line[:, 0]])[-1]) for line in found)
        unit = normal / np.linalg.norm(normal)
        assert total == pytest.approx(slow_length(model.corners, origin, unit, radius), abs=1e-7)
        assert found.closed.all() or radius < 2.4

    def test_ends_are_stitched(self) -> None:
        """Patches whose borders differ in the seventh digit give one segment."""
        lines = [arc(k, k + 1.0) * (1.0 + 2e-7 * (k % 2)) for k in (0.0, 1.0, 2.0)]
        model = sheets(*lines)
        assert model.n_components == 3
        found = segments_of(slice_model(model, [1.0, 0, 0], ACROSS, 9.0), STITCH * model.diagonal)
        assert len(found) == 1 and len(found[0]) == 2 * 3 * 59 + 1
        rib = build_rib(model, [np.cos(1.5), 0, np.sin(1.5)], ACROSS, 1.0)
        assert not rib.repaired and rib.reaches == (True, True)
