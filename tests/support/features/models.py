"""What the tests of models and curves share: spheres, soups, and distances triangle by triangle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface


def sphere(rings: int = 12, around: int = 24, radius: float = 1.0) -> tuple[Points, NDArray]:
    """Points (v, 3) and triangles (t, 3) of a globe about the origin."""
    turn = 2.0 * np.pi * np.arange(around) / around
    height = np.pi * np.arange(1, rings) / rings
    ring = [
        np.stack([np.sin(h) * np.cos(turn), np.sin(h) * np.sin(turn), np.full(around, np.cos(h))])
        for h in height
    ]
    points = np.concatenate([np.concatenate(ring, axis=1).T, [[0, 0, 1], [0, 0, -1]]])
    i = np.arange(around)
    j = (i + 1) % around
    north, south = len(points) - 2, len(points) - 1
    pieces = [np.stack([np.full(around, north), i, j], axis=1)]
    for r in range(rings - 2):
        a, b = around * r, around * (r + 1)
        pieces += [np.stack([a + i, b + i, b + j], 1), np.stack([a + i, b + j, a + j], 1)]
    last = around * (rings - 2)
    pieces.append(np.stack([np.full(around, south), last + j, last + i], axis=1))
    return radius * points, np.concatenate(pieces)


def sphere_model(radius: float = 1.0) -> Surface:
    return Surface.from_soup(PolygonMesh.from_faces(*sphere(radius=radius)))


def together(*parts: tuple[Points, NDArray]) -> tuple[Points, NDArray]:
    """The parts as one mesh, nothing glued."""
    points, triangles, first = [], [], 0
    for places, faces in parts:
        points.append(places)
        triangles.append(faces + first)
        first += len(places)
    return np.concatenate(points), np.concatenate(triangles)


def soup(points: Points, triangles: NDArray, seed: int) -> tuple[Points, NDArray]:
    """Every triangle with points of its own, in a random order and sense."""
    rng = np.random.default_rng(seed)
    shuffled = triangles[rng.permutation(len(triangles))]
    turned = rng.permuted(shuffled, axis=1)
    name = rng.permutation(3 * len(triangles))
    apart = np.empty((len(name), 3))
    apart[name] = points[turned.ravel()]
    return apart, name.reshape(-1, 3)


def to_segment(p: Points, a: Points, b: Points) -> float:
    along = b - a
    size = float(along @ along)
    s = min(max(float((p - a) @ along) / size, 0.0), 1.0) if size > 0 else 0.0
    return float(np.linalg.norm(a + s * along - p))


def to_triangle(p: Points, a: Points, b: Points, c: Points) -> float:
    """Distance of a point to a triangle, needles and points included."""
    best = min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))
    weights, *_ = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), p - a, rcond=1e-12)
    if weights.min() >= 0 and weights.sum() <= 1:
        foot = a + weights[0] * (b - a) + weights[1] * (c - a)
        best = min(best, float(np.linalg.norm(foot - p)))
    return best


def to_model(points: Points, corners: Points) -> Points:
    """(n,) distances of points (n, 3) from triangles (t, 3, 3), one by one."""
    return np.array([min(to_triangle(p, *t) for t in corners) for p in points])
