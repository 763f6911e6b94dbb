# Bound by rust/python/src/query/placing.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def relax_inside(start: Int32Array, neighbour: Int32Array, fixed: int, values: Points) -> int:
    """Solve for the rows of ``values`` (v, d) from ``fixed`` on, in place; the steps taken.

    What stands in these rows is where the solution starts from.
    """

def relax_within(
    start: Int32Array, neighbour: Int32Array, fixed: int, points: Points, frames: Points
) -> Points:
    """(v, 3) moves within the vertices' planes that bring the least sum of squared edges.

    points: (v, 3); frames: (v, 2, 3) orthonormal tangents. Vertices before ``fixed`` do not
    move. A few digits suffice: the planes turn from round to round.
    """

def measure_edge_energy(start: Int32Array, neighbour: Int32Array, points: Points) -> float:
    """Sum of the squared lengths of all edges of the vertices (v, 3)."""
