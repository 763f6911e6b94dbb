# Bound by rust/python/src/core.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code
from patterndb.core.halfedge import Int32Array

def smallest_key(code: Code, clockwise: bool) -> tuple[NDArray[np.int32], Int32Array]:
    """The smallest key of a pattern, or of its mirror image.

    code: (4q,) uint16. Returns ((3q,) int32 faces, -1 at the border; (4q,) int32 half-edges
    numbered as in the key).
    """

def survey(twin: Int32Array) -> tuple[Int32Array, NDArray[np.bool_], Int32Array, int, int]:
    """What the columns tell of a disk, given by its half-edges from the start corner on.

    Returns (p,) the polychord of every boundary edge and (p,) whether a corner comes before
    it, from half-edge 0 on; (i,) the irregular vertices' valences; the number of vertices,
    and of reflex corners.
    """
