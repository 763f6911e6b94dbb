# Bound by rust/python/src/query/holes.rs.
from patterndb.core.halfedge import Int32Array

def turn_quads(quads: Int32Array, first: int, n: int) -> tuple[Int32Array, Int32Array]:
    """Turn quads (q, 4), loop vertices 0 to n - 1, so that vertex 0 becomes ``first``; also the
    quads (n,) at each loop vertex. No quads where a vertex has none, or more than MOST_QUADS.
    """
