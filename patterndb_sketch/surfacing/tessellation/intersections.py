"""Where a mesh crosses itself: pairs of triangles that go through each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.geometry.tree import build
from patterndb._native.surfacing.tessellation.intersections import crossings
from patterndb_sketch.surfacing.tessellation.triangles import split_quads


def find_self_intersections(points: ArrayLike, faces: ArrayLike) -> NDArray[np.int64]:
    """Find the (p, 2) pairs of faces that cross, each in rising order, sorted.

    points: (v, 3); faces: (f, 3) triangles or (f, 4) quads, which count as
    :func:`patterndb_sketch.surfacing.tessellation.triangles.split_quads` cuts them. Two
    triangles cross if each has corners on both sides of the other's plane and they share a
    stretch of a line, or if they lie in one plane and overlap; both by more than TOUCH of the
    mesh's diagonal. Touching with a corner or an edge is no crossing. So triangles with a
    common corner (the same point number) cross only where they meet elsewhere too, and
    triangles with a common edge only if one is folded flat onto the other. The two halves of a
    quad are not compared. Triangles flatter than THIN of the diagonal are left out.

    Raises InvalidMeshError for points and faces that are none.
    """
    at, triangles, owner = split_quads(points, faces)
    if len(triangles) < 2:
        return np.empty((0, 2), np.int64)
    corners = np.ascontiguousarray(at[triangles])
    box = np.ptp(corners.reshape(-1, 3), axis=0)
    extent = float(box.max())
    if extent == 0.0:
        return np.empty((0, 2), np.int64)
    # About the middle, and with the diagonal as the unit: nothing overflows.
    corners = (corners - corners.mean(axis=(0, 1))) / extent
    corners /= np.linalg.norm(box / extent)
    pairs = owner[crossings(corners, triangles, owner, *build(corners))]
    return np.unique(np.sort(pairs, axis=1), axis=0)
