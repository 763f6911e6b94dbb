"""Uniform Laplacian: every interior vertex at the mean of its neighbours.

Solved by conjugate gradients over the neighbours as they stand: for the few hundred vertices
of a fill that is some ten times faster than building and factoring a sparse matrix, and
several right sides go side by side.
"""

from __future__ import annotations

import numpy as np

from patterndb._native.query.placing.laplace import relax_inside
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from query.placing.strands import SidedDisk

#: Steps per free vertex. In exact arithmetic one each would do; rounding costs a few more.
STEPS_EACH = 4


def lay_flat(fill: SidedDisk, points: Points) -> Points:
    """(v, 3) a fill's vertices over the boundary points (P, 3), for ranking many fills.

    Interior vertices at the means of their neighbours: what :func:`query.placing.place` begins
    with, without its checks, repairs and surface, in well under a millisecond.
    """
    return solve_harmonic(Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter), points)


def solve_harmonic(beside: Neighbours, points: Points) -> Points:
    """(v, d) values that are ``points`` (P, d) on the boundary, and uniform means inside."""
    fixed = np.ascontiguousarray(points, np.float64)
    values = np.empty((beside.n_vertices, fixed.shape[1]))
    values[: len(fixed)] = fixed
    values[len(fixed) :] = fixed.mean(axis=0)
    relax_inside(beside.start, beside.neighbour, len(fixed), values)
    return values


def solve_centred(quads: Int32Array, beside: Neighbours, points: Points) -> Points:
    """As :func:`solve_harmonic`, with a vertex amid every quad that its corners hang on.

    The quads become fans of triangles. Every map of a triangulated disk onto a convex outline
    that takes interior vertices to convex combinations of their neighbours is one to one, but
    for edges that join two vertices of one straight side (Tutte 1963, Floater 2003): no quad
    is flipped, whatever holds the disk together.
    """
    v = beside.n_vertices
    middle = v + np.repeat(np.arange(len(quads)), 4)
    tail = np.concatenate([np.repeat(np.arange(v), np.diff(beside.start)), quads.ravel(), middle])
    head = np.concatenate([beside.neighbour, middle, quads.ravel()])
    order = np.argsort(tail, kind="stable")
    start = np.r_[0, np.cumsum(np.bincount(tail))].astype(np.int32)
    fans = Neighbours(beside.twin, start, head[order].astype(np.int32), beside.border)
    return solve_harmonic(fans, points)[:v]
