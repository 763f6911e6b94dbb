"""What the tests of ribs share: sheets, shapes, a slow slicer, and what holds for every rib."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.ribs import Rib
from tests.support.features.models import sphere, together

#: As in rust/features/src/ribs/repair.rs, in shares of the radius; SHARPEST is a cosine.
SHARPEST, GAP, OVERHANG = -0.5, 0.055, 0.15

#: The direction that ribs of sheets are across.
ACROSS = [0.0, 1.0, 0.0]

BOX = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
BOX_FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
])  # fmt: skip

#: How far a restored corner may be from the ends of the gap, in widths of it.
FARTHEST = 1.0 / np.sqrt(1.0 - SHARPEST**2) + 1e-6


def sheet(line: Points, half: float = 1.0) -> tuple[Points, NDArray]:
    """The polyline (k, 2) drawn out along y: its cut by the plane y = 0 is the polyline."""
    k = len(line)
    low = np.stack([line[:, 0], np.full(k, -half), line[:, 1]], axis=1)
    high = low + np.array([0.0, 2.0 * half, 0.0])
    i = np.arange(k - 1)
    faces = np.concatenate([np.stack([i, i + 1, k + i], 1), np.stack([i + 1, k + i + 1, k + i], 1)])
    return np.concatenate([low, high]), faces


def sheets(*lines: ArrayLike) -> Surface:
    return Surface.from_soup(
        PolygonMesh.from_faces(*together(*(sheet(np.asarray(line, float)) for line in lines)))
    )


def arc(begin: float, end: float, count: int = 60, radius: float = 1.0) -> Points:
    """(count, 2) points of a circle about the origin, from one angle to another."""
    turn = np.linspace(begin, end, count)
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def torus(around: int = 40, tube: int = 24) -> tuple[Points, NDArray]:
    u, v = np.meshgrid(np.arange(around), np.arange(tube), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / tube
    wide = 1.0 + 0.4 * np.cos(b)
    points = np.stack([wide * np.cos(a), wide * np.sin(a), 0.4 * np.sin(b)], axis=2).reshape(-1, 3)
    i, j = u.ravel(), v.ravel()

    def at(p: NDArray, q: NDArray) -> NDArray:
        return (p % around) * tube + q % tube

    one = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1)], axis=1)
    two = np.stack([at(i, j), at(i + 1, j + 1), at(i, j + 1)], axis=1)
    return points, np.concatenate([one, two])


def bumpy(seed: int) -> tuple[Points, NDArray]:
    """A closed shape like a potato, every ray from its middle hitting it once."""

    points, triangles = sphere(20, 30)
    rng = np.random.default_rng(seed)
    size = np.ones(len(points))
    for _ in range(4):
        size += 0.08 * np.sin(points @ rng.normal(size=3) * 3.0 + rng.uniform(0, 6))
    return points * size[:, None], triangles


def to_polyline(points: Points, line: Points) -> Points:
    """(n,) distances of points (n, d) from a polyline (k, d)."""
    a, b = line[:-1], line[1:]
    along = b - a
    size = np.maximum((along**2).sum(axis=1), 1e-300)
    share = np.einsum("nkd,kd->nk", points[:, None] - a, along) / size
    feet = a + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1)


def crosses_itself(polygon: Points, closed: bool) -> bool:
    """Do two edges of a polygon (k, 2) that are not neighbours meet? All pairs, by signs."""

    def side(p: Points, q: Points, r: Points) -> Points:
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (
            r[..., 0] - p[..., 0]
        )

    a, b = polygon[:-1, None], polygon[1:, None]
    c, d = polygon[None, :-1], polygon[None, 1:]
    met = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    i, j = np.nonzero(met)
    apart = np.abs(i - j) > 1
    if closed:
        apart &= np.abs(i - j) < len(polygon) - 2
    return bool(apart.any())


def slow_length(corners: Points, origin: Points, normal: Points, radius: float) -> float:
    """Length of a plane's cut within a circle, triangle by triangle in space."""
    total = 0.0
    for triangle in corners:
        height = (triangle - origin) @ normal
        ends = []
        for i in range(3):
            j = (i + 1) % 3
            if (height[i] >= 0) != (height[j] >= 0):
                s = height[i] / (height[i] - height[j])
                ends.append(triangle[i] + s * (triangle[j] - triangle[i]))
        if len(ends) < 2:
            continue
        p, d = ends[0] - origin, ends[1] - ends[0]
        a, b, c = d @ d, p @ d, p @ p - radius**2
        if a > 0 and b * b - a * c > 0:
            root = np.sqrt(b * b - a * c)
            low, high = max((-b - root) / a, 0.0), min((-b + root) / a, 1.0)
            total += max(high - low, 0.0) * np.sqrt(a)
    return total


def flat(points: Points) -> Points:
    """x and z: the plane y = 0 that sheets are cut in."""
    return points[:, [0, 2]]


def in_plane(rib: Rib) -> Points:
    return (rib.polygon - rib.origin) @ rib.axes[:2].T


def sound(rib: Rib, samples: int = 201) -> None:
    """What holds for every rib."""
    span = np.ptp(rib.polygon, axis=0).max() + np.abs(rib.origin).max()
    for points in (rib.points, rib.polygon):
        assert np.abs((points - rib.origin) @ rib.axes[2]).max() <= 1e-9 * span
    assert rib.points.shape == rib.normals.shape == (samples, 3)
    assert np.linalg.norm(rib.normals, axis=1) == pytest.approx(np.ones(samples), abs=1e-12)
    assert np.abs(rib.normals @ rib.axes[2]).max() < 1e-12
    away = np.linalg.norm(rib.points - rib.origin, axis=1)
    assert rib.backbone == np.argmin(away)
    assert (to_polyline(rib.points, rib.polygon) < 1e-9 * span).all()
    assert not crosses_itself(in_plane(rib), rib.closed)
