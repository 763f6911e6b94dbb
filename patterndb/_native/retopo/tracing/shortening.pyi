# Bound by rust/python/src/retopo.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

def unfold_strip(
    vertices: Points,
    triangles: Int32Array,
    out: Int32Array,
    into: Int32Array,
    start: Floats,
    end: Floats,
) -> tuple[Int32Array, Points, Points]:
    """The gates between the triangles of a strip, in one plane.

    out, into (n,): the sides by which one triangle is left and the next entered, n >= 1;
    start, end: (3,) barycentric weights of points in the first and last triangle.

    Returns the vertices at the left and right of the gates (n + 2, 2), their places
    (n + 2, 2, 2), and those of start and end (2, 2). Rows 0 and n + 1 are no gates: both sides
    are the corner of the first and last triangle that is at none.
    """

def pull_tight(
    gate: Int32Array, flat: Points, ends: Points
) -> tuple[Int32Array, Int32Array, float]:
    """Where the shortest path through the gates of :func:`unfold_strip` turns: (m,) numbers of
    gates, counted from 0, and (m,) their sides, 0 left and 1 right; and the path's length.

    Source: Lee and Preparata 1984; the funnel is opened anew behind every turn.
    """

def shorten_strip(
    vertices: Points,
    triangles: Int32Array,
    across: Int32Array,
    out: Int32Array,
    into: Int32Array,
    start: Floats,
    end: Floats,
) -> tuple[int, Int32Array, Int32Array, Floats, Floats]:
    """The strip whose shortest path is shorter than all near it: its first triangle, its sides
    out and into, (n,) each, and the weights (3,) of its ends; it may be of no gates.

    Every round pulls the path tight and looks at each vertex where it turns: if the angle on
    the side away from the strip is less than a straight one, the strip goes round there.
    """

def cross_gates(
    vertices: Points,
    gate: Int32Array,
    flat: Points,
    ends: Points,
    numbers: Int32Array,
    which: Int32Array,
) -> Points:
    """(n, 3) where the path that turns at these gates passes each of the n."""
