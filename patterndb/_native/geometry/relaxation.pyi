# Bound by rust/python/src/geometry/relaxation.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.geometry.relaxation import Complex

def relax_points(
    y: Complex,
    handles: int,
    moving: bool,
    ends: Int32Array,
    weights: Floats,
    quads: Int32Array,
    angle: Floats,
    size: float,
    rounds: int,
    steps: int,
    points: Complex,
) -> float:
    """Minimise :func:`measure_energy` over y, in place; return the smallest triangle area.

    Each of at most ``rounds`` rounds takes at most ``steps`` L-BFGS steps with one
    smoothing; once a round begins with no triangle flipped it is the last. points: (v,)
    complex128 output.
    """
