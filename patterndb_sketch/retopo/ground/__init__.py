"""The ground that is drawn on, and what can be done on it.

- :class:`Ground`: triangles; ``nearest``, ``nearest_facing``, ``project``, ``at``.
- :func:`cleaned`: what was drawn becomes a :class:`Stroke`, even, smooth and on the ground.
- :func:`planar_cut` and :func:`geodesic`: a :class:`Trace`, exact from side to side of the
  triangles; ``Trace.sampled`` makes it a :class:`Stroke`.
- :func:`local_map`: a :class:`LocalMap`, (u, v) around a stroke or a point, both ways.
"""

from patterndb_sketch.retopo.ground.curves import Stroke, Trace, cleaned, smoothed, targets
from patterndb_sketch.retopo.ground.geodesic import geodesic
from patterndb_sketch.retopo.ground.ground import Feet, Ground, Projected
from patterndb_sketch.retopo.ground.localmap import LocalMap, Window, local_map
from patterndb_sketch.retopo.ground.planarcut import planar_cut

__all__ = [
    "Feet",
    "Ground",
    "LocalMap",
    "Projected",
    "Stroke",
    "Trace",
    "Window",
    "cleaned",
    "geodesic",
    "local_map",
    "planar_cut",
    "smoothed",
    "targets",
]
