# Bound by rust/python/src/features.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

def normal_bands(values: Floats, first: Int32Array, n: int) -> Floats:
    """(degree + 1, n) N'N: the diagonal, and the diagonals below it."""

def times(values: Floats, first: Int32Array, control: Points) -> Points:
    """(m, c) N times (n, c)."""

def transposed(values: Floats, first: Int32Array, n: int, points: Points) -> Points:
    """(n, c) the transpose of N times (m, c)."""
