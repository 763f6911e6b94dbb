"""A model made ready to be drawn: smooth where it is smooth, whatever the sense of its faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel

#: Cosines of the angles between two faces up to which they are shaded as one smooth surface, and
#: from which on there is a crease between them: 28 and 46 degrees. Between, a bit of both.
SMOOTH, CREASED = float(np.cos(np.radians(28.0))), float(np.cos(np.radians(46.0)))


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """A model's triangles as they are shaded.

    corners: (t, 3, 3) float64. normals: (t, 3, 3) float64 unit normals at the corners, all on the
    side that the triangle's own corners give it; zeros where a triangle has no area.
    """

    corners: Points
    normals: Points

    @classmethod
    def of(cls, corners: Points, triangles: Int32Array) -> Skin:
        """Of triangles (t, 3) with corners (t, 3, 3), which know no inside and no outside."""
        return cls(corners, smooth_normals(corners, triangles))


def smooth_normals(corners: Points, triangles: Int32Array) -> Points:
    """(t, 3, 3) unit normals at the corners (t, 3, 3) of triangles (t, 3).

    At each corner the mean, by area, of the triangles around that lie nearly flat beside its
    own; those that look the other way count as if they were turned.
    """
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(own, axis=1)
    unit = own / np.where(area > 0.0, area, 1.0)[:, None]
    order = np.argsort(triangles.ravel(), kind="stable")
    count = np.bincount(triangles.ravel())
    offsets = np.concatenate([[0], np.cumsum(count)])
    around = (order // 3).astype(np.int32)
    return _blended(np.ascontiguousarray(triangles), offsets, around, unit, area, SMOOTH, CREASED)


@kernel
def _blended(
    triangles: Int32Array,
    offsets: NDArray[np.int64],
    around: Int32Array,
    unit: Points,
    area: Floats,
    smooth: float,
    creased: float,
) -> Points:
    """See :func:`smooth_normals`; around: triangles of vertex v from offsets[v] on."""
    result = np.zeros((len(triangles), 3, 3))
    for t in range(len(triangles)):
        for c in range(3):
            x = 0.0
            y = 0.0
            z = 0.0
            v = triangles[t, c]
            for k in range(offsets[v], offsets[v + 1]):
                u = around[k]
                d = unit[t, 0] * unit[u, 0] + unit[t, 1] * unit[u, 1] + unit[t, 2] * unit[u, 2]
                share = min(max((abs(d) - creased) / (smooth - creased), 0.0), 1.0)
                weight = area[u] * share if d >= 0.0 else -area[u] * share
                x += weight * unit[u, 0]
                y += weight * unit[u, 1]
                z += weight * unit[u, 2]
            size = np.sqrt(x * x + y * y + z * z)
            if size > 0.0:
                result[t, c, 0] = x / size
                result[t, c, 1] = y / size
                result[t, c, 2] = z / size
    return result
