"""Grids of quads between four sides, and how they are welded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points


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


def weld(points: Points, tolerance: float) -> tuple[Points, NDArray[np.int64]]:
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
