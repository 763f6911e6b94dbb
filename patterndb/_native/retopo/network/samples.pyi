# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def find_nearest(
    points: Points,
    normals: Points,
    starts: Int32Array,
    loose: NDArray[np.bool_],
    at: NDArray[np.float64],
    up: NDArray[np.float64],
) -> tuple[int, float, float]:
    """First sample of the nearest segment, -1 for none, the part of it, and the distance."""
