# Bound by rust/python/src/retopo/network/patches.rs.
from patterndb.geometry.points import Points

def sum_areas(points: Points, normals: Points) -> tuple[float, float, float]:
    """"""
