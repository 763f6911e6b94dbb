# Bound by rust/python/src/core/description.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code

def describe(
    flat: Code, offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.uint16], NDArray[np.int64], int]:
    """"""
