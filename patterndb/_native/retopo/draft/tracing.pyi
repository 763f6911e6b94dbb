# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def trace_all(
    flat: Floats,
    side_angle: Floats,
    across: Int32Array,
    angle: Floats,
    quarters: Int32Array,
    start_triangle: Int32Array,
    start_corner: Int32Array,
    start_place: Floats,
    start_angle: Floats,
    start_direction: Int32Array,
    wall_line: Int32Array,
    wall_triangle: Int32Array,
    wall_begin: Floats,
    wall_end: Floats,
    wall_along: Floats,
    wall_reach: Floats,
    first: int,
    longest: float,
    stopping: bool,
) -> tuple[
    Int32Array,
    Int32Array,
    Floats,
    Floats,
    Floats,
    Floats,
    Int32Array,
    Floats,
    Int32Array,
    Floats,
    NDArray[np.bool_],
]:
    """:func:`trace_lines` on flat arrays."""
