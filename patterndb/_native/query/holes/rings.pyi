# Bound by rust/python/src/query/holes.rs.
from patterndb.core.halfedge import Int32Array

def pave(corners: Int32Array, rings: int) -> tuple[Int32Array, Int32Array, Int32Array, int]:
    """Lay rings: quads, the loop that is left, the quads at each vertex of it, and how many
    vertices; 0 where that cannot be.

    A ring is laid quad by quad along a front, which is the loop at first. A vertex of the loop that
    lacks one quad gets it between the front's edges before and after; where none does, a quad is
    laid behind an edge of the front. Before the next ring, vertices with four quads are closed: the
    two edges of the front there become one.
    """
