# Bound by rust/python/src/geometry.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

def clip_ears(points: Points, triangles: NDArray[np.integer]) -> None:
    """Write the triangles (n - 2, 3) of one face, (n, 3) points, in its sense.

    What is left of an outline without ears, one that crosses itself, is halved again and again.
    """
