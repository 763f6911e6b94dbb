# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

def find_departure(points: Points, backwards: bool, reach: float) -> NDArray[np.float64]:
    """(3,) from the first (or last) point of a polyline (n, 3) to the place at this arc length
    along it, or to its other end if that is nearer.
    """

def measure_turn(
    normal: NDArray[np.float64], one: NDArray[np.float64], two: NDArray[np.float64]
) -> float:
    """Angle from direction one to direction two (3,), counter-clockwise about the unit normal, in
    its tangent plane: 0 to 2 pi.
    """
