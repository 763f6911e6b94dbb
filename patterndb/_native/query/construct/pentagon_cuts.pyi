# Bound by rust/python/src/query.rs.
import numpy as np
from numpy.typing import NDArray

def find_pentagon_cuts(
    lengths: NDArray[np.int64], counts: NDArray[np.int64], ample: int
) -> NDArray[np.int64]:
    """The best cut at every side, (k, 4) int64, best first.

    lengths, counts: (n,) edges of the sides and quads at the corners of an outline, n >= 5.
    A cut (side i, u, w, c) takes off the pentagon of u edges of side i, sides i + 1 and
    i + 2, w edges of side i + 3 and a chord of c edges. The three corners between must be
    convex, and at least 2 edges be left of both sides. The best cut leaves the longest
    shortest side, where sides of more than ``ample`` edges count as that long, then has the
    shortest chord: long ones add up from cut to cut, until one side is more than half of
    what is left. Then it leaves more of the sides it cuts, and has u near w.
    """
