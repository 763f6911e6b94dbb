# Bound by rust/python/src/geometry.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def relax_points(
    y: NDArray[np.complex128],
    handles: int,
    moving: bool,
    ends: Int32Array,
    weights: Floats,
    quads: Int32Array,
    angle: Floats,
    size: float,
    rounds: int,
    steps: int,
    points: NDArray[np.complex128],
) -> float:
    """Minimise the energy of a drawing over y, in place; return the smallest triangle area.

    Each of at most ``rounds`` rounds takes at most ``steps`` L-BFGS steps with one
    smoothing; once a round begins with no triangle flipped it is the last. points: (v,)
    complex128 output.
    """
