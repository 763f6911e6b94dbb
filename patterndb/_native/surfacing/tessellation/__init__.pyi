from . import intersections as intersections
from . import piece as piece
from . import planar as planar
