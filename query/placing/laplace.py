"""The uniform Laplacian of quads: every vertex that is not held at the mean of its neighbours.

It is solved by conjugate gradients over the neighbours as they stand: for the few hundred vertices
of a fill that is some ten times faster than building and factoring a sparse matrix, and several
right sides go side by side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from patterndb._native.query.placing.laplace import relax_inside
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from query.placing.strands import SidedDisk

if TYPE_CHECKING:
    from scipy.sparse import csc_array

#: Steps per free vertex. In exact arithmetic one each would do; rounding costs a few more.
STEPS_EACH = 4


@dataclass(frozen=True, slots=True, eq=False)
class HeldQuads:
    """Quads of which some vertices are held where they are: what is placed.

    quads: (q, 4) int32. n_held: vertices 0..n_held - 1 are held, such as those of a boundary.
    neighbours: of the quads.
    """

    quads: Int32Array
    n_held: int
    neighbours: Neighbours

    @classmethod
    def of(cls, quads: Int32Array, n_vertices: int, n_held: int) -> HeldQuads:
        """Find the neighbours of quads (q, 4), whose boundary vertices 0..n_held - 1 are held."""
        quads = np.ascontiguousarray(quads)
        return cls(quads, n_held, Neighbours.of(quads, n_vertices, n_held))

    @property
    def n_vertices(self) -> int:
        return self.neighbours.n_vertices

    def place_harmonic(self, values: Points) -> Points:
        """Solve (v, d) values: ``values`` (n_held, d) where held, uniform means elsewhere."""
        return _solve_harmonic(self.neighbours, values)

    def place_centred(self, values: Points) -> Points:
        """As :meth:`place_harmonic`, with a vertex amid every quad that its corners hang on.

        The quads become fans of triangles. Every map of a triangulated disk onto a convex outline
        that takes interior vertices to convex combinations of their neighbours is one to one,
        except for edges that join two vertices of one straight side (Tutte 1963, Floater 2003): no
        quad is flipped, whatever holds the disk together.
        """
        quads, beside, v = self.quads, self.neighbours, self.n_vertices
        middle = v + np.repeat(np.arange(len(quads)), 4)
        around = np.repeat(np.arange(v), np.diff(beside.start))
        tail = np.concatenate([around, quads.ravel(), middle])
        head = np.concatenate([beside.neighbour, middle, quads.ravel()])
        order = np.argsort(tail, kind="stable")
        start = np.r_[0, np.cumsum(np.bincount(tail))].astype(np.int32)
        fans = Neighbours(beside.twin, start, head[order].astype(np.int32), beside.border)
        return _solve_harmonic(fans, values)[:v]

    def build_laplacian(self) -> csc_array:
        """Build (v, v) sparse rows: every vertex less the mean of its neighbours."""
        # Imported here because ranking fills needs no matrices.
        from scipy.sparse import csc_array

        v, beside = self.n_vertices, self.neighbours
        degree = np.diff(beside.start)
        row = np.repeat(np.arange(v), degree)
        values = np.r_[np.ones(v), -1.0 / degree[row]]
        place = np.r_[np.arange(v), row], np.r_[np.arange(v), beside.neighbour]
        return csc_array((values, place), shape=(v, v))


def _solve_harmonic(beside: Neighbours, points: Points) -> Points:
    """(v, d) values that are ``points`` (P, d) on the boundary, and uniform means inside."""
    fixed = np.ascontiguousarray(points, np.float64)
    values = np.empty((beside.n_vertices, fixed.shape[1]))
    values[: len(fixed)] = fixed
    values[len(fixed) :] = fixed.mean(axis=0)
    relax_inside(beside.start, beside.neighbour, len(fixed), values)
    return values


def lay_flat(fill: SidedDisk, points: Points) -> Points:
    """(v, 3) a fill's vertices over the boundary points (P, 3), for ranking many fills.

    Interior vertices at the means of their neighbours: what :func:`query.placing.place` begins
    with, without its checks, repairs and surface, in well under a millisecond.
    """
    return HeldQuads.of(fill.quads, fill.n_vertices, fill.perimeter).place_harmonic(points)
