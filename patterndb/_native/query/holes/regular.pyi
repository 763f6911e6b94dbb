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

def pave(corners: Int32Array, rings: int) -> tuple[Int32Array, Int32Array, Int32Array, int]:
    """Lay rings: quads, the loop that is left, the quads at each vertex of it, and how many
    vertices; 0 where that cannot be.

    A ring is laid quad by quad along a front, which is the loop at first. A vertex of the loop that
    lacks one quad gets it between the front's edges before and after; where none does, a quad is
    laid behind an edge of the front. Before the next ring, vertices with four quads are closed: the
    two edges of the front there become one.
    """
