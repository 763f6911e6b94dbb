# Bound by rust/python/src/query.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code

def grow_patterns(most: int, valence: int, max_quads: int) -> tuple[Code, NDArray[np.int64]]:
    """All patterns that strips grow from one quad, as canonical codes.

    most: the most irregular interior vertices and reflex corners together; valence: the
    greatest of an interior vertex, two less at the boundary; max_quads: larger patterns are
    neither kept nor grown. Returns (flat uint16, (n + 1,) int64 offsets that part it).
    """
