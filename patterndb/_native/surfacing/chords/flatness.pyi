# Bound by rust/python/src/surfacing.rs.

from patterndb.geometry.points import Points

def standardised(points: Points) -> tuple[Points, float]:
    """Return points (n, 3) in axes in which their covariance is the unit matrix, and its
    determinant in units of length^6. If they are planar, points and determinant are 0.
    """
