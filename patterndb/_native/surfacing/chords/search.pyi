# Bound by rust/python/src/surfacing.rs.
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats

def solve(
    points: Floats, own: Floats, chords: Int64Array, alpha: float, printed: bool
) -> tuple[int, float, Int64Array, Int64Array, Int64Array]:
    """Number of sub-problems, cost relative to S(whole), chosen chords, and the pieces' positions
    one after the other with the bounds between them.
    """
