# Bound by rust/python/src/query/holes.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def measure_quads(
    quads: Int32Array,
    n_vertices: int,
    regular_valence: Int32Array,
    clamped_valence: Int32Array,
    ahead: Floats,
    logs: Floats,
) -> Floats:
    """Measure how regular a candidate is, and how strands join the loop's edges: see FACTS,
    inner_irregular to asked_corners, regular_inside to dipoles, least_side.

    ahead: (L, 3) unit vectors along the loop's edges. logs: (L,) logarithms of their lengths.
    """
