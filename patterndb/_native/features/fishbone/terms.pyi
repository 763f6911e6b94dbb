# Bound by rust/python/src/features.rs.
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
    """Return how much ribs bend at each sample, in radians per length; 0 where there is none.

    points: (n, 3) of all ribs; those of rib r are first[r] to stop[r]. spacing: (r,) distance
    between the samples of each rib. window: length of the chords to both sides. Source: feature
    curve recovery paper, section 4.3.3. Differs from the paper: the angle over the length along the
    rib, which has a peak at corners, and is the same on circles.
    """

def ways(
    points: Points,
    first: NDArray[np.int64],
    stop: NDArray[np.int64],
    spacing: Floats,
    window: float,
) -> Points:
    """(m, k, 3) unit vectors from the chord to a sample to that from it, 0 where they are one."""
