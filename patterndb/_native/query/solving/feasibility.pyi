# Bound by rust/python/src/query/solving.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from query.cancellation import CancelFlag
from query.solving.feasibility import Lanes, PatternRows
from query.solving.systems import Systems

def mark(
    systems: Systems,
    lanes: Lanes,
    stated: Int64Array,
    patterns: PatternRows,
    cancelled: CancelFlag,
    fits: NDArray[np.bool_],
) -> None:
    """Set ``fits``, false at first: (r, o) in which allowed orientations lengths can be met, or
    (r, 1) whether they can in any.

    stated: (k, g) the words that :func:`state_claims` wrote, at least for the claims of these rows.
    """

def pack_lengths(lengths: Int32Array) -> tuple[Int64Array, Int64Array]:
    """Return the words of lanes: (g,) with the highest bit of each, and the lengths (n, w) of
    each two sides compared with all base lengths that they may have."""

def state_claims(
    systems: Systems,
    lengths: Int32Array,
    claims: Int32Array,
    first: int,
    stated: NDArray[np.uint8],
) -> None:
    """Write the lanes of those of some claims that have none yet, which are 0.

    lengths: (w, n) of all lanes. stated: (k, lanes), rows of the claims from ``first`` on.
    """
