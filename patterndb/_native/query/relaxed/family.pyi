# Bound by rust/python/src/query/relaxed.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code
from query.cancellation import CancelFlag

def grow_patterns(
    most: int, valence: int, max_quads: int, cancelled: CancelFlag
) -> tuple[Code, NDArray[np.int64]]:
    """All patterns that strips grow from one quad, as canonical codes.

    most: the most irregular interior vertices and reflex corners together; valence: the
    greatest of an interior vertex, two less at the boundary; max_quads: larger patterns are
    neither kept nor grown. Returns (flat uint16, (n + 1,) int64 offsets that part it);
    once cancelled, some of them.
    """

def meshes(flat: Code, offsets: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return for each pattern (n,) whether no two edges join the same two vertices when every
    polychord is 1 wide.

    Pattern i has the code flat[offsets[i]:offsets[i + 1]].
    """
