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
    def on_border(self) -> NDArray[np.bool_]:
        """(v,) bool, vertices of borders."""
        found = np.zeros(len(self.vertices), np.bool_)
        border = self.surface.adjacency.border
        found[self.triangles.ravel()[border]] = True
        found[self.triangles[border // 3, (border % 3 + 1) % 3]] = True
        return found

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
        ends = self.surface.adjacency.ends
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
