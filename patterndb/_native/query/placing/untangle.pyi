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

def compute_energy(
    quads: Int32Array,
    wanted: NDArray[np.bool_],
    up: Points,
    size: float,
    epsilon: float,
    points: Points,
    force: Points,
) -> tuple[float, float]:
    """The energy of all wanted corners, its gradient into ``force`` (v, 3), and the smallest
    area of a corner, in squared sizes.
    """

def count_flipped_corners(
    quads: Int32Array, wanted: NDArray[np.bool_], up: Points, points: Points
) -> int:
    """How many wanted corners have no positive area."""

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
    """Minimise :func:`compute_energy` over the free vertices, in place; the smallest area left.

    Once a round begins without a flipped corner it is the last, and keeps it so. Where rounds no
    longer help it ends, too.
    """
