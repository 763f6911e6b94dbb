# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

def standardised(points: Points) -> tuple[Points, float]:
    """Return points (n, 3) in axes in which their covariance is the unit matrix, and its
    determinant in units of length^6. If they are planar, points and determinant are 0.
    """

def sum_moments(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(10,) moments of points (n, 3): how many, their sums, and the sums of their products."""

def find_determinant(moments: NDArray[np.float64]) -> float:
    """The determinant of the covariance that the moments (10,) have, 0 for a planar piece.

    The points must be in the axes of :func:`standardise`.
    """
