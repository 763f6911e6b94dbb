# Bound by rust/python/src/query/solving/systems.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.solving.systems import Int16Array, Systems

def number_claims(
    joined: NDArray[np.bool_],
) -> tuple[Int32Array, Int16Array, Int32Array, Int16Array]:
    """The claims of (s, w, w) symmetric graphs: see :class:`Graphs` and :class:`Systems`.

    Returns claim, claimant, near_first and near.
    """

def fill(made: Systems, joined: NDArray[np.bool_]) -> None:
    """Write the classes, what neighbours have, and parity; joined: (s, w, w) bool, symmetric."""
