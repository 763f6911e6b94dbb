# Bound by rust/python/src/core.rs.
from patterndb.core.halfedge import Int32Array

def trace(twin: Int32Array) -> tuple[Int32Array, int, int]:
    """Return the polychord of every half-edge, the number of open ones, and of all."""
