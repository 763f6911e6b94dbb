# Bound by rust/python/src/retopo.rs.
from patterndb.geometry.points import Points

def sum_areas(points: Points, normals: Points) -> tuple[float, float, float]:
    """Measure what a closed polyline (n, 3) encloses on a surface with these normals (n, 3).

    Returns the area to its left, that of the polyline itself, and its length. Source: Takayama et
    al. 2013, equation 1, with the mean of the points as the centre.
    """
