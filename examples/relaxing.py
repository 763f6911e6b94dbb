"""Relaxing a quad mesh: even out the points while they stay on a shape."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from modelling import Points, Quads
from scipy.sparse import coo_array, csr_array, diags_array

Distance = Callable[[Points], Points]
"""A signed distance, or anything with its zero set and slope: (n, 3) -> (n,), negative inside."""


def edges_of(quads: Quads) -> Quads:
    """The undirected edges, each once, shape (k, 2)."""
    both = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.unique(np.sort(both, axis=1), axis=0)


def averaging(points: Points, quads: Quads, *, half: bool = False) -> csr_array:
    """The matrix that replaces each point by the mean of its neighbours, shape (n, n).

    With ``half`` the mesh is the half x >= 0 of a symmetric one: a neighbour off the plane counts
    twice at a point on the plane, for itself and for its image.
    """
    count = len(points)
    edges = edges_of(quads)
    rows, columns = np.vstack([edges, edges[:, ::-1]]).T
    weights = np.ones(len(rows))
    if half:
        plane = np.abs(points[:, 0]) < 1e-9
        weights[plane[rows] & ~plane[columns]] = 2.0
    matrix = coo_array((weights, (rows, columns)), shape=(count, count)).tocsr()
    total = np.maximum(np.asarray(matrix.sum(axis=1)).ravel(), 1e-12)
    return csr_array(diags_array(1.0 / total) @ matrix)


def project(points: Points, distance: Distance, steps: int = 4) -> Points:
    """Moves points (n, 3) on to the zero set of ``distance`` along its gradient (Newton)."""
    h = 1e-4
    for _ in range(steps):
        value = distance(points)
        offsets = np.eye(3) * h
        gradient = np.stack(
            [(distance(points + o) - distance(points - o)) / (2 * h) for o in offsets], axis=1
        )
        slope = np.maximum((gradient**2).sum(axis=1), 1e-6)
        step = np.clip(value / slope, -0.2, 0.2)
        points = points - gradient * step[:, None]
    return points


def relax(
    points: Points,
    quads: Quads,
    free: Iterable[int],
    distance: Distance | None = None,
    *,
    steps: int = 100,
    rate: float = 0.5,
    half: bool = False,
) -> Points:
    """Moves the ``free`` points towards the mean of their neighbours, on the shape if one is given.

    Every other point stays. With ``half``, points on the plane x = 0 stay on it.
    """
    points = points.copy()
    moving = np.array(sorted(free), dtype=np.int64)
    plane = moving[np.abs(points[moving, 0]) < 1e-9]
    mean = averaging(points, quads, half=half)[moving]
    for _ in range(steps):
        points[moving] += rate * (mean @ points - points[moving])
        if half:
            points[plane, 0] = 0.0
        if distance is not None:
            points[moving] = project(points[moving], distance, steps=1)
            if half:
                points[plane, 0] = 0.0
    return points
