# Bound by rust/python/src/surfacing.rs.
from patterndb.core.halfedge import Int64Array

def doubled_area(at: Int64Array) -> float:
    """Twice the signed area of a closed polygon (m, 2)."""

def is_simple(at: Int64Array) -> bool:
    """Does the closed polygon (m, 2) run counter-clockwise without touching itself?

    Vertices in a row on one line are fine; two at one place and edges that fold back are not.
    """

def clip_ears(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> None:
    """Triangulate the simple counter-clockwise polygon of the first m points, in place.

    tail, twin: (3 (m - 2),) int64 or longer, filled here. Half-edge 3 t + e leaves vertex
    tail[3 t + e] of triangle t; twin is the half-edge on its other side, -1 on the boundary.

    Every simple polygon has an ear (Meisters 1975), and so has one with vertices in a row on
    one line: a leaf of any of its triangulations. Clipping one leaves such a polygon, because
    no vertex lies on the cut.
    """

def make_delaunay(at: Int64Array, tail: Int64Array, twin: Int64Array, triangles: int) -> None:
    """Flip inner edges of the first triangles until each is locally Delaunay.

    An edge is flipped only where the test is certain. Then its quad is convex, and the flip
    lowers the surface over the paraboloid: it ends.
    """

def lay_lattice(grid: Int64Array, spacing: float) -> Int64Array:
    """(k, 2) points of a hexagonal lattice inside a simple polygon, clear of its boundary.

    Rows are along the first axis, one of them through the middle of the polygon's box.
    """

def join(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> int:
    """Insert the points from m on, one by one; how many points are joined in the end."""

def smooth(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> None:
    """Move the points from m on towards even triangles, in place, and flip to Delaunay again.

    Each goes to the mean of its triangles' middles by their areas (Chen 2004, "Mesh smoothing
    schemes based on optimal Delaunay triangulations"), unless that would turn one of them over.
    """
