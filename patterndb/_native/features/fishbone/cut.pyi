# Bound by rust/python/src/features.rs.
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats

def cheapest(costs: Floats, cross: Floats) -> tuple[Int64Array, float]:
    """((m,) rows, cost)."""
