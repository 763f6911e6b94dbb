# Bound by rust/python/src/query.rs.
from patterndb.core.halfedge import Int32Array

def weld_quads(quads: Int32Array, n_vertices: int, perimeter: int) -> tuple[Int32Array, int]:
    """Return the half-edges of welded quads, and a fault: an index into FAULTS, 0 if none."""

def read_code(quads: Int32Array, twin: Int32Array, closed: bool) -> Int32Array:
    """Return the code of quads, see :func:`query.recognition.hash_quads`."""

def lengths(twin: Int32Array, head: Int32Array) -> Int32Array:
    """Edges along every side of the blocks, whose sides begin at the half-edges ``head``."""
