# Bound by rust/python/src/query/solving/batch.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.solving.systems import Int16Array

def keep_carrying(
    words: Int16Array,
    start: NDArray[np.int64],
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    lengths: Int32Array,
    weights: Int32Array,
    flows: Int32Array,
    tolerance: int,
    cancelled: NDArray[np.uint8],
    once: bool,
) -> None:
    """Do :func:`query.solving.batch.keep_carriers` for some rows; clears ``allowed`` (r, o)."""

def solve_rows(
    words: Int16Array,
    start: NDArray[np.int64],
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    lengths: Int32Array,
    weights: Int32Array,
    flows: Int32Array,
    tolerance: int,
    count: NDArray[np.int64],
    key: NDArray[np.int64],
    best: NDArray[np.int32],
    cancelled: NDArray[np.uint8],
) -> None:
    """Do :func:`query.solving.batch.solve_rows` for some rows.

    count: (r,), key: (r, keep), best: (r, keep, longest + 1), with the orientation last.
    """
