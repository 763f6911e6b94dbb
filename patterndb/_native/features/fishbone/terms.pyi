# Bound by rust/python/src/features/fishbone/terms.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats, Points

def bends(
    points: Points,
    first: NDArray[np.int64],
    stop: NDArray[np.int64],
    spacing: Floats,
    window: float,
) -> Floats:
    """"""

def ways(
    points: Points,
    first: NDArray[np.int64],
    stop: NDArray[np.int64],
    spacing: Floats,
    window: float,
) -> Points:
    """(m, k, 3) unit vectors from the chord to a sample to that from it, 0 where they are one."""
