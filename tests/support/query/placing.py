"""What the tests of placing share: fills with a boundary in space, and surfaces."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np

from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points
from query import Boundary, Fill
from query.expand import expand_pattern
from query.placing import Surface
from query.recognition import is_mesh
from tests.support.query.cases import small_patterns

#: Patterns without a reflex corner: those that convex outlines ask for.
CONVEX = [p for p in small_patterns() if all(count == 1 for count in p.corners)]


def widened(pattern: Pattern, chance: random.Random, widest: int) -> Fill | None:
    """The pattern with random widths, None if that is no mesh."""
    n = pattern.n_chords + pattern.n_loops
    fill = expand_pattern(pattern, [chance.randint(1, widest) for _ in range(n)])
    return fill if is_mesh(fill.quads) else None


def polygon(corners: Points, lengths: Sequence[int]) -> Points:
    """(P, 3) points along the straight sides of a polygon with corners (N, 3)."""
    sides = [np.stack([a, b]) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    points = Boundary.from_polylines(sides, lengths=lengths).points
    assert points is not None
    return points.copy()


def convex_outline(lengths: Sequence[int], chance: random.Random) -> Points:
    """(P, 3) a random convex outline in a random plane: a polygon, or an ellipse if N < 3."""
    rng = np.random.default_rng(chance.randrange(2**32))
    n = len(lengths)
    while True:
        turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, n))
        gaps = np.diff(np.r_[turn, turn[0] + 2.0 * np.pi])
        if n < 3 or (gaps.min() > 0.5 / n and gaps.max() < 0.97 * np.pi):
            break
    if n < 3:
        turn = 2.0 * np.pi * np.arange(sum(lengths)) / sum(lengths)
    flat = np.stack([rng.uniform(0.3, 1.0) * np.cos(turn), np.sin(turn)], axis=1)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    placed = flat @ (axes[:2] * rng.uniform(0.01, 100.0)) + rng.normal(size=3)
    return placed if n < 3 else polygon(placed, lengths)


def grid(columns: int, rows: int) -> Fill:
    """The rectangle of so many quads, as a fill of four sides."""
    square = Pattern.from_code(np.zeros(4, np.uint16))
    fill = expand_pattern(square, (columns, rows))
    return fill if fill.lengths[0] == columns else expand_pattern(square, (rows, columns))


def sphere(levels: int = 4) -> Surface:
    """The unit sphere, an octahedron cut finer so many times."""
    points = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    corners = points[
        [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]]
    ]
    for _ in range(levels):
        middle = corners + np.roll(corners, -1, axis=1)
        middle /= np.linalg.norm(middle, axis=2, keepdims=True)
        a, b, c = (corners[:, e] for e in range(3))
        ab, bc, ca = (middle[:, e] for e in range(3))
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    vertices, name = np.unique(corners.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    return Surface.from_arrays(vertices, name.reshape(-1, 3))


def parallel(surface: Surface, perimeter: int, latitude: float) -> Points:
    """(P, 3) a circle of latitude, in degrees, on the sphere's triangles, eastward."""
    turn = 2.0 * np.pi * np.arange(perimeter) / perimeter
    up = np.radians(latitude)
    circle = np.stack(
        [np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.full(perimeter, np.sin(up))],
        axis=1,
    )
    return surface.nearest(circle).points
