"""A disk of quads with its boundary in order: what a pattern and a fill have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.code import code_starts
from patterndb._native.core.halfedge import fans, next_border_edge
from patterndb.core.halfedge import Int32Array
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import InvalidMeshError


@dataclass(frozen=True, slots=True, eq=False)
class Disk:
    """Quads that form a closed disk.

    quads:   (q, 4) int32, counter-clockwise. Boundary vertices are 0..P-1 in
             counter-clockwise order, interior ones follow.
    n_vertices: number of vertices.
    perimeter: P, the number of boundary vertices and of boundary edges.
    corners: (N,) int32, the boundary vertices that are corners, ascending; vertex 0 is
             the first of them. Empty where the disk has no corner.
    """

    quads: Int32Array
    n_vertices: int
    perimeter: int
    corners: Int32Array

    @classmethod
    def from_twin(cls, twin: Int32Array, start: int | None = None) -> Disk:
        """Number the vertices from border half-edge ``start`` (default: the first corner's).

        Raises InvalidMeshError if the quads are not a disk.
        """
        twin = np.ascontiguousarray(twin, dtype=np.int32)
        q = len(twin) // 4
        corner, n_vertices = fans(twin)
        n_border = int((twin < 0).sum())
        n_edges = (len(twin) + n_border) // 2
        starts = np.empty(max(len(twin), 1), np.int32)
        n_starts = code_starts(twin, starts)
        connected = not QuadMesh.from_twin(twin).components().any()
        if n_starts == 0 or not connected or n_vertices - n_edges + q != 1:
            raise InvalidMeshError("the quads are not a disk")
        first = int(starts[0]) if start is None else start
        if twin[first] >= 0:
            raise InvalidMeshError(f"half-edge {first} is not on the border: no side starts there")
        loop = [first]
        while (h := int(next_border_edge(twin, loop[-1]))) != first:
            loop.append(h)
        boundary = corner[np.array(loop)]
        if len(loop) != n_border or len(np.unique(boundary)) != n_border:
            raise InvalidMeshError("the quads' border is not one simple loop")
        name = np.full(n_vertices, -1, np.int32)
        name[boundary] = np.arange(n_border, dtype=np.int32)
        inner = np.flatnonzero(name < 0)
        name[inner] = np.arange(n_border, n_vertices, dtype=np.int32)
        quads = name[corner].reshape(-1, 4)
        count = np.bincount(quads.ravel(), minlength=n_vertices)[:n_border]
        return cls(quads, n_vertices, n_border, np.flatnonzero(count != 2).astype(np.int32))

    @property
    def n_quads(self) -> int:
        return len(self.quads)

    @property
    def n_sides(self) -> int:
        """N, the number of sides: the number of corners, 0 for one closed side."""
        return len(self.corners)

    def valence(self) -> NDArray[np.int32]:
        """(n_vertices,) int32 number of quads at every vertex."""
        return np.bincount(self.quads.ravel(), minlength=self.n_vertices).astype(np.int32)

    def corner_counts(self) -> NDArray[np.int32]:
        """(N,) int32 number of quads at every corner: 1 convex, 3 and more reflex."""
        return self.valence()[self.corners]

    def irregular(self) -> NDArray[np.int32]:
        """(i,) int32 interior vertices whose valence is not 4, ascending."""
        inner = self.valence()[self.perimeter :]
        return (np.flatnonzero(inner != 4) + self.perimeter).astype(np.int32)

    def side_lengths(self) -> NDArray[np.int32]:
        """(N,) int32 edges of every side, side s running from corner s to the next.

        Where there is no corner: the one closed side, (1,).
        """
        if len(self.corners) == 0:
            return np.array([self.perimeter], np.int32)
        ends = np.roll(self.corners, -1)
        ends[-1] += self.perimeter
        return ends - self.corners

    def sides(self) -> list[Int32Array]:
        """Vertices along every side, both its corners included."""
        start = self.corners if len(self.corners) else np.zeros(1, np.int32)
        return [
            (np.arange(s, s + n + 1, dtype=np.int32) % self.perimeter)
            for s, n in zip(start.tolist(), self.side_lengths().tolist(), strict=True)
        ]
