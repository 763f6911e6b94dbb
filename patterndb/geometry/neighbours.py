"""Who is beside whom in a fill: half-edges and neighbours, straight from its quads.

Interactive ranking lays out hundreds of fills at once, so this is one kernel; and vertices
keep the numbers that the fill gives them, which :class:`patterndb.core.quadmesh.QuadMesh` does not
promise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """The edges of a fill.

    twin:      (4q,) int32, see :mod:`patterndb.core.halfedge`.
    start:     (v + 1,) int32; the neighbours of vertex i are
    neighbour: (2e,) int32 ``neighbour[start[i]:start[i + 1]]``.
    border:    (P,) int32, the half-edge that leaves each boundary vertex along the boundary.
    """

    twin: Int32Array
    start: Int32Array
    neighbour: Int32Array
    border: Int32Array

    @classmethod
    def of(cls, quads: Int32Array, n_vertices: int, perimeter: int) -> Neighbours:
        """Of (q, 4) quads whose boundary vertices are 0..perimeter - 1, in order."""
        return cls(*join(quads, n_vertices, perimeter))

    @property
    def n_vertices(self) -> int:
        return len(self.start) - 1


@kernel
def join(
    quads: Int32Array, n_vertices: int, perimeter: int
) -> tuple[Int32Array, Int32Array, Int32Array, Int32Array]:
    """Kernel of :class:`Neighbours`: (twin, start, neighbour, border)."""
    n = 4 * len(quads)
    tail = quads.reshape(n)
    first = np.zeros(n_vertices + 1, np.int32)
    for h in range(n):
        first[tail[h] + 1] += 1
    for i in range(n_vertices):
        first[i + 1] += first[i]
    leaving = np.empty(n, np.int32)
    place = first[:-1].copy()
    for h in range(n):
        leaving[place[tail[h]]] = h
        place[tail[h]] += 1
    twin = np.full(n, -1, np.int32)
    degree = np.zeros(n_vertices + 1, np.int32)
    border = np.full(perimeter, -1, np.int32)
    for h in range(n):
        a = tail[h]
        b = tail[(h & ~3) | ((h + 1) & 3)]
        for k in range(first[b], first[b + 1]):
            g = leaving[k]
            if tail[(g & ~3) | ((g + 1) & 3)] == a:
                twin[h] = g
                break
        degree[a + 1] += 1
        if twin[h] < 0:
            degree[b + 1] += 1
            if a < perimeter:
                border[a] = h
    start = np.zeros(n_vertices + 1, np.int32)
    for v in range(n_vertices):
        start[v + 1] = start[v] + degree[v + 1]
    neighbour = np.empty(start[-1], np.int32)
    place = start[:-1].copy()
    for h in range(n):
        a = tail[h]
        b = tail[(h & ~3) | ((h + 1) & 3)]
        neighbour[place[a]] = b
        place[a] += 1
        if twin[h] < 0:
            neighbour[place[b]] = a
            place[b] += 1
    return twin, start, neighbour, border


def mean_of_neighbours(
    start: Int32Array, neighbour: Int32Array, values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(v, d) mean of the values (v, d) at every vertex's neighbours."""
    total = np.add.reduceat(values[neighbour], start[:-1].astype(np.int64), axis=0)
    return total / np.diff(start)[:, None]
