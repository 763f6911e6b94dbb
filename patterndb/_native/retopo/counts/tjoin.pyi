# Bound by rust/python/src/retopo.rs.
from patterndb.core.halfedge import Int32Array, Int64Array

def match(weights: Int64Array) -> Int32Array:
    """Return the cheapest perfect matching of n vertices, (n,) partners.

    weights: (n, n) int64, symmetric; n is even.
    """
