# Bound by rust/python/src/retopo/counts/tjoin.rs.
from patterndb.core.halfedge import Int32Array, Int64Array

def match(weights: Int64Array) -> Int32Array:
    """"""
