"""The surface that is drawn on, and what can be done on it.

Read :mod:`.ground`, :mod:`.orientation` and :mod:`.topology` (the triangles), :mod:`.curves`, then
what draws on them: :mod:`.planarcut`, :mod:`.geodesic` and :mod:`.localmap`.

- :class:`Ground`: triangles; ``nearest``, ``nearest_facing``, ``project``, ``at``.
- :func:`clean_stroke`: what was drawn becomes a :class:`SurfaceCurve`, even, smooth, on the
surface.
- :func:`cut_by_plane` and :func:`trace_geodesic`: a :class:`Trace`, exact from side to side of the
  triangles; ``Trace.sample`` makes it a :class:`SurfaceCurve`.
- :func:`spread_map`: a :class:`LocalMap`, (u, v) around a stroke or a point, both ways.
"""

from patterndb_sketch.retopo.ground.curves import (
    SurfaceCurve,
    Trace,
    clean_stroke,
    smooth_polyline,
    smoothing_targets,
)
from patterndb_sketch.retopo.ground.geodesic import trace_geodesic
from patterndb_sketch.retopo.ground.ground import Ground, ProjectedPoints, SurfacePoints
from patterndb_sketch.retopo.ground.localmap import LocalMap, MapExtent, spread_map
from patterndb_sketch.retopo.ground.planarcut import cut_by_plane

__all__ = [
    "Ground",
    "LocalMap",
    "MapExtent",
    "ProjectedPoints",
    "SurfaceCurve",
    "SurfacePoints",
    "Trace",
    "clean_stroke",
    "cut_by_plane",
    "smooth_polyline",
    "smoothing_targets",
    "spread_map",
    "trace_geodesic",
]
