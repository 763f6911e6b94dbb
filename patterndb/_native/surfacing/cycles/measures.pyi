# Bound by rust/python/src/surfacing.rs.
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points

def measure(
    steps: Int64Array,
    samples: Points,
    offsets: Int64Array,
    start: Int64Array,
    first: Int64Array,
    leaving: Int64Array,
    tangents: Points,
    values: Floats,
    inward: Points,
) -> None:
    """Write the measures of one cycle to values (8,) and inward (len(steps), 3)."""
