# Bound by rust/python/src/core.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def rooted_code(
    twin: Int32Array,
    n_quads: int,
    start: int,
    clockwise: bool,
    code: NDArray[np.uint16],
    number: Int32Array,
    entry: Int32Array,
    order: Int32Array,
    best: bool,
) -> int:
    """Write the code read from half-edge ``start`` into ``code``.

    code: (>= 4 * n_quads,) uint16; number, entry, order: (>= n_quads,) int32 scratch.
    With ``best``, ``code`` already holds one and is only overwritten by a smaller one.
    Returns -1 if written, 0 if equal to what was there, 1 if larger (nothing written).
    """

def clockwise_start(twin: Int32Array, h: int) -> int:
    """The border half-edge that ends at the tail of border half-edge h.

    Seen in a mirror, it is the one that starts there.
    """

def smallest_code(
    twin: Int32Array,
    n_quads: int,
    starts: Int32Array,
    n_starts: int,
    clockwise: bool,
    code: NDArray[np.uint16],
    number: Int32Array,
    entry: Int32Array,
    order: Int32Array,
) -> tuple[int, int]:
    """Write the smallest code over all starts; return (its first start, how many reach it).

    starts: (>= n_starts,) int32 border half-edges. The count is the number of rotations
    that map the pattern onto itself.
    """

def code_starts(twin: Int32Array, starts: Int32Array) -> int:
    """Write the half-edges a code may start from, in border order; return their number.

    They leave the corners (border vertices whose number of quads is not 2), or every
    border vertex where there is no corner. starts: (>= 4q,) int32.
    """

def is_disk_code(twin: Int32Array) -> bool:
    """Are these the half-edges that a code of a disk describes?

    twin: (n,) int32 symbols less one, from any source: nothing is taken for granted. They
    must pair up, number their quads breadth-first from half-edge 0, which is on the
    border, and form a disk with one simple border.
    """
