# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def find_irregular(first_side: Int32Array, lengths: Int32Array) -> NDArray[np.bool_]:
    """Return for each patch (p,) whether it has no regular fill.

    lengths: of all sides; those of patch f are first_side[f] to first_side[f + 1].
    """

def is_cheap(lengths: Int32Array, low: int, high: int) -> bool:
    """:func:`has_regular_fill` of lengths[low:high]."""
