"""Turn the triangles of a surface alike, where neighbours are turned against each other.

Files of scans and of joined parts come so. Left and right, above and below would change from
triangle to triangle: no patch is seen, and strokes miss the surface along their normals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.ground.orientation import walk_parts
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import edge_keys

#: If more than this part of a part's area is turned one way, that way is meant, even inward, as
#: around a hollow; else a closed part is turned outward.
MEANT = 2.0 / 3.0


@dataclass(frozen=True, slots=True, eq=False)
class TurnedTriangles:
    """triangles: (t, 3) int32, turned alike. turned: (k,) int32, those that were turned over.

    onesided: (s,) int32, sides at which triangles still are against each other: there the surface
    has one side only, as a Moebius strip.
    """

    triangles: Int32Array
    turned: Int32Array
    onesided: Int32Array


def orient_triangles(vertices: Points, triangles: Int32Array) -> TurnedTriangles:
    """Turn triangles (t, 3) alike, part by part, over edges that have exactly two of them.

    What is alike already stays as it is. Of a part that is not, the way of most of its area is
    taken, or outward where neither is; see :data:`MEANT`.
    """
    none = np.empty(0, np.int32)
    sides, others = _find_pairs(triangles)
    corner = triangles.ravel()
    # Two that are turned alike pass their edge in opposite ways.
    against = corner[sides] == corner[others]
    if not against.any():
        return TurnedTriangles(triangles, none, none)
    across = np.full(3 * len(triangles), -1, np.int32)
    across[sides], across[others] = others, sides
    part, over = walk_parts(across, corner)
    doubled = np.cross(
        vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
        vertices[triangles[:, 2]] - vertices[triangles[:, 0]],
    )
    areas = 0.5 * np.linalg.norm(doubled, axis=1)
    sign = np.where(over, -1.0, 1.0)
    whole = np.bincount(part, areas)
    kept = np.bincount(part, areas * ~over)
    middle = vertices.mean(axis=0)
    volume = np.einsum("tc,tc->t", doubled, vertices[triangles[:, 0]] - middle) * sign
    outward = np.bincount(part, volume)
    closed = np.bincount(part, (across.reshape(-1, 3) < 0).any(axis=1)) == 0
    # Where neither way is meant, and no volume tells, the first triangle's way is.
    other_way = np.where(closed, outward < 0.0, kept < 0.5 * whole)
    other_way = np.where(kept > MEANT * whole, False, other_way)
    other_way = np.where(kept < (1.0 - MEANT) * whole, True, other_way)
    turned = np.flatnonzero(over ^ other_way[part]).astype(np.int32)
    result = triangles.copy()
    result[turned] = result[turned][:, [0, 2, 1]]
    sides, others = _find_pairs(result)
    corner = result.ravel()
    left = sides[corner[sides] == corner[others]].astype(np.int32)
    return TurnedTriangles(result, turned, left)


def _find_pairs(triangles: Int32Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(k,) and (k,) the two sides, 3 f + e, of every edge that has exactly two."""
    key = edge_keys(triangles)
    order = np.argsort(key, kind="stable")
    ranked = key[order]
    first = np.flatnonzero(np.r_[True, ranked[1:] != ranked[:-1]])
    two = first[np.diff(np.r_[first, len(key)]) == 2]
    return order[two], order[two + 1]
