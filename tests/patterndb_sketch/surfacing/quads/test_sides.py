"""Sides of loops: where a boundary has corners, and of which kind."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.quads import count_even_edges
from patterndb_sketch.surfacing.quads.bridge import boundary_of, measure_interior_angles
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import minimal_area
from query import Boundary
from tests.support.surfacing.networks import ring


def loop(corners: object, spacing: float) -> Loop:
    """Straight sides between corners (k, 3) or (k, 2)."""
    points = np.asarray(corners, float)
    points = np.c_[points, np.zeros((len(points), 3 - points.shape[1]))]
    network = ring(points)
    edges = count_even_edges(network, network.cycles, spacing).edges
    return loop_of(network, sample(network, spacing, edges), network.cycles[0])


def boundary(of: Loop) -> tuple[Boundary, int]:
    return boundary_of(of, of.points, minimal_area(of.points)[0])


@given(st.integers(0, 2**32), st.integers(4, 20))
def test_in_the_plane_angles_are_those_of_the_polygon(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    turn = 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    radius = rng.uniform(0.4, 1.0, n)
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(n)], axis=1)
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    frame *= np.sign(np.linalg.det(frame))
    angles = measure_interior_angles(n, points @ frame.T, minimal_area(points @ frame.T)[0])
    out, back = np.roll(points, -1, axis=0) - points, np.roll(points, 1, axis=0) - points
    cross = out[:, 0] * back[:, 1] - out[:, 1] * back[:, 0]
    told = np.arctan2(cross, (out * back).sum(axis=1)) % (2 * np.pi)
    assert angles == pytest.approx(told, abs=1e-9)
    assert angles.sum() == pytest.approx((n - 2) * np.pi)


def test_an_l_has_five_convex_corners_and_a_reflex_one() -> None:
    shape = [(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)]
    found, start = boundary(loop(shape, 1.0))
    assert start == 0
    assert found.lengths == (4, 2, 2, 2, 2, 4)
    assert found.corners == ("convex", "convex", "convex", "reflex", "convex", "convex")


def test_the_boundary_begins_at_the_loops_first_corner() -> None:
    shape = [(1, 0), (4, 0), (4, 2), (0, 2), (0, 0)]
    one = loop(shape, 1.0)
    found, start = boundary(one)
    assert start == 3
    assert found.lengths == (2, 4, 2, 4)
    assert found.points is not None
    assert np.array_equal(found.points, np.roll(one.points, -3, axis=0))


@pytest.mark.parametrize(
    ("degrees", "kind"),
    [(40, "convex"), (130, "convex"), (140, None), (220, None), (230, "reflex")],
)
def test_a_corner_is_one_where_another_number_of_quads_fits_better(
    degrees: float, kind: str | None
) -> None:
    half = math.radians(degrees) / 2
    x, y = math.cos(half), math.sin(half)
    one = loop([(0, 0), (x, -y), (3, -y), (3, y), (x, y)], 0.2)
    at = int(np.flatnonzero((one.points == 0).all(axis=1))[0])
    assert one.corners[at]
    found, start = boundary(one)
    corners = dict(
        zip(
            [(start + i) % len(one.points) for i in found.side_starts[:-1]],
            found.corners,
            strict=True,
        )
    )
    assert corners.get(at) == kind


def test_a_loop_without_corners_is_one_closed_side() -> None:
    turn = 2 * np.pi * np.arange(64) / 64
    for height in (0.0, 0.4):
        points = np.stack([np.cos(turn), np.sin(turn), height * np.cos(2 * turn)], axis=1)
        network = ring(points)
        around = float(arc_length(network.curves[0].points)[-1])
        one = loop_of(network, sample(network, around / 20), network.cycles[0])
        found, start = boundary(one)
        assert (start, found.n_sides, found.lengths) == (0, 0, (20,))


def test_a_bent_loop_is_measured_along_its_surface() -> None:
    """Six edges of a cube around two opposite corners: each angle is that of a face."""
    hexagon = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1)]
    one = loop(hexagon, 0.5)
    found, _ = boundary(one)
    assert found.lengths == (2,) * 6
    assert found.corners == ("convex",) * 6


@pytest.mark.parametrize(
    ("n", "words"), [(3, "a loop of 3 vertices: .* is odd"), (2002, "limit of 2000")]
)
def test_loops_that_no_quads_can_fill_are_told_why(n: int, words: str) -> None:
    turn = 2 * np.pi * np.arange(n) / n
    points = np.stack([np.cos(turn), np.sin(turn), np.zeros(n)], axis=1)
    one = Loop(points, np.zeros(n, bool), np.arange(n))
    fan = np.array([[0, i, i + 1] for i in range(1, n - 1)])
    with pytest.raises(InvalidNetworkError, match=words):
        boundary_of(one, points, fan)
