# Bound by rust/python/src/query/solving/jointclaims.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def list_joint_claims(
    claim: Int32Array, near_first: Int32Array, near: NDArray[np.int16]
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """List the joint claims of (s, w) graphs; arguments as in :class:`.systems.Graphs`.

    Returns (s,) int32 the number of each system's graph, systems of equal graphs having one, and
    by graph (g + 1,) int32 and (c,) int32: graph k has the claims first[k]..first[k + 1] - 1.
    """

def sum_needs(need: Int32Array, sums: Int32Array) -> None:
    """Write what sets of five sides need together, for every five of these MOST_SIDES.

    sums: (TABLES * SUMS,), 0 at the empty sets. Loops of a fixed length are unrolled.
    """

def is_refused(first: int, last: int, claims: Int32Array, sums: Int32Array) -> bool:
    """Is one of the claims first..last - 1 broken? sums: of :func:`sum_needs`."""
