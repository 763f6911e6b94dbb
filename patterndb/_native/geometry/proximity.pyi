# Bound by rust/python/src/geometry.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def nearest(
    corners: Points, boxes: Points, nodes: Int32Array, order: Int32Array, points: Points
) -> tuple[Int32Array, Points]:
    """Find the triangle (n,) nearest to each point (n, 3), and the weights (n, 3) of the point
    on it.
    """

def nearest_facing(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    points: Points,
    normals: Points,
) -> tuple[Int32Array, Points]:
    """Find the nearest triangle (n,) that faces as the point's normal does, -1 without one, and
    the weights (n, 3) of the point on it.

    points, normals: (n, 3). A triangle across the normal does not face as it does.
    """
