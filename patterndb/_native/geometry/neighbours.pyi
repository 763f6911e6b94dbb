# Bound by rust/python/src/geometry.rs.
from patterndb.core.halfedge import Int32Array

def join(
    quads: Int32Array, n_vertices: int, perimeter: int
) -> tuple[Int32Array, Int32Array, Int32Array, Int32Array]:
    """Return twin, start, neighbour and border; see patterndb.geometry.neighbours.Neighbours."""
