# Bound by rust/python/src/features.rs.
from patterndb.geometry.points import Points

def sample_polygon(points: Points, closed: bool, count: int) -> tuple[Points, Points, int]:
    """Samples (count, 2) at equal arc length with unit normals (count, 2), and the number of the
    one nearest to the origin.

    A closed polygon is cut open opposite the origin. Normals are interpolated along edges
    between those of the vertices: feature curve recovery paper, section 4.3.3.
    """
