# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

def flatter(points: Points, chords: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) the box of the loop (n, 3) less those of both sides of each chord."""
