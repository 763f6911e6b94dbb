# Bound by rust/python/src/query/solving.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code
from patterndb.core.halfedge import Int32Array

def list_records(
    flat: Code,
    offsets: NDArray[np.int64],
    n_irregular: Int32Array,
    n_reflex: Int32Array,
    n_marks: int,
    most: int,
    free: bool,
    marks: Int32Array,
    slots: Int32Array,
    near: Int32Array,
    far: Int32Array,
) -> tuple[Int32Array, NDArray[np.int16], NDArray[np.int16]]:
    """Every way to set ``n_marks`` marks on each of the patterns, up to symmetry: the records.

    Returns their heads, (r, HEAD + N + N (N + 1) / 2) int32; for each record the number of strands
    on side 0, their numbers, and so on, flat int16; for each the polychord of every strand, flat
    int16.

    flat, offsets: the patterns' codes; n_irregular, n_reflex: (p,). most, free: as in
    :func:`query.marks.marked.mark_patterns`. marks, slots, near, far: the columns of
    :class:`query.marks.markplaces.Partings`.
    """
