# Bound by rust/python/src/geometry.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

def first_along(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    points: Points,
    normals: Points,
    reach: Points,
) -> tuple[Int32Array, Points]:
    """Find, of the hits of lines, the one nearest to where each begins, both ways along.

    points, normals: (n, 3); reach: (n,). Triangles that face away from the normal are not
    seen. Returns (n,) triangles, -1 without hit, and (n, 3) weights.
    """

def first_hits(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origins: Points,
    directions: Points,
) -> tuple[Int32Array, Points, Floats]:
    """Find the first hit of every ray (n, 3), (n, 3): triangles (n,), -1 without one, weights
    (n, 3) and how far along (n,), inf without one.
    """

def all_hits(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origins: Points,
    directions: Points,
) -> tuple[Int32Array, Int32Array, Points, Floats]:
    """Find all hits of lines (n, 3), (n, 3), of both sides: the line (h,) of each, in ascending
    order, its triangle (h,), weights (h, 3) and how far along (h,), in no order.
    """
