# Bound by rust/python/src/query.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array

def split_loop(
    loop: Int32Array, start: int, end: int, inner: Int32Array
) -> tuple[Int32Array, Int32Array]:
    """The two loops into which a chord cuts a loop.

    The chord runs from position ``start`` of the loop over the vertices ``inner`` to
    position ``end``. The left loop begins at ``start``, follows the old loop to ``end`` and
    comes back along the chord; the right one begins at ``end``, follows the old loop to
    ``start`` and comes back. Positions may lie beyond the loop's length: they count on.
    """

def find_best_places(gain: NDArray[np.int64]) -> tuple[Index, Index, Index]:
    """(gain, p, a) of the best rectangle.

    gain: (P/2,) what a pair of opposite corners at p and p + P/2 gains.
    """
