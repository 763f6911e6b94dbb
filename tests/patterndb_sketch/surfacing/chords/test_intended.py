"""The benchmark's cycles are what they say: simple outlines of the surfaces that they mean."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from patterndb.geometry.polyline import arc_length
from query.placing import Surface
from tests.support.surfacing.intended import list_intended, ribbon
from tests.support.surfacing.surfacedistance import distance

#: Names, and how many corners each cycle has as one counts them on a drawing.
CORNERS = {
    "ribbon 90°": 4,
    "ribbon 180°": 4,
    "ribbon 360°": 4,
    "bumper": 4,
    "wheel arch": 6,
    "helix 1": 4,
    "helix 2": 4,
    "cup quarter": 4,
    "cup handle": 4,
    "saddle": 0,
    "gable roof": 6,
    "horse leg": 4,
    "dolphin side": 2,
    "wavy Coons": 4,
    "planar L": 6,
    "planar star": 10,
}


def segment_gaps(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, n) least distances between the edges of a closed polygon, sampled finely."""
    n = len(points)
    shares = np.linspace(0.0, 1.0, 9)[:, None]
    ahead = np.roll(points, -1, axis=0)
    fine = (points[:, None] * (1 - shares) + ahead[:, None] * shares).reshape(-1, 3)
    gaps = np.linalg.norm(fine[:, None] - fine, axis=2)
    return gaps.reshape(n, 9, n, 9).min(axis=(1, 3))


def test_there_are_cycles_of_every_kind_with_the_corners_that_one_counts() -> None:
    assert {cycle.name: int(cycle.loop.corners.sum()) for cycle in list_intended()} == CORNERS


def test_each_cycle_is_a_simple_polygon_in_even_steps_on_the_edge_of_a_disk() -> None:
    for cycle in list_intended():
        points = cycle.loop.points
        n = len(points)
        assert 60 <= n <= 200, cycle.name
        steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
        assert steps.max() < 1.25 * steps.min(), cycle.name
        apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        apart = np.minimum(apart, n - apart)
        assert segment_gaps(points)[apart > 1].min() > 0.1 * steps.mean(), cycle.name

        triangles = cycle.triangles
        edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
        once, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
        assert len(np.unique(edges, axis=0)) == len(edges), f"{cycle.name}: turned triangles"
        assert uses.max() == 2, cycle.name
        used = np.unique(triangles)
        assert len(used) == len(cycle.vertices), cycle.name
        assert len(used) - len(once) + len(triangles) == 1, f"{cycle.name} is no disk"

        # The boundary: every sample on it, and the loop nearly as long as it is.
        rim = cycle.vertices[once[uses == 1]]
        line = rim[:, 1] - rim[:, 0]
        share = ((points[:, None] - rim[:, 0]) * line).sum(-1) / (line * line).sum(-1)
        foot = rim[:, 0] + np.clip(share, 0.0, 1.0)[..., None] * line
        gap = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
        assert gap.max() < 1e-9 * cycle.diagonal, cycle.name
        around = float(np.linalg.norm(line, axis=1).sum())
        length = float(arc_length(np.r_[points, points[:1]])[-1])
        assert 0.99 * around < length < (1.0 + 1e-9) * around, cycle.name


def test_helicoids_have_the_area_of_the_formula() -> None:
    # The strip (6u, r cos(au), r sin(au)), |r| <= 1/2: the integral of sqrt(36 + a² r²).
    for turn in (90.0, 180.0, 360.0):
        cycle = ribbon(turn)
        r = np.linspace(-0.5, 0.5, 100_001)
        speed = np.sqrt(36.0 + np.radians(turn) ** 2 * r**2)
        area = float(np.trapezoid(speed, r))
        found = Surface.from_arrays(cycle.vertices, cycle.triangles).areas.sum()
        assert found == pytest.approx(area, rel=1e-3)


def test_distance_is_that_of_parallel_squares_and_of_a_part() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    one = Surface.from_arrays(square, halves)
    lifted = Surface.from_arrays(square + np.array([0.0, 0.0, 0.25]), halves)
    assert distance(one, lifted).mean == pytest.approx(0.25, abs=1e-12)
    assert distance(one, lifted).most == pytest.approx(0.25, abs=1e-12)
    assert distance(one, one).most < 1e-12
    # From the whole square to its half: 0 on one half, x on the other; back: 0.
    part = Surface.from_arrays(square * [0.5, 1.0, 1.0], halves)
    assert distance(one, part).mean == pytest.approx(0.5 * 0.125, rel=1e-3)
    assert distance(one, part).most == pytest.approx(0.5, rel=1e-2)
