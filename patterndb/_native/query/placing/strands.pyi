# Bound by rust/python/src/query/placing/strands.rs.
from patterndb.core.halfedge import Int32Array

def walk(twin: Int32Array, first: int) -> Int32Array:
    """"""

def find_far_ends(twin: Int32Array, border: Int32Array) -> Int32Array:
    """(P,) the position of the boundary edge where the strand from each boundary edge ends."""
