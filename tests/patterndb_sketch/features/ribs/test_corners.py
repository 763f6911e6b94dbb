"""Ribs at corners: sheets that end short of the edge where they would meet, or overshoot it."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import body, degrade
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.ribs import build_rib, build_ribs
from tests.support.features.ribs import (
    ACROSS,
    FARTHEST,
    GAP,
    OVERHANG,
    SHARPEST,
    flat,
    sheets,
    sound,
    to_polyline,
)


def ray(turn: float, low: float, high: float) -> Points:
    """(2, 2) a segment of the line from the origin in a direction."""
    return np.array([[low], [high]]) * [np.cos(turn), np.sin(turn)]


class TestCorners:
    """Two straight sheets that would meet in a corner at the origin, seen within 1."""

    @settings(max_examples=40)
    @given(st.floats(0.6, 2.9), st.floats(0.0, 6.0), st.integers(0, 2**32))
    def test_a_gap_at_a_corner_is_restored_to_the_corner(
        self, inner: float, turn: float, seed: int
    ) -> None:
        """Whatever the angle and however far each side ends short, unless the corner is sharper
        than 60 degrees: then the bridge is of original points."""
        short = np.random.default_rng(seed).uniform(0.3, 1.0, 2) * 0.02
        sides = [ray(t, s, 2.3) for t, s in zip((turn, turn + inner), short, strict=True)]
        rib = build_rib(sheets(*sides), [*(0.3 * sides[0][1])[[0]], 0, 0.3 * sides[0][1][1]],
                        ACROSS, 1.0)  # fmt: skip
        sound(rib)
        polygon = flat(rib.polygon)
        nearest = np.linalg.norm(polygon, axis=1).min()
        assert rib.repaired and rib.reaches == (True, True)
        if inner >= np.arccos(-SHARPEST):
            assert rib.rounds == 0 and nearest < 1e-12
        else:
            assert nearest >= short.min() - 1e-9
        # Nothing is added farther off than the gap lets it be.
        width = np.linalg.norm(sides[0][0] - sides[1][0])
        added = np.min([to_polyline(polygon, side) for side in sides], axis=0)
        assert added.max() <= FARTHEST * width

    @settings(max_examples=40)
    @given(st.floats(0.5, 2.6), st.floats(0.0, 6.0), st.integers(0, 2**32))
    def test_sheets_that_overshoot_alike_end_where_they_cross(
        self, inner: float, turn: float, seed: int
    ) -> None:
        """Whether their vertices meet at the crossing or not, and wherever one looks from: on a
        side, at the crossing, or at the tip of what hangs over."""
        rng = np.random.default_rng(seed)
        over = rng.uniform(0.3, 1.0, 2) * 0.9 * OVERHANG
        turns = (turn, turn + inner)
        sides = [ray(t, -s, 2.3) for t, s in zip(turns, over, strict=True)]
        if seed % 2:
            sides = [np.insert(side, 1, 0.0, axis=0) for side in sides]
        wanted = np.array([sides[0][-1], [0.0, 0.0], sides[1][-1]])
        for place in (0.2 * wanted[0], wanted[1], sides[0][0]):
            rib = build_rib(sheets(*sides), [place[0], 0, place[1]], ACROSS, 1.0)
            sound(rib)
            assert rib.joined and rib.rounds == 0 and rib.reaches == (True, True)
            assert to_polyline(flat(rib.polygon), wanted).max() < 1e-9
            assert np.linalg.norm(flat(rib.polygon), axis=1).min() < 1e-9

    def test_an_end_short_of_another_sheet_is_drawn_out_to_it(self) -> None:
        """One side overshoots, the other ends short: the corner is where that one would meet."""
        one, two = ray(0.0, -0.03, 2.0), ray(2.0, 0.02, 2.0)
        rib = build_rib(sheets(one, two), [0.3, 0, 0], ACROSS, 1.0)
        sound(rib)
        assert rib.joined and rib.reaches == (True, True)
        assert np.linalg.norm(flat(rib.polygon), axis=1).min() < 1e-12
        assert to_polyline(flat(rib.polygon), np.array([one[1], [0.0, 0.0], two[1]])).max() < 1e-9

    def test_a_lip_beyond_what_ends_against_it_stays(self) -> None:
        """A panel with a wall behind it, whose edge stands out by more than a gap."""
        lip = 1.5 * GAP
        panel, wall = ray(0.0, -lip, 2.0), ray(2.0, 0.0, 2.0)
        rib = build_rib(sheets(panel, wall), [0.3, 0, 0], ACROSS, 1.0)
        assert not rib.joined
        assert to_polyline(np.array([[-lip, 0.0]]), flat(rib.polygon))[0] < 1e-9

    def test_a_wall_behind_a_joint_does_not_open_it(self) -> None:
        """Two panels that leave a gap, and a wall that ends against one of them just before."""
        panels = [np.array([[-2.0, 0.0], [-0.005, 0.0]]), np.array([[0.005, 0.0], [2.0, 0.0]])]
        wall = np.array([[-0.03, 0.0], [-0.03, -2.0]])
        rib = build_rib(sheets(*panels, wall), [0.3, 0, 0.0], ACROSS, 0.8)
        sound(rib)
        # The wall stands below the panels, which are seen from above.
        assert (rib.normals[:, 2] > 0.999).all()
        assert rib.reaches == (True, True)
        assert np.abs(flat(rib.polygon)[:, 1]).max() < 1e-9

    @pytest.mark.parametrize("state", [{"gaps": 0.002}, {"crossings": 0.002}, {"crossings": 0.006}])
    def test_ribs_of_torn_bodies_go_through_their_features(self, state: dict[str, float]) -> None:
        """97 of 100 to a ten-thousandth of the diagonal, and none is a mere scrap."""
        car = body("wagon")
        mess = degrade(car, 1, **state)  # pyright: ignore[reportArgumentType]
        model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
        away, sizes = [], []
        for name in ("shoulder", "roof_rail", "hood_edge", "rear_bottom", "sill_middle"):
            line = car.feature(name).points
            line = at_lengths(line, np.linspace(0.05, 0.95, 42) * arc_length(line)[-1])
            for rib, place in zip(
                build_ribs(model, line[1:-1], line[2:] - line[:-2]), line[1:-1], strict=True
            ):
                sound(rib)
                away.append(to_polyline(place[None], rib.polygon)[0])
                sizes.append(arc_length(rib.polygon)[-1])
        assert np.mean(np.array(away) < 1e-4 * car.diagonal) > 0.97
        assert np.min(sizes) > 0.5 * RADIUS * model.diagonal
