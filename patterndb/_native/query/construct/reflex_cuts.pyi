# Bound by rust/python/src/query.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array

def list_prolongations(
    lengths: Int64Array, counts: Int64Array, most_perimeter: int
) -> tuple[Int64Array, NDArray[np.float64]]:
    """(r, 5) int64 corner k, back, far, w, chord of cuts, and guesses of their irregular vertices.

    The chord ends w edges along side k + far; back: side k is prolonged, else side k - 1.
    """
