"""What lies beside what on a surface: triangles across edges, and vertices along them.

Surfaces are taken as they are: an edge may have any number of triangles, and neighbours may
be turned against each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb._native.retopo.ground.topology import pair_sides
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import edge_keys


@dataclass(frozen=True, slots=True, eq=False)
class GroundTopology:
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
    def of(cls, vertices: Points, triangles: Int32Array) -> GroundTopology:
        """Of (v, 3) vertices and (t, 3) triangles, each with an area."""
        key = edge_keys(triangles)
        order = np.argsort(key, kind="stable")
        ranked = key[order]
        first = np.flatnonzero(np.r_[True, ranked[1:] != ranked[:-1]])
        start = np.r_[first, len(key)].astype(np.int32)
        edges = np.empty(len(key), np.int32)
        edges[order] = np.repeat(np.arange(len(first), dtype=np.int32), np.diff(start))
        ends = np.stack([ranked[first] >> 32, ranked[first] & 0xFFFFFFFF], axis=1).astype(np.int32)
        sides = order.astype(np.int32)
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
