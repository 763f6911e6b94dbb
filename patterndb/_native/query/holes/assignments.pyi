# Bound by rust/python/src/query/holes.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def measure(logs: Floats, regular_valence: Int32Array, assignments: Int32Array) -> Floats:
    """Return the traits (a, k) of assignments (a, L) of quads to the vertices of a loop.

    logs: (L, 4) log probability of 1 to 4 quads at each vertex. regular_valence: (L,) quads that
    make it
    regular.
    """
