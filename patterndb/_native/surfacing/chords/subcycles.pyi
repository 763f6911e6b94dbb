# Bound by rust/python/src/surfacing.rs.
from patterndb.core.halfedge import Int64Array

def counted(n: int, chords: Int64Array) -> int:
    """Count the subcycles that sets of compatible chords (c, 2) make of a cycle of n vertices."""
