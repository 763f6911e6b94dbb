# Bound by rust/python/src/geometry.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def build(corners: Points) -> tuple[Points, Int32Array, Int32Array]:
    """Boxes (b, 2, 3), their nodes (b, 2) and the order (t,) of triangles (t, 3, 3).

    A node is (first child, -1), its other child being the next, or (first place in order,
    how many).
    """
