"""The skin of shapes: normals, creases, outlines and curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.viewer.shapes import car_shapes, car_template
from viewer.shapes.skin import ShapeSkin

MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def skin() -> ShapeSkin:
    return ShapeSkin.of(car_shapes(), car_template())


def test_triangles_cover_the_quads_alike_on_both_sides(skin: ShapeSkin) -> None:
    """Two triangles a quad, turned as it is, and the image's diagonals are the images."""
    quads, n = skin.quads, len(skin.quads)
    triangles = skin.vertices.reshape(n, 2, 3)
    for quad, pair in zip(quads.tolist(), triangles.tolist(), strict=True):
        around = {(quad[k], quad[(k + 1) % 4]) for k in range(4)}
        edges = [(t[k], t[(k + 1) % 3]) for t in pair for k in range(3)]
        assert around <= set(edges)
        left = [edge for edge in edges if edge not in around]
        assert len(left) == 2 and left[0] == left[1][::-1]
    points = car_shapes().mean
    sizes = np.linalg.norm(np.ptp(points[np.sort(triangles.reshape(-1, 3))], axis=1), axis=1)
    half = sizes.reshape(2, -1)
    assert np.sort(half[0]) == pytest.approx(np.sort(half[1]))


def test_normals_are_smooth_but_not_over_creases(skin: ShapeSkin) -> None:
    """Against loops over the corners of each vertex."""
    points = car_shapes().shape(car_shapes().coefficients[2])
    normals = skin.normals(points)
    faces = skin.face_normals(points)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    unit = faces / np.linalg.norm(faces, axis=1, keepdims=True)
    corners: dict[int, list[int]] = {}
    for corner, vertex in enumerate(skin.quads.ravel().tolist()):
        corners.setdefault(vertex, []).append(corner)
    low, high = np.cos(np.radians(45.0)), np.cos(np.radians(30.0))
    for around in corners.values():
        for one in around:
            total = np.zeros(3)
            for other in around:
                cosine = unit[one // 4] @ unit[other // 4]
                share = 1.0 if one == other else min(max((cosine - low) / (high - low), 0.0), 1.0)
                total += share * faces[other // 4]
            assert normals[one] == pytest.approx(total / np.linalg.norm(total))


@settings(max_examples=15)
@given(st.integers(0, 10**6))
def test_the_outline_parts_what_faces_the_viewer_from_what_does_not(seed: int) -> None:
    """Against loops over triangles and edges: in a triangle the line where the normals, blended
    between its corners, are across the line of sight; along an edge, where its faces' own
    normals differ in side, or where there is one face alone."""
    skin = ShapeSkin.of(car_shapes(), car_template())
    points = car_shapes().mean
    toward = np.random.default_rng(seed).normal(size=3)
    normals = skin.normals(points)
    ahead = (normals @ toward).tolist()
    wanted: list[np.ndarray] = []
    beside: dict[tuple[int, int], list[bool]] = {}
    for face, quad in enumerate(skin.quads.tolist()):
        for k in range(4):
            a, b = quad[k], quad[(k + 1) % 4]
            side = ahead[4 * face + k] + ahead[4 * face + (k + 1) % 4] > 0.0
            beside.setdefault((min(a, b), max(a, b)), []).append(side)
    for edge, sides in beside.items():
        if len(sides) == 1 or sides[0] != sides[1]:
            wanted.append(points[list(edge)])
    for corners, vertices in zip(skin.corners.tolist(), skin.vertices.tolist(), strict=True):
        ends = []
        for i, j in ((0, 1), (1, 2), (2, 0)):
            one, other = ahead[corners[i]], ahead[corners[j]]
            if (one > 0.0) != (other > 0.0):
                share = one / (one - other)
                ends.append(points[vertices[i]] * (1 - share) + points[vertices[j]] * share)
        if ends:
            wanted.append(np.array(ends))
    found = skin.outline(points, normals, toward)

    def ordered(lines: Sequence[np.ndarray]) -> list[list[list[float]]]:
        # Rounded and above 0: -0.0 and 0.0 are one place, in whatever order.
        return sorted(sorted((np.round(line, 7) + 0.0).tolist()) for line in lines)

    assert len(found) == len(wanted)
    assert np.array(ordered(list(found))) == pytest.approx(np.array(ordered(wanted)), abs=1e-6)


def test_every_curve_has_its_image_but_those_in_the_middle(skin: ShapeSkin) -> None:
    points = car_shapes().shape(car_shapes().coefficients[1])
    own = {line.name: line for line in skin.lines if not line.mirrored}
    images = {line.name: line for line in skin.lines if line.mirrored}
    assert list(own) == [one.name for one in car_shapes().features]
    for name, line in own.items():
        place = points[line.vertices]
        if np.abs(place[:, 1]).max() < 1e-9:
            assert name not in images
        else:
            assert points[images[name].vertices] == pytest.approx(place * MIRROR)
    offset = np.array([1.0, 2.0, 3.0])
    assert images["shoulder"].pull(offset).tolist() == [1.0, -2.0, 3.0]
    assert own["shoulder"].pull(offset) is offset
