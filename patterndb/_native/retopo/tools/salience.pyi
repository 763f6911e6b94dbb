# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points

def sum_dots(
    at: Points,
    up: Points,
    points: Points,
    normals: Points,
    tensors: Points,
    low: Points,
    keys: Int64Array,
    starts: Int64Array,
    width: float,
) -> NDArray[np.float64]:
    """(n, 4, 6) weighted sums over the dots near each point: of their tensors, and of these
    times x, y and z of the way from the point to the dot.
    """
