# Bound by rust/python/src/query/solving.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code

def meshes(flat: Code, offsets: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return for each pattern (n,) whether no two edges join the same two vertices when every
    polychord is 1 wide.

    Pattern i has the code flat[offsets[i]:offsets[i + 1]].
    """
