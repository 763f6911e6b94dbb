# Bound by rust/python/src/query/solving.rs.
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.solving.systems import Int16Array, Systems

def decide_matching(systems: Systems, row: int, slack: Int32Array) -> tuple[bool, list[int]]:
    """Return whether a matching gives every side of a system its slack (w,), and, where not even a
    fractional one does, the sides that ask for more than their neighbours have; for tests."""

def list_systems(
    base: Int16Array, joined: NDArray[np.bool_], with_hall: bool
) -> dict[str, NDArray[Any]]:
    """Return the arrays of :class:`query.solving.systems.Systems` by name, but ``base`` and
    ``perimeter``, of (s, w) base lengths and (s, w, w) joins."""
