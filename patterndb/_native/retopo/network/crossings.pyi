# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

def cross_chains(
    line: Points,
    up: Points,
    points: Points,
    normals: Points,
    starts: Int32Array,
    loose: NDArray[np.bool_],
) -> Floats:
    """(k, 4): place on the line, number and place of the chain, 1 if from left to right."""

def cross_itself(line: Points, aside: Points, up: Points, closed: bool) -> Floats:
    """(k, 4): later place, 0, earlier place, 1 if the later part goes to the earlier's right."""
