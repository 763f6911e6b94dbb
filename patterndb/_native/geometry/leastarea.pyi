# Bound by rust/python/src/geometry.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Bools, Points

def triangulate_cheapest(
    points: Points, shorter: float, thin: float, triangles: NDArray[np.integer]
) -> float:
    """Write the cheapest triangulation of a closed polyline (n, 3) to (n - 2, 3); its cost.

    A triangle costs its area, but no less than ``thin`` times the squared lengths of its edges, and
    ``shorter`` times these. Of equals the one with the lower vertex is taken.
    """

def tabulate_areas(at: Points, barred: Bools) -> Points:
    """Tabulate (n, n) twice the least area between vertices i and j of a polyline (3, n).

    Infinite for barred pairs (n, n); an array of one entry bars none. The table is symmetric, so
    that both entries that the inner loop reads are next to each other in memory.
    """

def choose_triangles(at: Points, least: Points) -> tuple[Int64Array, float]:
    """Choose the triangles (n - 2, 3) of a polyline (3, n) by the table of its least areas.

    Returns them and their area. Of equals (TIE) it takes the triangle with the widest angle
    opposite its edge, then the lowest vertex.
    """

def tabulate_areas_around(at: Points) -> Points:
    """Tabulate (n, n) [i, s]: twice the least area of s + 1 vertices from i on of a loop (3, n)."""
