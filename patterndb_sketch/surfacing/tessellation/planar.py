"""Polygons on an integer grid: exact turns, whether one crosses itself, and its ears.

On integers below GRID every predicate here is exact in 64 bits, so that no polygon, however
noisy, nearly touching or full of vertices in a row on one line, leads to an inverted triangle.
"""

from __future__ import annotations

import math

import numpy as np

from patterndb._native.surfacing.tessellation.planar import (
    clip_ears,
    doubled_area,
    join,
    lay_lattice,
    make_delaunay,
    smooth,
)
from patterndb.core.halfedge import Int64Array
from patterndb_sketch.curvenetwork.network import InvalidNetworkError

#: Coordinates run from 0 to this. A turn is a difference of two products of two differences:
#: below 2**61, so it fits in 64 bits. One step is 1e-9 of the polygon's extent.
GRID = 1 << 30


#: The most points inside one polygon: some seconds, and a mesh that is surely a slip.
MAX_INNER = 1_000_000


def triangulate_polygon(grid: Int64Array) -> tuple[Int64Array, Int64Array]:
    """(tail, twin) of the constrained Delaunay triangulation of a simple polygon (m, 2)."""
    n = 3 * (len(grid) - 2)
    tail, twin = np.empty(n, np.int64), np.empty(n, np.int64)
    clip_ears(grid, len(grid), tail, twin)
    make_delaunay(grid, tail, twin, len(grid) - 2)
    return tail, twin


def fill_polygon(
    grid: Int64Array, tail: Int64Array, twin: Int64Array, spacing: float
) -> tuple[Int64Array, Int64Array, Int64Array]:
    """A triangulated polygon with points inside, about ``spacing`` steps of the grid apart.

    grid: (m, 2) int64, simple, counter-clockwise. tail, twin: its triangulation, see
    :func:`triangulate_polygon`. Returns the points (m + k, 2), the polygon's first, and the
    constrained Delaunay triangulation of all of them. k is 0 where the polygon has no room.

    Raises InvalidNetworkError for more than MAX_INNER points.
    """
    wanted = doubled_area(grid) / (math.sqrt(3.0) * spacing * spacing)
    if wanted > MAX_INNER:
        raise InvalidNetworkError(
            f"the spacing would make {wanted:.3g} points inside one piece; the limit is "
            f"{MAX_INNER:,}, so make it longer"
        )
    inner = lay_lattice(grid, spacing)
    if not len(inner):
        return grid, tail, twin
    at = np.concatenate([grid, inner])
    room = np.empty((2, 3 * (len(grid) - 2 + 2 * len(inner))), np.int64)
    room[0, : len(tail)], room[1, : len(twin)] = tail, twin
    joined = join(at, len(grid), room[0], room[1])
    assert joined == len(at), "a point within the polygon is in none of its triangles"
    smooth(at, len(grid), room[0], room[1])
    return at, room[0], room[1]
