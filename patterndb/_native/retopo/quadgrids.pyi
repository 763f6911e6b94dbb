# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools

def run_all(
    twin: Int32Array, tail: Int32Array, irregular: Bools, border: Bools, marked: Bools
) -> None:
    """Mark the curves that leave irregular vertices, until they meet another irregular vertex, the
    border or a marked edge.

    twin, tail: (4q,) int32. irregular, border: (v,) bool. marked: (4q,) bool, written.
    """

def cut_regular(
    twin: Int32Array, tail: Int32Array, irregular: Bools, border: Bools, marked: Bools
) -> None:
    """Cut parts without irregular vertices: across from a vertex of the border, where there is
    one; else from the first vertex along both of its lines.
    """

def follow_marked(
    twin: Int32Array, tail: Int32Array, marked: NDArray[np.bool_], corner: NDArray[np.bool_]
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """Follow marked edges from corner to corner.

    twin, tail: (4q,) int32. marked: (4q,) bool. corner: (v,) bool. Returns the half-edges of all
    curves one after another, (k + 1,) where each curve begins, and (4q,) the half-curve of each
    half-edge, -1 for none.
    """

def read_grid(twin: Int32Array, tail: Int32Array, h: Index, w: Index, n: Index) -> Int32Array:
    """(n + 1, w + 1) the vertices of the grid of w x n quads whose first row begins with
    half-edge h: row 0 from its start on, ahead of it; rows lie one left of the other.
    """
