# Bound by rust/python/src/query/placing.rs.
from patterndb.geometry.points import Points

def measure_open_distance(stroke: Points, middle: Points) -> tuple[float, float, float]:
    """(integral over the stroke's length, mean, greatest) distance of two open polylines."""

def measure_loop_distance(
    stroke: Points, middle: Points
) -> tuple[float, float, float, float, bool]:
    """(integral over the stroke, mean, greatest, where, against) for two closed polylines.

    Of all starts and both senses the nearest counts. where: the part of the stroke's length
    at which the midline's first point falls; against: does the midline run the other way?
    """

def list_open_targets(stroke: Points, middle: Points) -> Points:
    """(m, 3) the points of the stroke at the arc lengths of the midline's, in proportion."""

def list_loop_targets(stroke: Points, middle: Points, offset: float) -> Points:
    """As open_targets, the midline's first point falling at ``offset`` of the stroke."""
