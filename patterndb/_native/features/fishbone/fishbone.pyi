# Bound by rust/python/src/features.rs.
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points

def carry_backbone(
    points: Points,
    first: Int64Array,
    stop: Int64Array,
    backbone: Int64Array,
    origins: Points,
    start: int,
    strayed: float,
) -> Int64Array:
    """(m,) rows of the backbone, each the nearest sample to the one before; -1 if it strays."""
