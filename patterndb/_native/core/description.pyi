# Bound by rust/python/src/core.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code

def describe(
    flat: Code, offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.uint16], NDArray[np.int64], int]:
    """Describe canonical codes: code i is flat[offsets[i]:offsets[i + 1]].

    Returns counts (n, k) int32, lists one after another, where each ends, (l n + 1,) int64, and the
    number of the first code that describes no pattern, or -1.
    """
