# Bound by rust/python/src/query.rs.
from patterndb.core.halfedge import Int32Array

def expand_quads(
    twin: Int32Array, across: Int32Array, perimeter: int, first: int, mirrored: bool
) -> tuple[Int32Array, int]:
    """Return the (q, 4) int32 quads of an expanded pattern, and the number of vertices.

    twin: (4p,) int32 half-edges of the pattern, half-edge 0 on the border; across: (4p,)
    int32 width of the polychord that crosses each half-edge; perimeter: of the expanded
    pattern. Its boundary vertex ``first``, counted from the tail of half-edge 0, becomes
    vertex 0; mirrored, the vertices before it follow, and quads are turned over.
    """
