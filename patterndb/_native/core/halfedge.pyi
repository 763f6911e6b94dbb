# Bound by rust/python/src/core.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array

def fans(twin: Int32Array) -> tuple[Int32Array, int]:
    """Vertex of every corner, one per fan of edge-connected quads.

    twin: (4q,) int32. Returns (4q,) int32 vertex ids in order of first appearance and
    their number. Two fans that touch at one point of the file get two vertices.
    """

def border_vertices(twin: Int32Array, vertex: Int32Array, n_vertices: int) -> NDArray[np.bool_]:
    """(n_vertices,) bool: does the vertex lie on a border edge?"""

def next_border_edge(twin: Int32Array, h: Index) -> Index:
    """The border half-edge that follows border half-edge h along the border."""
