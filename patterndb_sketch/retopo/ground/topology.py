"""What lies beside what on a surface: triangles across edges, and vertices along them.

Surfaces are taken as they are: an edge may have any number of triangles, and neighbours may
be turned against each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import edge_keys
from patterndb.system.kernels import kernel


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
        across = _pair_sides(np.ascontiguousarray(vertices), triangles, start, sides)
        middles = vertices[ends].mean(axis=1)
        return cls(across, edges, ends, middles, start, sides, star_start, star)

    @property
    def border(self) -> Int32Array:
        """(b,) int32, the sides with no triangle across."""
        return np.flatnonzero(self.across < 0).astype(np.int32)


@kernel
def _pair_sides(
    vertices: Points, triangles: Int32Array, start: Int32Array, sides: Int32Array
) -> Int32Array:
    """(3t,) :attr:`GroundTopology.across`: of the sides of an edge, the straightest pairs first."""
    across = np.full(len(sides), -1, np.int32)
    for k in range(len(start) - 1):
        n = start[k + 1] - start[k]
        if n == 2:
            one, two = sides[start[k]], sides[start[k] + 1]
            across[one] = two
            across[two] = one
        elif n > 2:
            group = sides[start[k] : start[k + 1]]
            away = np.empty((n, 3))
            for i in range(n):
                _point_away(vertices, triangles, group[i], away[i])
            free = np.ones(n, np.bool_)
            for _ in range(n // 2):
                best = np.inf
                one, two = -1, -1
                for i in range(n):
                    for j in range(i + 1, n):
                        if not (free[i] and free[j]):
                            continue
                        fold = 0.0
                        for c in range(3):
                            fold += away[i, c] * away[j, c]
                        if triangles.ravel()[group[i]] == triangles.ravel()[group[j]]:
                            # Turned against each other: behind all that are not.
                            fold += 4.0
                        if fold < best:
                            best, one, two = fold, i, j
                if one >= 0:
                    free[one] = False
                    free[two] = False
                    across[group[one]] = group[two]
                    across[group[two]] = group[one]
    return across


@kernel
def _point_away(
    vertices: Points, triangles: Int32Array, side: int, away: NDArray[np.float64]
) -> None:
    """Unit direction (3,) from a side into its triangle, at right angles to it."""
    f, e = side // 3, side % 3
    a, b, c = triangles[f, e], triangles[f, (e + 1) % 3], triangles[f, (e + 2) % 3]
    along = 0.0
    size = 0.0
    for k in range(3):
        along += (vertices[c, k] - vertices[a, k]) * (vertices[b, k] - vertices[a, k])
        size += (vertices[b, k] - vertices[a, k]) ** 2
    height = 0.0
    for k in range(3):
        away[k] = vertices[c, k] - vertices[a, k] - along / size * (vertices[b, k] - vertices[a, k])
        height += away[k] ** 2
    if height > 0.0:
        for k in range(3):
            away[k] /= np.sqrt(height)
