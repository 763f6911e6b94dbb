"""Join drawn curves: where they meet, the nodes there, and the network that comes of it.

Read polylines (curves as they come), meetings (where they meet), junctions (the network).
"""

from patterndb_sketch.surfacing.joining.junctions import (
    JoinedCurves,
    join_polylines,
    network_of_polylines,
)

__all__ = ["JoinedCurves", "join_polylines", "network_of_polylines"]
