# Bound by rust/python/src/query/placing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def flood_left(
    beside: Int32Array, barrier: NDArray[np.bool_], voters: Int32Array, sides: NDArray[np.int8]
) -> tuple[NDArray[np.bool_], bool]:
    """(t,) bool, the triangles that a boundary crosses and those on its left, and whether it
    parts them from those on its right.

    beside: (e, 2) triangles with a common edge. barrier: (t,) those that it crosses. voters: (m,)
    triangles next to these, sides: (m,) 1 for those on its left, -1 for those on its right.
    """
