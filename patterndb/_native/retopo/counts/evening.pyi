# Bound by rust/python/src/retopo/counts/evening.rs.
from patterndb.core.halfedge import Int32Array

def tie_sides(
    first_side: Int32Array,
    first_chain: Int32Array,
    chains: Int32Array,
    pinned: Int32Array,
    least: Int32Array,
) -> Int32Array:
    """"""
