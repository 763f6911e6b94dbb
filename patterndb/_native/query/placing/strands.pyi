# Bound by rust/python/src/query/placing.rs.
from patterndb.core.halfedge import Int32Array

def walk(twin: Int32Array, first: int) -> Int32Array:
    """Return the half-edges of the transversal edges from ``first`` on, (k,) int32, each entering
    a quad but for the last one of an open strand, which is the far side of the last quad.

    twin: (4q,) int32.
    """

def find_far_ends(twin: Int32Array, border: Int32Array) -> Int32Array:
    """(P,) the position of the boundary edge where the strand from each boundary edge ends."""
