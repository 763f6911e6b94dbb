"""Triangles and quads in space: how quads are cut into triangles, areas, and crossings."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.geometry.tree import build
from patterndb._native.surfacing.tessellation.intersections import crossings
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points, as_points


def area(points: ArrayLike, faces: ArrayLike) -> float:
    """Sum the area of triangles (f, 3) or quads (f, 4) of points (v, 3), in squared units.

    A quad counts as :func:`split_quads` cuts it. Raises InvalidMeshError as that does.
    """
    at, triangles, _ = split_quads(points, faces)
    return float(_doubled_areas(at[triangles]).sum()) / 2.0


def split_quads(
    points: ArrayLike, faces: ArrayLike
) -> tuple[Points, NDArray[np.int64], NDArray[np.int64]]:
    """Cut quads (f, 4) of points (v, 3) into triangles; triangles (f, 3) stay as they are.

    A quad is cut along the diagonal that gives less area, which is the inner one where it is
    planar and concave; of equals the shorter, then the one from its first corner. Returns the
    points as (v, 3) float64, the triangles (t, 3) int64, and the face (t,) of each. Raises
    InvalidMeshError for points that are none and faces that are neither or name no point.
    """
    at = as_points(points, "the mesh's points", InvalidMeshError)
    polygons = np.asarray(faces)
    if polygons.ndim != 2 or polygons.shape[1] not in (3, 4):
        raise InvalidMeshError(
            f"faces have the shape {polygons.shape}; give triangles (f, 3) or quads (f, 4)"
        )
    if not np.issubdtype(polygons.dtype, np.integer):
        raise InvalidMeshError(f"faces are numbers of points, not {polygons.dtype}")
    bad = np.flatnonzero(((polygons < 0) | (polygons >= len(at))).any(axis=1))
    if len(bad):
        raise InvalidMeshError(f"face {bad[0]} names a point outside 0..{len(at) - 1}")
    polygons = np.ascontiguousarray(polygons, np.int64)
    if polygons.shape[1] == 3:
        return at, polygons, np.arange(len(polygons))
    ways = np.array([[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]])
    corners = at[polygons]
    areas = np.stack([_doubled_areas(corners[:, way]).sum(axis=1) for way in ways])
    diagonals = np.stack(
        [np.linalg.norm(corners[:, i + 2] - corners[:, i], axis=1) for i in (0, 1)]
    )
    equal = np.isclose(areas[0], areas[1], rtol=1e-12, atol=0.0)
    second = np.where(equal, diagonals[1] < diagonals[0] * (1.0 - 1e-12), areas[1] < areas[0])
    way = ways[second.astype(np.int64)]
    rows = np.arange(len(polygons))
    triangles = polygons[rows[:, None, None], way].reshape(-1, 3)
    return at, triangles, np.repeat(rows, 2)


def _doubled_areas(corners: Points) -> Points:
    """(...,) twice the areas of triangles (..., 3, 3)."""
    u = corners[..., 1, :] - corners[..., 0, :]
    return np.linalg.norm(np.cross(u, corners[..., 2, :] - corners[..., 0, :]), axis=-1)


def find_self_intersections(points: ArrayLike, faces: ArrayLike) -> NDArray[np.int64]:
    """Find the (p, 2) pairs of faces that cross, each in rising order, sorted.

    points: (v, 3); faces: (f, 3) triangles or (f, 4) quads, which count as
    :func:`split_quads` cuts them. Two
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
