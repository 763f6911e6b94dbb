"""Curves on a surface, and its map around one.

- :func:`clean_stroke`: what was drawn becomes a :class:`SurfaceCurve`, even and smooth.
- :func:`cut_by_plane` and :func:`trace_geodesic`: a :class:`Trace`, exact from side to side of the
  triangles; ``Trace.sample`` makes it a :class:`SurfaceCurve`.
- :func:`spread_map`: a :class:`LocalMap`, (u, v) around a stroke or a point, both ways.
"""

from patterndb_sketch.retopo.tracing.curves import (
    SurfaceCurve,
    Trace,
    clean_stroke,
    smooth_polyline,
    smoothing_targets,
)
from patterndb_sketch.retopo.tracing.geodesic import trace_geodesic
from patterndb_sketch.retopo.tracing.localmap import LocalMap, MapExtent, spread_map
from patterndb_sketch.retopo.tracing.planarcut import cut_by_plane

__all__ = [
    "LocalMap",
    "MapExtent",
    "SurfaceCurve",
    "Trace",
    "clean_stroke",
    "cut_by_plane",
    "smooth_polyline",
    "smoothing_targets",
    "spread_map",
    "trace_geodesic",
]
