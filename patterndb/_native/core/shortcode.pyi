# Bound by rust/python/src/core.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code

def name_once(
    symbols: NDArray[np.int32], offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.int64], int]:
    """What is stored of codes, the (n + 1,) ends of each, and the first that is none, or -1."""

def name_twice(
    raw: NDArray[np.uint8], ends: NDArray[np.int64]
) -> tuple[Code, NDArray[np.int64], int]:
    """Symbols of short codes, their offsets, and the first row that is no short code, or -1."""

def pack_symbols(
    symbols: Code, offsets: NDArray[np.int64]
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Symbols seven bits a byte, as :mod:`patterndb.core.packing` has them, and the rows' ends."""
