# Bound by rust/python/src/retopo.rs.
from patterndb.geometry.points import Points

def count_bend_edges(line: Points, closed: bool, steps: int, edge: float) -> float:
    """The integral of sqrt(curvature / (8 SAGITTA edge)) along a polyline (n, 3), in equal steps.

    closed: does the line, whose last point is its first, turn there, too?
    """
