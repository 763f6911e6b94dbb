"""Remesh a surface evenly: triangles of one size and nearly one shape, for fields to be solved on.

After Botsch and Kobbelt 2004, "A Remeshing Approach to Multiresolution Modeling": long edges are
split, short ones collapsed, edges flipped towards six triangles a vertex, and vertices moved along
the surface, several times over. Borders stay where they are but for their division.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.draft.remesh import (
    collapse_short,
    flip_to_valence,
    mark_border,
    relax,
    split_long,
)
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network.faces import SurfaceParts

#: Rounds of splitting, collapsing, flipping and moving. Source: Botsch and Kobbelt 2004 take five.
ROUNDS = 6

#: Edges longer and shorter than these times the wanted length are split and collapsed. Source:
#: the same.
LONG, SHORT = 4.0 / 3.0, 4.0 / 5.0


#: A vertex moves by so many wanted lengths at most; from further off it stays for this round.
LONGEST_MOVE = 1.0

#: A part gets so many triangles at least, and so many rows of them around, by its area and the
#: diagonal of its box: on eyes and laces of a few edges' size a field has its singularities, too.
FEWEST, AROUND = 300, 8

#: Of more triangles than these, edges of such parts are no shorter than this part of the wanted
#: length: slivers would get millions of them.
MOST_SMALL, LEAST_SHARE = 1000, 0.15

#: Area of an equilateral triangle, in squared edges.
EQUILATERAL = np.sqrt(3.0) / 4.0


def remesh_parts(surface: Surface, edge: float) -> tuple[Points, Int32Array]:
    """(v, 3) vertices and (t, 3) triangles as of :func:`remesh_evenly`, but finer on each part that
    is small or thin against the edge."""
    found = SurfaceParts.of(surface)
    areas = np.bincount(found.part, surface.areas, found.parts)
    corner = surface.vertices[surface.triangles]
    low, high = np.full((found.parts, 3), np.inf), np.full((found.parts, 3), -np.inf)
    np.minimum.at(low, found.part, corner.min(axis=1))
    np.maximum.at(high, found.part, corner.max(axis=1))
    length = np.linalg.norm(high - low, axis=1)
    finest = np.minimum(np.sqrt(areas / (FEWEST * EQUILATERAL)), areas / (AROUND * length))
    floor = np.minimum(np.sqrt(areas / (MOST_SMALL * EQUILATERAL)), LEAST_SHARE * edge)
    finest = np.maximum(finest, floor)
    small = finest < edge
    if not small.any():
        return remesh_evenly(surface, edge)
    points, triangles, n = list[Points](), list[Int32Array](), 0
    large = ~small[found.part]
    pieces = [(large, edge)] if large.any() else []
    pieces += [(found.part == k, float(finest[k])) for k in np.flatnonzero(small).tolist()]
    for which, size in pieces:
        at, corners = remesh_evenly(
            Surface.from_arrays(surface.vertices, surface.triangles[which]).orient(), size
        )
        points.append(at)
        triangles.append(corners + n)
        n += len(at)
    return np.concatenate(points), np.concatenate(triangles).astype(np.int32)


def remesh_evenly(surface: Surface, edge: float) -> tuple[Points, Int32Array]:
    """(v, 3) vertices on a manifold surface, all turned alike, and (t, 3) triangles of this edge.

    The surface's handles and borders are kept: an edge whose collapse would close a tunnel stays,
    whatever its length.
    """
    points, triangles = surface.vertices.copy(), surface.triangles.copy()
    twin = surface.adjacency.across.copy()
    for _ in range(ROUNDS):
        points, triangles, twin = split_long(points, triangles, twin, LONG * edge)
        alive = collapse_short(points, triangles, twin, SHORT * edge, LONG * edge)
        points, triangles, twin = _compact(points, triangles, twin, alive)
        border = mark_border(len(points), triangles, twin)
        for _ in range(2):
            flip_to_valence(points, triangles, twin, border)
        moved, normals = relax(points, triangles, border)
        inner = np.flatnonzero(~border)
        there = surface.nearest_facing(moved[inner], normals[inner]).points
        # What faces so may be far off, at the other end of a limb: a vertex that leaps there draws
        # triangles with it, which are divided, and leap in turn.
        far = np.linalg.norm(there - points[inner], axis=1) > LONGEST_MOVE * edge
        there[far] = points[inner[far]]
        points[inner] = there
    return points, triangles


def _compact(
    points: Points, triangles: Int32Array, twin: Int32Array, alive: NDArray[np.bool_]
) -> tuple[Points, Int32Array, Int32Array]:
    """Leave out what was collapsed."""
    kept = triangles[alive]
    used = np.unique(kept)
    name = np.full(len(points), -1, np.int32)
    name[used] = np.arange(len(used), dtype=np.int32)
    row = np.cumsum(alive, dtype=np.int32) - 1
    sides = twin.reshape(-1, 3)[alive].ravel()
    joined = sides >= 0
    sides[joined] = 3 * row[sides[joined] // 3] + sides[joined] % 3
    return np.ascontiguousarray(points[used]), np.ascontiguousarray(name[kept]), sides
