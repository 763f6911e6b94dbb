# Bound by rust/python/src/retopo/network/flooding.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def flood(
    across: Int32Array,
    crossed: NDArray[np.bool_],
    areas: NDArray[np.float64],
    seeds: Int32Array,
    most: float,
) -> tuple[Int32Array, float]:
    """"""
