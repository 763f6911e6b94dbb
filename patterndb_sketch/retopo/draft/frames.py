"""Tangent frames of the triangles of a surface, and how directions go from one to the next."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.surface import Surface


@dataclass(frozen=True, eq=False)
class TangentFrames:
    """A frame in each triangle of a manifold surface; side 3 f + e is the edge from corner e.

    surface: the triangles, all turned alike.
    x, y, normal: (t, 3) float64, the frame of every triangle; x runs along its first side.
    side_angle: (t, 3) float64, the direction of every side in its triangle's frame.
    turn:    (3t,) float64: a direction of angle a in a triangle has a + turn beyond a side; 0 at
             borders.
    corner_angle: (t, 3) float64, the angles of the triangles.
    flat:    (t, 3, 2) float64, the corners in the triangle's frame; the first is at 0.
    """

    surface: Surface
    x: Points
    y: Points
    normal: Points
    side_angle: Floats
    turn: Floats
    corner_angle: Floats
    flat: Floats

    @classmethod
    def of(cls, surface: Surface) -> TangentFrames:
        """Of a surface that is manifold and all turned alike."""
        corner = surface.vertices[surface.triangles]
        edge = np.roll(corner, -1, axis=1) - corner
        normal = units(np.cross(edge[:, 0], edge[:, 1]))
        x = units(edge[:, 0])
        y = np.cross(normal, x)
        side = np.arctan2(np.einsum("tec,tc->te", edge, y), np.einsum("tec,tc->te", edge, x))
        across = surface.adjacency.across
        turn = np.where(across >= 0, side.ravel()[across] + np.pi - side.ravel(), 0.0)
        back = -np.roll(edge, 1, axis=1)
        angle = np.arctan2(
            np.linalg.norm(np.cross(edge, back), axis=2), np.einsum("tec,tec->te", edge, back)
        )
        off = corner - corner[:, :1]
        flat = np.stack([np.einsum("tec,tc->te", off, x), np.einsum("tec,tc->te", off, y)], axis=2)
        return cls(surface, x, y, normal, side, turn, angle, np.ascontiguousarray(flat))

    @property
    def vertices(self) -> Points:
        """(v, 3) float64."""
        return self.surface.vertices

    @property
    def triangles(self) -> Int32Array:
        """(t, 3) int32."""
        return self.surface.triangles

    @property
    def across(self) -> Int32Array:
        """(3t,) int32, the side beyond each, -1 at borders."""
        return self.surface.adjacency.across

    @cached_property
    def euler(self) -> int:
        """V - E + F."""
        used = len(np.unique(self.triangles))
        return used - len(self.surface.adjacency.ends) + len(self.triangles)

    @cached_property
    def inner(self) -> NDArray[np.intp]:
        """(s,) sides that are no border."""
        return np.flatnonzero(self.across >= 0)

    @cached_property
    def border_ends(self) -> Int32Array:
        """(2, b) int32, the vertices that sides of borders lead from, and those they lead to."""
        border = self.surface.adjacency.border
        return np.stack(
            [self.triangles.ravel()[border], self.triangles[border // 3, (border % 3 + 1) % 3]]
        )

    @cached_property
    def on_border(self) -> NDArray[np.bool_]:
        """(v,) bool, vertices of borders."""
        found = np.zeros(len(self.vertices), np.bool_)
        found[self.border_ends] = True
        return found

    @cached_property
    def rims(self) -> list[list[int]]:
        """The vertices around every border, the surface on the left."""
        ahead = dict(zip(*self.border_ends.tolist(), strict=True))
        loops: list[list[int]] = []
        left = set(ahead)
        while left:
            loop = [min(left)]
            left.discard(loop[0])
            while (after := ahead.get(loop[-1], -1)) in left:
                loop.append(after)
                left.discard(after)
            loops.append(loop)
        return loops

    @cached_property
    def leaving(self) -> Int32Array:
        """(v,) int32, a side that leaves each vertex; at a border the first counter-clockwise."""
        found = np.full(len(self.vertices), -1, np.int32)
        sides = np.arange(3 * len(self.triangles), dtype=np.int32)[::-1]
        found[self.triangles.ravel()[sides]] = sides
        border = self.surface.adjacency.border
        found[self.triangles.ravel()[border]] = border
        return found

    @cached_property
    def edge_graph(self) -> csr_array:
        """(v, v) lengths of edges."""
        return self._measure_edges(self.surface.adjacency.ends)

    @cached_property
    def inner_graph(self) -> csr_array:
        """(v, v) lengths of edges that are no border: over others nothing is matched."""
        adjacency = self.surface.adjacency
        inner = np.ones(len(adjacency.ends), np.bool_)
        inner[adjacency.edges[adjacency.border]] = False
        return self._measure_edges(adjacency.ends[inner])

    def _measure_edges(self, ends: Int32Array) -> csr_array:
        length = np.linalg.norm(self.vertices[ends[:, 0]] - self.vertices[ends[:, 1]], axis=1)
        n = len(self.vertices)
        rows, columns = np.concatenate([ends, ends[:, ::-1]]).T
        return coo_array((np.concatenate([length, length]), (rows, columns)), (n, n)).tocsr()

    def list_ring(self, vertex: int) -> list[int]:
        """The sides that leave a vertex, counter-clockwise, one for each of its triangles."""
        ring: list[int] = []
        side = int(self.leaving[vertex])
        while side >= 0 and (not ring or side != ring[0]):
            ring.append(side)
            side = int(self.across[side - side % 3 + (side % 3 + 2) % 3])
        return ring

    def lift(self, triangle: int, angle: float) -> Points:
        """(3,) a direction of a triangle's frame in space."""
        return np.cos(angle) * self.x[triangle] + np.sin(angle) * self.y[triangle]
