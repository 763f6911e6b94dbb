# Bound by rust/python/src/features.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Points

def slice_segments(
    corners: Points,
    triangles: Int32Array,
    components: Int32Array,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origin: Points,
    axes: Points,
    radius: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, float, Points, int, bool]:
    """The segments that belong to the one nearest to the origin: points, offsets, closed and rims
    as of Segments, without overhangs where segments cross, and joined where ends face each other.

    Then the widest gap to be closed, -1 if the nearest segment is alone and has none; (2, 2) the
    foot of the origin and the unit normal of the nearest segment there; its number; and whether
    any was shortened or joined.
    """

def count_rounds(gap: float, scale: float) -> int:
    """How many dilations close a gap: the paper's one, or as many as the gap needs, so long as
    they stay within the margin. Two pixels meet after k if they are 2 k + 1 apart, and the pixels
    of two places are apart by less than one more than those.
    """

def trace_outline(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    about: Points,
    outward: float,
    radius: float,
    rounds: int,
    gap: float,
    tolerance: float,
) -> tuple[Points, bool, int, tuple[int, int]]:
    """The outer contour through the foot by way of a picture, the outside on its right.

    points to about: as of slice_segments(). outward: +1 or -1, the sign that makes the normal there
    point out. rounds: of dilation and erosion; below 1 they follow from the gap.

    (p, 2) the polygon, is it closed, how many rounds, and how both ends came about.
    """

def measure_off_backbone(points: Points) -> float:
    """Distance of the origin from a polygon."""
