# Bound by rust/python/src/query/solving/feasibility.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.solving.feasibility import FeasibilityQuery, Flag
from query.solving.systems import Systems

def mark(
    systems: Systems,
    query: FeasibilityQuery,
    rows: NDArray[np.int64],
    signature: Int32Array,
    rotation: Int32Array,
    reflected: NDArray[np.bool_],
    corners: NDArray[np.uint8],
    every: bool,
    cancel: Flag,
    fits: NDArray[np.bool_],
) -> None:
    """:func:`_answer` for some rows (r,); corners: (r, N). signature, rotation, reflected: of all
    rows.
    """
