# Bound by rust/python/src/retopo/ground/orientation.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def walk_parts(across: Int32Array, corner: Int32Array) -> tuple[Int32Array, NDArray[np.bool_]]:
    """(t,) the part of every triangle, and (t,) is it turned over against its part's first one?"""
