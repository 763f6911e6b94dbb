# Bound by rust/python/src/surfacing/chords/subcycles.rs.
from patterndb.core.halfedge import Int64Array

def counted(n: int, chords: Int64Array) -> int:
    """"""
