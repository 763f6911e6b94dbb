# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points

def contacts(
    points: Points,
    along: Floats,
    curve_of: Int64Array,
    edges: Int64Array,
    low: Floats,
    high: Floats,
    reaches: Floats,
    settled: NDArray[np.bool_],
    limit: int,
) -> tuple[Int64Array, Floats, Floats]:
    """Find all pairs of edges (first <= second) within reach, as :func:`find_contacts` does.

    edges: sorted by the first coordinate of their boxes' lower corners ``low``.
    """

def components(
    points: Points, curve_of: Int64Array, key: Int64Array, pairs: Int64Array, reaches: Floats
) -> Int64Array:
    """Find for every contact, sorted by key, the root of its connected part.

    The pairs of places of two edges are a convex set; it continues in the next edge if the
    vertex between them is within reach.
    """

def joins(
    points: Points,
    curve_of: Int64Array,
    along: Floats,
    lasts: Floats,
    pairs: Int64Array,
    places: Floats,
    distances: Floats,
    bounds: Int64Array,
    reaches: Floats,
    closed: NDArray[np.bool_],
) -> tuple[Int64Array, Floats, Floats, Int64Array]:
    """Choose the joins of all meetings; meeting m has the contacts bounds[m] to bounds[m + 1].

    Returns the curves (m, 2), the lengths (m, 2), the gaps (m,) and the meetings (m,).
    """

def find_nearest_of_edges(
    points: Points, first: int, second: int, margin: float
) -> tuple[float, float, float]:
    """Find the places on two edges, 0 to 1, nearest to each other, and the distance.

    Ends are taken unless places within both edges are closer by more than the margin.
    """

def measure_deviation(points: Points, other: Points) -> float:
    """Measure how far a point of one polyline (k, 3) lies at most from another one (m, 3)."""
