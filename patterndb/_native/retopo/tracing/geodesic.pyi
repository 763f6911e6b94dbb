# Bound by rust/python/src/retopo.rs.
from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points

def search_route(
    vertices: Points,
    middles: Points,
    ends: Int32Array,
    edges: Int32Array,
    side_start: Int32Array,
    sides: Int32Array,
    first: Index,
    start: Floats,
    last: Index,
    end: Floats,
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """A* of :func:`find_route`: for every edge, and the goal behind them, the edge before it, the
    side that the way leaves its triangle by, and that of the triangle before or -1, if the step
    leads through two. -1 before an edge that is first, or was not reached.
    """
