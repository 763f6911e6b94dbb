# Bound by rust/python/src/query/holes.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def fill_walk(corners: Int32Array) -> tuple[Int32Array, int]:
    """Return the fill of a closed walk, with no vertices where no such fill exists."""

def tabulate_rest(logs: Floats) -> NDArray[np.float32]:
    """[i, x, y, t] the most that vertices i to L - 1, and then 0, earn from a place on, turned by
    t so far, if the walk is to be closed.
    """
