"""Curves and surfaces that a body is made of before its edges are rounded, and grids of quads:
how they are laid between four sides, and welded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points

#: (n,) parameters in [0, 1] to (n, 3) points, or to (n, 2) parameters of a surface.
Curve = Callable[[Floats], Points]

#: Turns a point of one half of the car into that of the other.
MIRROR = np.array([1.0, -1.0, 1.0])

#: Step of the difference quotients, in parameters: the surfaces are smooth, of sizes near 1.
STEP = 1e-5


@dataclass(frozen=True, slots=True)
class Segment:
    """The straight line from start to end, of two or three coordinates."""

    start: Floats
    end: Floats

    def __call__(self, t: Floats) -> Points:
        return self.start + np.asarray(t, float)[:, None] * (self.end - self.start)


def segment(start: ArrayLike, end: ArrayLike) -> Segment:
    return Segment(np.asarray(start, float), np.asarray(end, float))


def bezier(points: ArrayLike) -> Curve:
    """The Bezier curve of (k, 3) control points."""
    control = np.asarray(points, float)
    degree = len(control) - 1
    knots = np.r_[np.zeros(degree + 1), np.ones(degree + 1)]
    return BSpline(knots, control, degree)


def bent(x: Floats, places: ArrayLike, heights: ArrayLike, softness: float) -> Floats:
    """(n,) heights at x of the broken line through (places, heights), smooth to every order.

    softness: the length over which a bend is spread. Both ends are exact. It never overshoots
    as an interpolating spline would.
    """
    places, heights = np.asarray(places, float), np.asarray(heights, float)
    slopes = np.diff(heights) / np.diff(places)

    def raw(at: Floats) -> Floats:
        result = heights[0] + slopes[0] * (at - places[0])
        for place, change in zip(places[1:-1], np.diff(slopes), strict=True):
            result = result + change * softness * np.logaddexp(0.0, (at - place) / softness)
        return result

    off = heights[[0, -1]] - raw(places[[0, -1]])
    return raw(x) + np.interp(x, places[[0, -1]], off)


@dataclass(frozen=True, slots=True, eq=False)
class Coons:
    """The surface between four curves, over (p, q) in the unit square.

    bottom, top: curves over p, at q = 0 and q = 1. left, right: over q, at p = 0 and p = 1.
    bulge:       (3,) displacement of the middle; it fades to none on the four curves.
    outward:     1.0 if dS/dp x dS/dq points out of the body, else -1.0.
    """

    bottom: Curve
    top: Curve
    left: Curve
    right: Curve
    bulge: Floats
    outward: float

    def __call__(self, at: Floats) -> Points:
        """(n, 3) points at the parameters (n, 2)."""
        p, q = at[:, 0], at[:, 1]
        a, b = p[:, None], q[:, None]
        zero, one = np.zeros(1), np.ones(1)
        corners = (
            (1 - a) * ((1 - b) * self.bottom(zero) + b * self.top(zero))
            + a * ((1 - b) * self.bottom(one) + b * self.top(one))
        )  # fmt: skip
        ruled = (1 - b) * self.bottom(p) + b * self.top(p)
        across = (1 - a) * self.left(q) + a * self.right(q)
        return ruled + across - corners + 16 * a * (1 - a) * b * (1 - b) * self.bulge

    def slopes(self, at: Floats) -> tuple[Points, Points]:
        """(n, 3) derivatives by p and by q, as difference quotients within the square."""
        result: list[Points] = []
        for axis in (0, 1):
            low, high = at.copy(), at.copy()
            low[:, axis] = np.maximum(at[:, axis] - STEP, 0.0)
            high[:, axis] = np.minimum(at[:, axis] + STEP, 1.0)
            run = (high - low)[:, axis, None]
            result.append((self(high) - self(low)) / run)
        return result[0], result[1]

    def where(self, target: Points, axes: tuple[int, int], start: Floats) -> Floats:
        """(n, 2) parameters where two coordinates of the surface are the targets' (n, 2).

        Newton's method from start (n, 2); the surfaces are nearly linear there.
        """
        at = start.copy()
        for _ in range(30):
            miss = self(at)[:, axes] - target
            if np.abs(miss).max() < 1e-13:
                break
            dp, dq = self.slopes(np.clip(at, 0.0, 1.0))
            matrix = np.stack([dp[:, axes], dq[:, axes]], axis=2)
            at = at - np.linalg.solve(matrix, miss[:, :, None])[:, :, 0]
        return at


def unit(vectors: Points) -> Points:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def mirrored(curve: Curve) -> Curve:
    return lambda t: curve(t) * MIRROR


def whole(half: Curve) -> Curve:
    """The curve over p in [0, 1] through both halves; ``half`` runs from the middle, p = 0.5."""

    def curve(p: Floats) -> Points:
        points = half(np.abs(2.0 * p - 1.0))
        return np.where((p < 0.5)[:, None], points * MIRROR, points)

    return curve


def symmetric(bottom: Curve, top: Curve, right: Curve, bulge: ArrayLike, outward: float) -> Coons:
    """The surface across both halves of the car; bottom and top run from the middle plane.

    It is smooth across that plane, since it is one surface: p = 0.5 there.
    """
    return Coons(
        whole(bottom), whole(top), mirrored(right), right, np.asarray(bulge, float), outward
    )


def blended(bottom: Points, right: Points, top: Points, left: Points) -> Points:
    """(n, m, d) points between four sides, transfinitely; bottom and top (n, d) run alike, left
    and right (m, d) too."""
    a, c = (_shares(one) for one in (bottom, top))
    b, d = (_shares(one) for one in (left, right))
    # Where the lines of equal share of opposite sides cross.
    u = (a[:, None] + b[None] * (c - a)[:, None]) / (1.0 - (c - a)[:, None] * (d - b)[None])
    v = b[None] + u * (d - b)[None]
    u, v = u[..., None], v[..., None]
    flat = (1 - v) * bottom[:, None] + v * top[:, None] + (1 - u) * left[None] + u * right[None]
    corners = (1 - v) * ((1 - u) * bottom[0] + u * bottom[-1]) + v * (
        (1 - u) * top[0] + u * top[-1]
    )
    return flat - corners


def _shares(points: Points) -> Floats:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.r_[0.0, np.cumsum(steps)]
    return along / along[-1]


def grid_faces(n: int, m: int) -> Int64Array:
    """Quads of an (n, m) grid of points in C order, counter-clockwise for the first axis p."""
    at = np.arange(n * m).reshape(n, m)
    corners = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    return np.stack([one.ravel() for one in corners], axis=1)


def weld(points: Points, tolerance: float) -> tuple[Points, Int64Array]:
    """Points with those nearer than the tolerance made one, and where each went."""
    pairs = KDTree(points).query_pairs(tolerance, output_type="ndarray")
    first = np.arange(len(points))
    np.minimum.at(first, pairs.max(axis=1), pairs.min(axis=1))
    while (first != first[first]).any():
        first = first[first]
    kept, ids = np.unique(first, return_inverse=True)
    return points[kept], ids


def cut(points: Points, faces: Int64Array) -> Int64Array:
    """(2 f, 3) triangles of (f, 4) quads, cut along their shorter diagonals, halves in turn."""
    a, b, c, d = faces.T
    straight = np.linalg.norm(points[a] - points[c], axis=1)
    other = np.linalg.norm(points[b] - points[d], axis=1)
    first = (straight <= other)[:, None]
    one = np.where(first, np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    two = np.where(first, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return np.stack([one, two], axis=1).reshape(-1, 3)


def shrunk(grid: Points, amount: float) -> Points:
    """The grid (n, m, 3) without its first ``amount`` along the first axis, in units of length.

    It never loses its last two rows.
    """
    if amount <= 0.0:
        return grid
    result = grid.copy()
    steps = np.linalg.norm(np.diff(grid, axis=0), axis=2)
    along = np.concatenate([np.zeros((1, grid.shape[1])), np.cumsum(steps, axis=0)])
    columns = np.arange(grid.shape[1])
    keep = np.minimum(amount, 0.45 * along[-1])
    # Rows that are cut off move to the cut; a row apart each, they would be slivers: dropped.
    first = np.minimum((along <= keep).sum(axis=0) - 1, len(grid) - 2)
    share = (keep - along[first, columns]) / np.maximum(steps[first, columns], 1e-12)
    cut_at = grid[first, columns] + share[:, None] * (
        grid[first + 1, columns] - grid[first, columns]
    )
    start = int(first.max())
    result[start] = cut_at
    return result[start:]


def extended(grid: Points, amount: float) -> Points:
    """The grid (n, m, 3) with a row before its first, straight on by ``amount``."""
    if amount <= 0.0:
        return grid
    run = grid[0] - grid[1]
    length = np.linalg.norm(run, axis=1, keepdims=True)
    return np.concatenate([(grid[0] + amount * run / np.maximum(length, 1e-12))[None], grid])
