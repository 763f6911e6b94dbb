# Bound by rust/python/src/features.rs.
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points

def track(
    costs: Floats, cross: Floats, bends: Points, change: float, reach: Int64Array, leap: float
) -> tuple[Int64Array, float]:
    """((m,) rows, cost)."""
