# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

def order_canonically(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n,) positions of a loop's points (n, 3) in the canonical traversal.

    It begins at the vertex with the least x, then y, then z, and goes on to the side where, at
    the first step that differs, x, then y, then z is less. Coordinates within SAME of the
    loop's extent are equal.
    """

def endpoints(
    points: NDArray[np.float64], corners: NDArray[np.bool_], bound: float
) -> NDArray[np.bool_]:
    """Return which vertices (n,) of a loop are ends, from which chords start.

    All corners; then, wherever the loop turns between two ends by more than ``bound`` (radians,
    above 0), a local maximum of curvature if there is one, else samples that part the turning
    evenly.
    """

def candidates(
    given_points: NDArray[np.float64], given_corners: NDArray[np.bool_], ends: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the chords (c, 2) between ends that may split a loop: positions among the points (n,
    3).

    given_corners: (n,) bool. ends: (e,) int64.
    """
