# Bound by rust/python/src/query/solving/halves.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def find_transport(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    flow: Int32Array,
) -> bool:
    """Find a flow over the open classes; False where there is none.

    slack: (w,); closed: (m,). flow: (2, m) int32, overwritten: units of class k from i to
    j, and from j to i (0 where i = j).
    """
