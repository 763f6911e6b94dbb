"""The adjacency of a surface: triangles across edges, and vertices along them.

Surfaces are taken as they are: an edge may have any number of triangles, and neighbours may be
turned against each other; :func:`orient_triangles` turns them alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb._native.geometry.adjacency import pair_sides, walk_parts
from patterndb.core.halfedge import Int32Array, list_pairs, sort_by_edge
from patterndb.geometry.points import Points

#: If more than this part of a component's area is turned one way, that way is meant, even inward,
#: as around a hollow; else a closed component is turned outward.
MEANT = 2.0 / 3.0


def list_sides(triangles: Int32Array) -> tuple[Int32Array, Int32Array]:
    """Return (3t,) the tail and (3t,) the head of every side 3 f + e."""
    return triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()


@dataclass(frozen=True, slots=True, eq=False)
class Adjacency:
    """Side 3 f + e is the edge of triangle f from its corner e to the next.

    across:     (3t,) int32, the side that is the same edge seen from the neighbour; -1 at a
                border. Where more than two triangles share an edge, those that continue each
                other most straightly are neighbours, of those that are turned alike if there are.
    edges:      (3t,) int32, the number of a side's edge.
    ends:       (e, 2) int32, the two vertices of an edge, the lower first.
    middles:    (e, 3) float64, the middle of an edge.
    side_start: (e + 1,) int32 and
    sides:      (3t,) int32: sides of edge k are sides[side_start[k]:side_start[k + 1]].
    star_start: (v + 1,) int32 and
    star:       (2e,) int32: the neighbours of vertex i are star[star_start[i]:star_start[i + 1]].
    """

    across: Int32Array
    edges: Int32Array
    ends: Int32Array
    middles: Points
    side_start: Int32Array
    sides: Int32Array
    star_start: Int32Array
    star: Int32Array

    @classmethod
    def of(cls, vertices: Points, triangles: Int32Array) -> Adjacency:
        """Of (v, 3) vertices and (t, 3) triangles, each with an area."""
        tail, head = list_sides(triangles)
        order, first = sort_by_edge(tail, head)
        sides, start = order.astype(np.int32), first.astype(np.int32)
        edges = np.empty(len(sides), np.int32)
        edges[order] = np.repeat(np.arange(len(start) - 1, dtype=np.int32), np.diff(start))
        one = order[first[:-1]]
        ends = np.stack([np.minimum(tail, head)[one], np.maximum(tail, head)[one]], axis=1)
        both = np.concatenate([ends, ends[:, ::-1]])
        around = np.argsort(both[:, 0], kind="stable")
        counts = np.bincount(both[:, 0], minlength=len(vertices))
        star_start = np.r_[0, np.cumsum(counts)].astype(np.int32)
        star = np.ascontiguousarray(both[around, 1])
        across = pair_sides(np.ascontiguousarray(vertices), triangles, start, sides)
        middles = vertices[ends].mean(axis=1)
        return cls(across, edges, ends, middles, start, sides, star_start, star)

    @property
    def border(self) -> Int32Array:
        """(b,) int32, the sides with no triangle across."""
        return np.flatnonzero(self.across < 0).astype(np.int32)


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
    sides, others = list_pairs(*list_sides(triangles)).T
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
    sides, others = list_pairs(*list_sides(result)).T
    corner = result.ravel()
    left = sides[corner[sides] == corner[others]].astype(np.int32)
    return TurnedTriangles(result, turned, left)
