# Bound by rust/python/src/query.rs.
from patterndb.core.halfedge import Int32Array

def lengths(twin: Int32Array, head: Int32Array) -> Int32Array:
    """Edges along every side of the blocks, whose sides begin at the half-edges ``head``."""
