# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def split_long(
    points: Points, triangles: Int32Array, twin: Int32Array, longest: float
) -> tuple[Points, Int32Array, Int32Array]:
    """Halve edges that are too long until none is."""

def mark_border(n: int, triangles: Int32Array, twin: Int32Array) -> NDArray[np.bool_]:
    """Return for each of n vertices whether it lies on a border side.

    triangles: (t, 3) int32. twin: (t, 3) int32, -1 at a border.
    """

def collapse_short(
    points: Points, triangles: Int32Array, twin: Int32Array, shortest: float, longest: float
) -> NDArray[np.bool_]:
    """Collapse edges that are too short; (t,) which triangles are left."""

def flip_to_valence(
    points: Points, triangles: Int32Array, twin: Int32Array, border: NDArray[np.bool_]
) -> None:
    """Flip edges where that brings valences nearer to 6, or 4 on the border."""

def relax(
    points: Points, triangles: Int32Array, border: NDArray[np.bool_]
) -> tuple[Points, Points]:
    """Where vertices are wanted along the surface, between their triangles; and their normals."""
