# Bound by rust/python/src/retopo/ground/topology.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points

def pair_sides(
    vertices: Points, triangles: Int32Array, start: Int32Array, sides: Int32Array
) -> Int32Array:
    """(3t,) :attr:`GroundTopology.across`: of the sides of an edge, the straightest pairs first."""
