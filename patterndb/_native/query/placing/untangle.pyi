# Bound by rust/python/src/query/placing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from query.placing.untangle import LEFT

def find_pieces(quads: Int32Array, free: NDArray[np.bool_]) -> Int32Array:
    """(q,) int32 names of the pieces that quads are in: those with a free vertex in common are
    in one. Every quad has a free vertex.
    """

def minimise_energy(
    quads: Int32Array,
    wanted: NDArray[np.bool_],
    up: Points,
    free: Int32Array,
    frames: Points,
    size: float,
    points: Points,
    left_over: float = LEFT,
) -> float:
    """Minimise the energy of all wanted corners over the free vertices, in place; return the
    smallest area left.

    Once a round begins without a flipped corner it is the last, and keeps it so. Where rounds no
    longer help it ends, too.
    """
