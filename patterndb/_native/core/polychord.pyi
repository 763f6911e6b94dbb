# Bound by rust/python/src/core/polychord.rs.
from patterndb.core.halfedge import Int32Array

def trace(twin: Int32Array) -> tuple[Int32Array, int, int]:
    """Kernel of :func:`polychords`: (polychord of every half-edge, n_open, n in all)."""
