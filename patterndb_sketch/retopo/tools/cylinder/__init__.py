"""Cylinder: a stroke from loop to loop makes a row of patches between them, and their caps.

:mod:`.rings` finds the loops, :mod:`.pairing` which points of one belong to which of the other,
:mod:`.caps` what lies beyond them, and :mod:`.cylinder` joins them by geodesics.
"""

from patterndb_sketch.retopo.tools.cylinder.caps import CAPS, Caps
from patterndb_sketch.retopo.tools.cylinder.cylinder import DIVISION, cylinder
from patterndb_sketch.retopo.tools.cylinder.rings import Ring, ring_at, rings

__all__ = ["CAPS", "DIVISION", "Caps", "Ring", "cylinder", "ring_at", "rings"]
