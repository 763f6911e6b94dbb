# Bound by rust/python/src/query/solving/matching.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.solving.systems import Int16Array

def is_matchable(
    slack: Int32Array,
    row: int,
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    flow: Int32Array,
    scratch: Int32Array,
) -> int:
    """Is there a matching that gives every side its slack? Return 0 if so.

    Arguments and result are those of :func:`query.solving.halves.meet_slack`, but that the result
    is -1 where only halves would do. flow: overwritten.
    """

def is_soluble(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
) -> bool:
    """Do the open classes meet the slack? Exact, where :func:`.halves.find_transport` has halves.

    slack: (w,) >= 0; class_i, class_j: (m,) int32, several may join the same sides; closed:
    (m,) bool.
    """

def count_splits(value: int, parts: int) -> int:
    """How many ways there are to write value >= 0 as an ordered sum of parts, capped at MANY."""

def search_matchings(
    slack: Int32Array, class_i: Int32Array, class_j: Int32Array, class_n: Int32Array, limit: int
) -> tuple[Int32Array, int]:
    """List solutions until they stand for more than ``limit`` widths.

    slack: (w,) int32; class_n: (m,) polychords of each class, so that a row stands for the
    product of their :func:`count_splits`. Returns ((r, m) int32 rows, widths they stand for, at
    most MANY): the list is whole exactly if the second is at most ``limit``.
    """
