"""The plane of a local parameterisation: boundaries around a new patch, and the patch itself."""

from patterndb_sketch.retopo.tools.plane.boundary import Boundary
from patterndb_sketch.retopo.tools.plane.patch import PlanarPatch
from patterndb_sketch.retopo.tools.plane.side import (
    Corner,
    NewSide,
    OldSide,
    Side,
    arc,
    straight,
    stretch,
)
from patterndb_sketch.retopo.tools.plane.sound import crossings, fault

__all__ = [
    "Boundary",
    "Corner",
    "NewSide",
    "OldSide",
    "PlanarPatch",
    "Side",
    "arc",
    "crossings",
    "fault",
    "straight",
    "stretch",
]
