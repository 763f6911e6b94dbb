"""Solids of surfaces: closed, oriented, as thick as was asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing import surface
from patterndb_sketch.surfacing.tessellation import find_self_intersections
from patterndb_sketch.surfacing.thickening import is_closed, thicken, turn_outward
from tests.support.surfacing.networks import cube, torus

SQUARE = np.array([[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]], float)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float((np.cross(a, b) * c).sum() / 6.0)


def strip(n: int, half_turns: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed band of n quads, cut in two, that turns over so many times."""
    t = 2 * np.pi * np.arange(n) / n
    tilt = half_turns * t / 2.0
    out = np.stack([np.cos(t) * np.cos(tilt), np.sin(t) * np.cos(tilt), np.sin(tilt)], axis=1)
    middle = np.stack([3 * np.cos(t), 3 * np.sin(t), 0 * t], axis=1)
    points = np.concatenate([middle - out, middle + out])
    triangles = []
    for i in range(n):
        a, b = i, i + n
        c, d = (i + 1) % n, (i + 1) % n + n
        if i == n - 1 and half_turns % 2:
            c, d = d, c
        triangles += [[a, b, d], [a, d, c]]
    return points, np.array(triangles)


def test_a_flat_face_becomes_a_box() -> None:
    points, triangles = thicken(SQUARE, HALVES, 0.5)
    assert is_closed(triangles)
    assert volume(points, triangles) == pytest.approx(2 * 3 * 0.5)
    assert sorted(set(points[:, 2].tolist())) == [-0.25, 0.25]


def test_a_cube_becomes_a_shell_with_sharp_corners() -> None:
    network = cube()
    made = surface(network)
    points, triangles = thicken(made.points, made.triangles, 0.1)
    assert is_closed(triangles)
    assert volume(points, triangles) == pytest.approx(1.1**3 - 0.9**3)
    assert np.allclose(np.abs(points - 0.5).max(axis=1).round(9) % 0.1, 0.05)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32), st.floats(0.01, 0.3))
def test_the_sense_of_faces_is_no_matter(seed: int, thickness: float) -> None:
    rng = np.random.default_rng(seed)
    made = surface(torus(6, 5))
    faces = made.triangles.copy()
    turned = rng.random(len(faces)) < 0.5
    faces[turned] = faces[turned, ::-1]
    points, triangles = thicken(made.points, faces, thickness)
    assert is_closed(triangles)
    # A shell of a closed surface: area times thickness, but for how it bends.
    assert volume(points, triangles) == pytest.approx(made.area * thickness, rel=0.1)


@pytest.mark.parametrize("half_turns", [0, 1, 2, 3])
def test_strips_that_turn_over_become_solids(half_turns: int) -> None:
    points, triangles = strip(60, half_turns)
    solid, faces = thicken(points, triangles, 0.1)
    assert is_closed(faces)
    assert volume(solid, faces) > 0.0
    assert not len(find_self_intersections(solid, faces))


@pytest.mark.parametrize("n_pages", [3, 4, 5])
def test_pages_of_a_book_share_their_back(n_pages: int) -> None:
    """An edge of three faces or more: between each two next to each other one wedge is open."""
    angles = 2 * math.pi * np.arange(n_pages) / n_pages
    outer = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    points = np.concatenate([[[0, 0, 0], [0, 0, 1]], outer, outer + np.array([0, 0, 1])])
    faces = []
    for page in range(n_pages):
        a, b = 2 + page, 2 + n_pages + page
        quad = [[0, a, b], [0, b, 1]]
        faces += [face[::-1] for face in quad] if page % 2 else quad
    solid, triangles = thicken(points, np.array(faces), 0.05)
    assert is_closed(triangles)
    assert not len(find_self_intersections(solid, triangles))
    assert volume(solid, triangles) == pytest.approx(n_pages * 0.05, rel=0.05)


def test_what_is_refused() -> None:
    for thickness in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidNetworkError, match="thickness"):
            thicken(SQUARE, HALVES, thickness)
    with pytest.raises(InvalidNetworkError, match="no faces"):
        thicken(SQUARE, HALVES[:0], 1.0)


def test_parts_are_turned_outward_one_by_one() -> None:
    made = surface(cube())
    one = made.triangles
    points = np.concatenate([made.points, made.points + 5.0])
    both = [one[:, ::-1], one + len(made.points)]
    left, right = turn_outward(points, both)
    assert is_closed(left) and not is_closed(left[1:])
    assert volume(points, left) == pytest.approx(1.0)
    assert volume(points, right) == pytest.approx(1.0)
