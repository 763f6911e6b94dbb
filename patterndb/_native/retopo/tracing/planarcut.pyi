# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points

def find_cut_sides(triangles: Int32Array, height: NDArray[np.float64], f: Index) -> tuple[int, int]:
    """The sides by which the cut leaves and enters triangle f, with the normal on its left."""

def place_crossing(
    vertices: Points, triangles: Int32Array, height: NDArray[np.float64], side: Index
) -> NDArray[np.float64]:
    """(3,) where the plane cuts a side, the same seen from both of its triangles."""

def follow_cut(
    vertices: Points,
    triangles: Int32Array,
    across: Int32Array,
    height: NDArray[np.float64],
    side: Index,
    most: float,
) -> tuple[Int32Array, float, bool]:
    """(n,) the sides by which the cut leaves one triangle after the other, the first being
    ``side``; its length from there on, and whether it came back.

    It ends at a border, back at its first triangle, or beyond the length ``most``.
    """
