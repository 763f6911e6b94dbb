# Bound by rust/python/src/retopo/quadgrids.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools

def run_all(
    twin: Int32Array, tail: Int32Array, irregular: Bools, border: Bools, marked: Bools
) -> None:
    """"""

def cut_regular(
    twin: Int32Array, tail: Int32Array, irregular: Bools, border: Bools, marked: Bools
) -> None:
    """Cut parts without irregular vertices: across from a vertex of the border, where there is
    one; else from the first vertex along both of its lines.
    """

def follow_marked(
    twin: Int32Array, tail: Int32Array, marked: NDArray[np.bool_], corner: NDArray[np.bool_]
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """"""

def read_grid(twin: Int32Array, tail: Int32Array, h: Index, w: Index, n: Index) -> Int32Array:
    """(n + 1, w + 1) the vertices of the grid of w x n quads whose first row begins with
    half-edge h: row 0 from its start on, ahead of it; rows lie one left of the other.
    """
