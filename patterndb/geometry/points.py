"""Name the arrays that geometry passes around, read points, and make vectors of length 1.

Whole numbers have their names in :mod:`patterndb.core.halfedge`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.errors import InvalidBoundaryError, PatternDBError

#: Coordinates: (n, 3) where nothing else is said; also (n, 2), (3,) and stacks of them.
Points = NDArray[np.float64]

#: Other numbers: lengths, weights, parameters.
Floats = NDArray[np.float64]

#: Yes or no for each of something.
Bools = NDArray[np.bool_]


def as_points(
    points: ArrayLike, name: str, error: type[PatternDBError] = InvalidBoundaryError
) -> Points:
    """A (k, 3) float64 copy of (k, 3) or (k, 2) points; raises ``error`` if they are none."""
    try:
        array = np.array(points, np.float64)
    except (TypeError, ValueError) as reason:
        raise error(f"{name} are no list of points [x, y, z]: {reason}") from None
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise error(
            f"{name} have the shape {array.shape}; give [x, y, z] or [x, y] for every point"
        )
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise error(f"point {bad[0]} of {name} is not finite")
    if array.shape[1] == 2:
        array = np.c_[array, np.zeros(len(array))]
    return np.ascontiguousarray(array)


def units(vectors: Points) -> Points:
    """The (n, 3) vectors at length 1; one of no length becomes (0, 0, 1)."""
    length = np.linalg.norm(vectors, axis=1)
    result = np.where(length[:, None] > 0.0, vectors, (0.0, 0.0, 1.0))
    return result / np.where(length > 0.0, length, 1.0)[:, None]


def tangents(normals: Points) -> Points:
    """(n, 2, 3) orthonormal tangents; with the normal (n, 3) they turn counter-clockwise."""
    least = np.abs(normals).argmin(axis=1)
    helper = np.zeros_like(normals)
    helper[np.arange(len(normals)), least] = 1.0
    first = units(np.cross(helper, normals))
    return np.stack([first, np.cross(normals, first)], axis=1)
