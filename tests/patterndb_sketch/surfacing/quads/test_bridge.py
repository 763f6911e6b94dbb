"""Quads within loops: disks on the loops' own vertices, which neighbours share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import patterndb
from patterndb.geometry.quadshape import find_turned_corners
from patterndb.store import Database
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.quads import bridge, fill_with_quads
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import minimal_area
from query.placing import Placement, Surface, place
from tests.support.surfacing.networks import cube, prism, ring, shuffled, torus
from tests.support.surfacing.quads import assert_closed, assert_disk_within, filled, loops, together


@pytest.fixture(scope="module")
def db() -> Iterator[Database]:
    with patterndb.open() as opened:
        yield opened


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("spacing", [0.25, 0.4])
def test_quads_have_the_boundary_vertices_of_the_triangles(
    db: Database, smooth: bool, spacing: float
) -> None:
    for network in (cube(), prism()):
        sampling, of = loops(network, spacing)
        before = sampling.points.copy()
        for loop in of:
            n = len(loop.points)
            triangles, patch = filled(db, loop, smooth, spacing)
            assert_disk_within(n, triangles)
            assert_disk_within(n, patch.quads)
            assert set(triangles[triangles < n]) == set(patch.quads[patch.quads < n])
            assert set(range(n, n + len(patch.points))) == set(patch.quads[patch.quads >= n])
            assert np.array_equal(loop.points, before[loop.vertices])
            assert (patch.n_flipped, patch.note) == (0, "")
        assert np.array_equal(sampling.points, before)


def test_a_cube_becomes_a_closed_mesh_of_quads(db: Database) -> None:
    sampling, of = loops(cube(), 0.25)
    assert [len(loop.points) for loop in of] == [16] * 6
    patches = [filled(db, loop, False, 0.25)[1] for loop in of]
    points, quads = together(sampling, of, patches)
    assert_closed(quads, 2)
    # Grids of four by four on every face.
    assert len(quads) == 6 * 16
    assert {round(float(x) * 4, 6) for x in points.ravel()} == {0, 1, 2, 3, 4}
    assert {patch.n_irregular for patch in patches} == {0}


@pytest.mark.parametrize("spacing", [0.5, 0.9])
def test_a_torus_becomes_a_closed_mesh_of_quads(db: Database, spacing: float) -> None:
    sampling, of = loops(torus(7, 5), spacing)
    patches = [filled(db, loop, True, spacing)[1] for loop in of]
    assert_closed(together(sampling, of, patches)[1], 0)


def test_the_sense_of_a_cycle_is_that_of_its_quads(db: Database) -> None:
    for seed in range(3):
        network = shuffled(prism(), seed)
        _, of = loops(network, 0.3)
        for loop in of:
            _, patch = filled(db, loop, False, 0.3)
            assert_disk_within(len(loop.points), patch.quads)


def dome(n: int, rings: int) -> tuple[Loop, np.ndarray, np.ndarray]:
    """A ball's upper three quarters by height, the loop around its foot, and its triangles."""
    turn = 2 * np.pi * np.arange(n) / n
    points = [
        np.stack([np.sin(a) * np.cos(turn), np.sin(a) * np.sin(turn), np.full(n, np.cos(a))], 1)
        for a in np.linspace(2 * np.pi / 3, 0, rings + 1)[:-1]
    ]
    at = np.concatenate([*points, [[0.0, 0.0, 1.0]]])
    triangles = []
    for r in range(rings):
        for i in range(n):
            a, b = r * n + i, r * n + (i + 1) % n
            if r == rings - 1:
                triangles.append([a, b, rings * n])
            else:
                triangles += [[a, b, b + n], [a, b + n, a + n]]
    loop = Loop(points[0], np.zeros(n, bool), np.arange(n))
    return loop, at, np.array(triangles)


def test_quads_lie_on_a_dome_that_hangs_over_its_foot(db: Database) -> None:
    """No projection along one direction would do: patch and fill are laid on one disk."""
    loop, points, triangles = dome(24, 12)
    patch = fill_with_quads(db, loop, points, triangles)
    assert (patch.n_flipped, patch.note) == (0, "")
    assert_disk_within(24, patch.quads)
    surface = Surface.from_arrays(points, triangles)
    gaps = np.linalg.norm(surface.nearest(patch.points).points - patch.points, axis=1)
    assert gaps.max() < 1e-9
    assert patch.points[:, 2].max() > 0.9
    # All of the dome is covered, once.
    corner = np.r_[loop.points, patch.points][patch.quads]
    area = np.linalg.norm(
        np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1
    )
    assert 0.85 < area.sum() / 2 / surface.areas.sum() < 1.0


