# Bound by rust/python/src/query/relaxed.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code
from patterndb.core.halfedge import Int32Array
from query.cancellation import CancelFlag
from query.relaxed.corner_placement import CornerSites

def list_records(
    patterns: tuple[Code, NDArray[np.int64], Int32Array, Int32Array],
    n_marks: int,
    most: int,
    free: bool,
    sites: CornerSites,
    cancelled: CancelFlag,
) -> tuple[Int32Array, NDArray[np.int16], NDArray[np.int16]]:
    """Every way to set ``n_marks`` marks on each of the patterns, up to symmetry: the records.

    Returns their heads, (r, HEAD + N + N (N + 1) / 2) int32; for each record the number of strands
    on side 0, their numbers, and so on, flat int16; for each the polychord of every strand, flat
    int16. Once cancelled, records are missing.

    patterns: their codes, flat, and offsets that part them; their irregular vertices and reflex
    corners, (p,) each. most, free: as in :func:`query.relaxed.corner_placement.mark_patterns`.
    """
