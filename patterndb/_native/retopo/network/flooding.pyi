# Bound by rust/python/src/retopo.rs.
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
    """Return the triangles around some, breadth first, and their area.

    across: (t, 3) int32, for each side 3 f + e the one that is the same edge seen from the
    neighbour, -1 at a border. crossed: (t,) bool, the triangles of walls. areas: (t,). It ends as
    soon as the area is more than ``most``.
    """
