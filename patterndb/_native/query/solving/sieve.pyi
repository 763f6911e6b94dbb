# Bound by rust/python/src/query/solving/sieve.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from query.solving.systems import Int16Array

def compare_pairs(words: Int64Array) -> Int64Array:
    """Compare the lengths of each two sides with all base lengths that they may have.

    words: (w, g) of :func:`pack_lengths`. Returns (ceil(w / 2), (LONGEST_BASE + 1)**2, g): the
    lanes in which sides 2 p and 2 p + 1 are as long as entry q of
    :class:`query.solving.systems.Systems.pairs` asks.
    """

def state_claims(
    lengths: Int32Array,
    claimant: Int16Array,
    near_first: Int32Array,
    near: Int16Array,
    claims: Int32Array,
    first: int,
    stated: NDArray[np.uint8],
) -> None:
    """Write the lanes (k, g * LANES) of those of the claims that have none yet, which are 0.

    lengths: (w, n) of the lanes; claimant to near: see :class:`query.solving.systems.Systems`.
    claims: (c,), some more than once. stated: the lanes of claims first..first + k - 1.
    """

def sift_system(
    row: int,
    pairs: NDArray[np.uint8],
    surplus: NDArray[np.uint8],
    claim: Int32Array,
    marks: Int64Array,
    compared: Int64Array,
    stated: Int64Array,
    left: Int64Array,
) -> bool:
    """Write the lanes (g,) in which the system of a row passes; return whether any does.

    pairs, surplus, claim: see :class:`query.solving.systems.Systems`. marks: of
    :func:`mark_lanes`; compared: of :func:`compare_pairs`; stated: of :func:`state_claims`.
    """

def has_lane(left: Int64Array, lane: int) -> bool:
    """Is the lane among those left?"""

def drop_lane(left: Int64Array, lane: int) -> None:
    """Take a lane that is left from those left."""