def test_the_next_fill_is_taken_where_quads_are_flipped(
    db: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, of = loops(ring([(0, 0, 0), (3, 0, 0), (4, 2, 0), (1, 4, 0), (-1, 2, 0)]), 0.7)
    (loop,) = of
    triangles, first = filled(db, loop, False, 0.7)
    asked = []

    def awry(spoilt: int) -> object:
        def placed(fill: object, points: object, region: object) -> Placement:
            asked.append(fill)
            found = place(fill, points, region)  # pyright: ignore[reportArgumentType]
            worse = 3 if len(asked) <= spoilt else 0
            if spoilt >= 4:
                worse = 4 - len(asked) % 2
            return replace(found, flipped=np.arange(worse, dtype=np.int32))

        return placed

    monkeypatch.setattr(bridge, "place", awry(2))
    third = fill_with_quads(db, loop, loop.points, triangles)
    assert len(asked) == 3
    assert third.note == ""
    assert not np.array_equal(third.quads, first.quads)
    asked.clear()
    monkeypatch.setattr(bridge, "place", awry(4))
    kept = fill_with_quads(db, loop, loop.points, triangles)
    assert len(asked) == bridge.PLACED
    assert np.array_equal(kept.quads, first.quads)
    assert kept.n_flipped == 3
    assert kept.note == f"3 of {len(kept.quads)} quads are flipped"


def test_a_fill_without_turned_corners_is_taken_and_turned_ones_are_reported(
    db: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, of = loops(ring([(0, 0, 0), (3, 0, 0), (4, 2, 0), (1, 4, 0), (-1, 2, 0)]), 0.7)
    (loop,) = of
    triangles, first = filled(db, loop, False, 0.7)
    assert first.n_turned == 0
    asked = []

    def spoilt(calls: int) -> object:
        def turned(quads: np.ndarray, vertices: np.ndarray) -> np.ndarray:
            found = find_turned_corners(quads, vertices)
            asked.append(quads)
            if len(asked) <= calls:
                found[:2, 0] = True
            return found

        return turned

    monkeypatch.setattr(bridge, "find_turned_corners", spoilt(1))
    second = fill_with_quads(db, loop, loop.points, triangles)
    assert len(asked) == 2
    assert (second.n_turned, second.note) == (0, "")
    assert not np.array_equal(second.quads, first.quads)
    asked.clear()
    monkeypatch.setattr(bridge, "find_turned_corners", spoilt(bridge.PLACED))
    kept = fill_with_quads(db, loop, loop.points, triangles)
    assert kept.n_turned == 2
    assert kept.note == f"2 of {len(kept.quads)} quads have a turned corner"


def test_what_cannot_be_filled_is_refused_with_the_reason(db: Database) -> None:
    network = prism()
    sampling = sample(network, 0.3, [[3]] * len(network.curves))
    odd = loop_of(network, sampling, network.cycles[0])
    triangles, _ = minimal_area(odd.points)
    with pytest.raises(InvalidNetworkError, match=r"loop of 9 vertices.*odd"):
        fill_with_quads(db, odd, odd.points, triangles)
    loop = loops(cube(), 0.5)[1][0]
    triangles, _ = minimal_area(loop.points)
    with pytest.raises(InvalidNetworkError, match="in its sense"):
        fill_with_quads(db, loop, loop.points, triangles[:, ::-1])
    line = np.linspace(0, 1, 8)
    there_and_back = np.stack([np.minimum(line, 1.1 - line), 0 * line, 0 * line], axis=1)
    flat = Loop(there_and_back, np.zeros(8, bool), np.arange(8))
    fan = np.array([[0, i, i + 1] for i in range(1, 7)])
    with pytest.raises(InvalidNetworkError, match="no triangle with an area"):
        fill_with_quads(db, flat, flat.points, fan)
