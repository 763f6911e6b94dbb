"""Who is beside whom in a fill: half-edges and neighbours, straight from its quads.

Interactive ranking lays out hundreds of fills at once, so this is compiled; and vertices
keep the numbers that the fill gives them, which :class:`patterndb.core.quadmesh.QuadMesh` does not
promise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.geometry.neighbours import join
from patterndb.core.halfedge import Int32Array


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


def mean_of_neighbours(
    start: Int32Array, neighbour: Int32Array, values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(v, d) mean of the values (v, d) at every vertex's neighbours."""
    total = np.add.reduceat(values[neighbour], start[:-1].astype(np.int64), axis=0)
    return total / np.diff(start)[:, None]
