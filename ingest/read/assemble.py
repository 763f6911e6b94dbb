"""The last check of every reader: a PolygonMesh that holds what it promises."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ingest.read.limits import ReadLimits
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError

_MAX_POINTS = np.iinfo(np.int32).max


def assemble(
    points: NDArray[np.floating],
    corners: NDArray[np.integer],
    arities: NDArray[np.integer],
    path: str | Path,
    limits: ReadLimits,
) -> PolygonMesh:
    """The mesh of points (v, 3), corners (c,) from 0 and arities (f,).

    The text readers have refused by line what is refused here by number alone; for the
    formats that a library reads, this is the check.

    Raises MeshFileError on a coordinate that is not finite, a corner outside 0..v-1, a face
    of fewer than 3 corners or more than the limit, and a mesh without faces.
    """
    if not len(arities):
        raise MeshFileError("the file holds no faces; export polygons, not points", path=path)
    if len(points) > _MAX_POINTS:
        raise MeshFileError(f"{len(points):,} vertices are more than 32 bits can number", path=path)
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        at = int(np.argmin(finite))
        raise MeshFileError(
            f"vertex {at} (counted from 0) is not finite: {points[at].tolist()}; repair it",
            path=path,
        )
    wrong_arity = (arities < 3) | (arities > limits.max_arity)
    if wrong_arity.any():
        face = int(wrong_arity.argmax())
        raise MeshFileError(
            f"face {face} (counted from 0) has {arities[face]} corners; "
            f"3 to {limits.max_arity} are allowed",
            path=path,
        )
    offsets = np.concatenate(([0], np.cumsum(arities, dtype=np.int64)))
    if offsets[-1] != len(corners):
        raise MeshFileError(
            f"the faces need {offsets[-1]} corners, but {len(corners)} are given", path=path
        )
    outside = (corners < 0) | (corners >= len(points))
    if outside.any():
        corner = int(outside.argmax())
        face = int(np.searchsorted(offsets, corner, side="right")) - 1
        raise MeshFileError(
            f"face {face} (counted from 0) names vertex {corners[corner]}, "
            f"but the vertices are 0 to {len(points) - 1}",
            path=path,
        )
    return PolygonMesh(
        points=np.ascontiguousarray(points, dtype=np.float64),
        corners=corners.astype(np.int32),
        offsets=offsets,
    )
