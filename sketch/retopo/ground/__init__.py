"""The ground that is drawn on, and what can be done on it.

- :class:`Ground`: triangles; ``nearest``, ``nearest_facing``, ``project``, ``at``.
- :func:`cleaned`: what was drawn becomes a :class:`Stroke`, even, smooth and on the ground.
- :func:`planar_cut` and :func:`geodesic`: a :class:`Trace`, exact from side to side of the
  triangles; ``Trace.sampled`` makes it a :class:`Stroke`.
- :func:`local_map`: a :class:`LocalMap`, (u, v) around a stroke or a point, both ways.
"""

from sketch.retopo.ground.feet import Feet, Projected
from sketch.retopo.ground.geodesic import geodesic
from sketch.retopo.ground.ground import Ground
from sketch.retopo.ground.parameterise import LocalMap, Window, local_map
from sketch.retopo.ground.planarcut import planar_cut
from sketch.retopo.ground.strokes import Stroke, cleaned, smoothed, targets
from sketch.retopo.ground.trace import Trace

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
