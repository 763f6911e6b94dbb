# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def crossings(
    corners: Points,
    triangles: NDArray[np.int64],
    owner: NDArray[np.int64],
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
) -> NDArray[np.int64]:
    """(p, 2) pairs of crossing triangles (t, 3, 3), found down the tree of their boxes."""
