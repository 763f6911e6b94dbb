# Bound by rust/python/src/query/holes.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def own_features(
    loop: Floats,
    normals: Floats,
    angle_outside: Floats,
    outside: Int32Array,
    clamped_valence: Int32Array,
    scale: float,
    spokes: Floats,
    far: Floats,
) -> Floats:
    """(L, OWN) of each vertex alone, and of the edges at it."""
