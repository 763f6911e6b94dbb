# Bound by rust/python/src/geometry.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def cut_chosen(
    points: Points,
    corners: Int32Array,
    offsets: NDArray[np.int64],
    rows: NDArray[np.int64],
    chosen: NDArray[np.int64],
    triangles: Int32Array,
) -> None:
    """Write the triangles of some faces of a mesh."""

def cut(points: Points, corners: Int32Array, offsets: NDArray[np.int64]) -> Int32Array:
    """(t, 3) the triangles of all faces, n - 2 of a face with n corners; 0 where n is above
    MOST_EXACT.
    """

def write_once(face: Int32Array) -> Int32Array:
    """The lexicographically first of all 2 n ways to write down a face."""
