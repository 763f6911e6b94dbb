"""Ribs where surfaces cross, gap or end short: outer contours put together from segments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bodies import body, degrade
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.registration.mapping import find_outermost
from patterndb_sketch.features.ribs import build_rib, build_ribs
from tests.support.features.drawnbodies import DRAWN, find_body
from tests.support.features.models import to_model
from tests.support.features.ribs import ACROSS, FARTHEST, GAP, arc, flat, sheets, sound, to_polyline
from tests.support.shared import SHARED, list_shared

#: A body with all faults, and vehicles as found where they are.
TORN = [
    Path(DRAWN[-1]),
    *list_shared(SHARED / "data" / "cad", "gclass_chrono.obj", "uazbus_chrono.obj"),
]


class TestRepair:
    @pytest.mark.parametrize("pixels", [2.0, 9.0, 20.0])
    def test_the_gap_is_closed(self, pixels: float) -> None:
        radius = 0.5
        gap = pixels * 2 * radius / 776
        model = sheets(arc(0.2, 1.5, 400), arc(1.5 + gap, 2.9, 400))
        for turn in (1.45, 1.5, 1.5 + 0.5 * gap, 1.6):
            rib = build_rib(model, [np.cos(turn), 0, np.sin(turn)], ACROSS, radius)
            sound(rib)
            assert rib.joined and rib.reaches == (True, True) and rib.note == ""
            # The gap's two tangents, taken over a quarter of its width, meet just outside the
            # circle; all else lies on it.
            away = np.linalg.norm(flat(rib.polygon), axis=1)
            assert away.max() < 1.0 / np.cos(gap / 2) + gap**2 / 16 + 1e-5
            assert np.linalg.norm(flat(rib.points), axis=1).min() > 1 - gap**2 / 8 - 2e-5
            assert (flat(rib.points) * flat(rib.normals)).sum(axis=1).min() > 0.9

    def test_wider_gaps_stay_and_are_told(self) -> None:
        model = sheets(arc(0.2, 1.5), arc(1.6, 2.9))
        rib = build_rib(model, [np.cos(1.4), 0, np.sin(1.4)], ACROSS, 0.5)
        assert not rib.repaired and sorted(rib.reaches) == [False, True]

    @settings(max_examples=25)
    @given(st.integers(0, 2**32))
    def test_crossing_segments_give_the_outline_of_their_union(self, seed: int) -> None:
        """Discs that share a point have a union without holes. Its outline, by brute force: the
        points of each circle that are in no other disc."""
        rng = np.random.default_rng(seed)
        count = int(rng.integers(2, 5))
        sizes = rng.uniform(0.5, 1.0, count)
        ways = rng.uniform(0, 2 * np.pi, count)
        middles = 0.7 * (sizes * np.array([np.cos(ways), np.sin(ways)])).T
        circles = [m + arc(0, 2 * np.pi, 200, s) for m, s in zip(middles, sizes, strict=True)]
        model = sheets(*circles)
        pixel = 2 * 4.0 / 576
        free = []
        for i in range(count):
            fine = middles[i] + arc(0, 2 * np.pi, 2_001, sizes[i])[:-1]
            inside = np.zeros(len(fine), bool)
            for j in range(count):
                if j != i:
                    inside |= np.linalg.norm(fine - middles[j], axis=1) < sizes[j] * 0.9999
            free.append(fine[~inside])
        wanted = np.concatenate(free)
        total = sum(len(f) * 2 * np.pi * s / 2_000 for f, s in zip(free, sizes, strict=True))
        start = wanted[rng.integers(len(wanted))]
        rib = build_rib(model, [start[0], 0, start[1]], ACROSS, 4.0)
        sound(rib)
        assert rib.closed
        polygon = flat(rib.polygon)
        depth = [
            s - np.linalg.norm(polygon - m, axis=1) for m, s in zip(middles, sizes, strict=True)
        ]
        assert np.max(depth) < 2 * pixel
        assert to_polyline(wanted, polygon).max() < 2 * pixel
        assert arc_length(rib.polygon)[-1] == pytest.approx(total, rel=0.03)
        # Points of the cut edges, or of their crossings: not of pixels.
        nearest = np.min([to_polyline(polygon, c) for c in circles], axis=0)
        assert nearest.max() < 1e-9
        middle = flat(rib.points) - start / 3
        assert (middle * flat(rib.normals)).sum() > 0

    def test_what_hangs_over_and_fins_are_left_out(self) -> None:
        """Two sheets that cross near their ends, and a rod that stands on one."""
        one = np.array([[-1.0, 0.0], [0.008, 0.0]])
        two = np.array([[0.0, 0.008], [0.0, -1.0]])
        fin = np.array([[-0.2, -0.004], [-0.2, 0.2]])
        model = sheets(one, two, fin)
        rib = build_rib(model, [-0.05, 0.0, 0.0], ACROSS, 0.5)
        sound(rib)
        wanted = np.array([[-0.55, 0.0], [0.0, 0.0], [0.0, -np.sqrt(0.5**2 - 0.05**2)]])
        ends = np.linalg.norm(flat(rib.polygon)[[0, -1]][:, None] - wanted[[0, 2]], axis=2)
        assert ends.min(axis=1).max() < 0.01
        assert to_polyline(wanted, flat(rib.polygon)).max() < 0.01
        assert to_polyline(flat(rib.polygon), wanted).max() < 0.01

    def test_open_sheets_have_one_side(self) -> None:
        """Segments that cross, both ending within the circle: from end to end, not around."""
        model = sheets([[-0.3, 0.0], [0.1, 0.0]], [[0.05, -0.05], [0.3, 0.2]])
        rib = build_rib(model, [-0.2, 0, 0.0], ACROSS, 0.6)
        sound(rib)
        assert rib.repaired and rib.reaches == (False, False)
        polygon = flat(rib.polygon)
        assert np.linalg.norm(polygon[0] - polygon[-1]) > 0.5

    def test_clutter_below_the_surface_changes_nothing(self) -> None:
        """Sheets that stand against the inside of a circle, some of them across it by a hair."""
        rng = np.random.default_rng(6)
        spokes = [
            np.array([[0.6, 0.0], [1.0 + rng.uniform(-0.01, 0.001), 0.0]])
            @ np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]])
            for t in np.linspace(0.3, 2.8, 14)
        ]
        model = sheets(arc(0.0, np.pi, 120), *spokes)
        lone = sheets(arc(0.0, np.pi, 120))
        rib = build_rib(model, [0.0, 0, 1.0], ACROSS, 0.6)
        clean = build_rib(lone, [0.0, 0, 1.0], ACROSS, 0.6)
        sound(rib)
        assert rib.repaired and not clean.repaired
        pixel = 2 * 0.6 / 776
        assert to_polyline(rib.points, clean.polygon).max() < 2 * pixel
        assert to_polyline(clean.points, rib.polygon).max() < 2 * pixel

    @pytest.mark.parametrize("name", ["shoulder", "roof_rail", "belt_line", "front_arch"])
    def test_messy_bodies(self, name: str) -> None:
        """A simple polygon of original points and of corners restored in gaps; near the true
        surface for the most part."""
        car = body("city car", whole=True)
        clean = Surface.from_soup(PolygonMesh.from_faces(car.points, car.triangles))
        mess = degrade(
            car, 1, uneven=True, cuts=3, gaps=0.001, crossings=0.003, flips=0.5,
            interior=True, exterior=True, shuffle=True,
        )  # fmt: skip
        model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
        line = car.feature(name).smooth[20:-20:20]
        origins = model.nearest(line[1:-1]).points
        ribs = build_ribs(model, origins, line[2:] - line[:-2])
        assert any(rib.repaired for rib in ribs)
        away, added = [], []
        for rib in ribs:
            sound(rib)
            inner = rib.polygon[1:-1]
            off = model.measure_distances(inner)
            assert off.max() < (FARTHEST * GAP * RADIUS if rib.joined else 1e-9) * model.diagonal
            added.append(off > 1e-9 * model.diagonal)
            low, high = rib.polygon.min(axis=0) - 1e-6, rib.polygon.max(axis=0) + 1e-6
            near = (model.corners.min(axis=1) <= high) & (model.corners.max(axis=1) >= low)
            near = near.all(axis=1)
            if len(inner) < 12:
                assert to_model(inner, model.corners[near]) == pytest.approx(off, abs=1e-9)
            away.append(clean.measure_distances(rib.points))
        assert np.median(np.concatenate(away)) < 5e-4 * model.diagonal
        assert np.concatenate(added).mean() < 0.1
        true = build_ribs(clean, line[1:-1], line[2:] - line[:-2])
        agree = [
            one.normals[one.backbone] @ two.normals[two.backbone] > 0.0
            for one, two in zip(ribs, true, strict=True)
        ]
        assert np.mean(agree) > 0.9

    @pytest.mark.parametrize("path", TORN, ids=lambda path: path.stem)
    def test_torn_vehicles(self, path: Path) -> None:
        """Seen from where a ray first hits them: simple polygons, outward."""
        path = find_body(path.name, ".obj") if path.name in DRAWN else path
        model = Surface.from_soup(read_mesh(path))
        rng = np.random.default_rng(0)
        ways = rng.normal(size=(60, 3))
        middle = 0.5 * (model.vertices.min(axis=0) + model.vertices.max(axis=0))
        points, lengths = find_outermost(model, middle + 0.0 * ways, ways)
        met = np.isfinite(lengths)
        ways, origins = ways[met], points[met]
        ribs = build_ribs(model, origins, np.cross(ways, rng.normal(size=ways.shape)))
        assert any(rib.repaired for rib in ribs)
        outward = []
        for rib, way in zip(ribs, ways, strict=True):
            sound(rib)
            outward.append(rib.normals[rib.backbone] @ way > 0.0)
        assert np.mean(outward) > 0.9
