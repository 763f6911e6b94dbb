# Bound by rust/python/src/geometry.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def squareness(quads: Int32Array, vertices: Points) -> float:
    """Return the squareness of quads, see :func:`query.placing.quality`."""
