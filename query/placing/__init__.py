"""Placing: where the vertices of a fill lie, in the plane, in space or on a surface."""

from patterndb.geometry.quadshape import quality
from patterndb.geometry.surface import Surface
from query.placing.flow import flow_distance
from query.placing.laplace import laid
from query.placing.placement import Placement, place
from query.placing.region import Region, enclosed
from query.placing.strand import Strand, loops, strand

__all__ = [
    "Placement",
    "Region",
    "Strand",
    "Surface",
    "enclosed",
    "flow_distance",
    "laid",
    "loops",
    "place",
    "quality",
    "strand",
]
