# Bound by rust/python/src/features.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools, Points

def set_axes(normal: Points, axes: Points) -> None:
    """Sets axes (3, 3) from a unit normal (3,): x is across the coordinate axis farthest from
    the normal.
    """

def cut_edges(
    corners: Points,
    triangles: Int32Array,
    components: Int32Array,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origin: Points,
    axes: Points,
    radius: float,
) -> tuple[Points, Int64Array, Int32Array]:
    """Ends (e, 2, 2), keys (e, 2) and parts (e,) of a Slice, in the order of the tree."""

def join_edges(
    ends: Points, keys: NDArray[np.int64], tolerance: float
) -> tuple[Points, Int32Array, Bools, Bools]:
    """Points, offsets, closed and rims of Segments from edges (e, 2, 2) with keys (e, 2)."""
