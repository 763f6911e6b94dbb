# Bound by rust/python/src/geometry.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def pair_sides(
    vertices: Points, triangles: Int32Array, start: Int32Array, sides: Int32Array
) -> Int32Array:
    """Return (3t,) :attr:`Adjacency.across`: of the sides of an edge, the straightest first."""

def walk_parts(across: Int32Array, corner: Int32Array) -> tuple[Int32Array, NDArray[np.bool_]]:
    """Return (t,) the component of every triangle, and (t,) whether it is turned over against the
    component's first."""
