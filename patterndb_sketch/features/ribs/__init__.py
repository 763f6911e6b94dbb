"""Ribs: the outlines of a model in planes across a curve, whatever the model's state.

Read slicing (a plane's cut edges, joined to segments) and rib. What rib puts together is in
rust/features/src/ribs: crossings (how segments cross and touch), repair (overhangs and gaps),
raster and walking (what is still tangled, by way of a picture), polygon (the outline, simple and
sampled).
"""

from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.ribs.rib import SAMPLES, Rib, build_rib, build_ribs
from patterndb_sketch.features.ribs.slicing import (
    STITCH,
    Segments,
    Slice,
    segments_of,
    slice_model,
)

__all__ = [
    "RADIUS",
    "SAMPLES",
    "STITCH",
    "Rib",
    "Segments",
    "Slice",
    "build_rib",
    "build_ribs",
    "segments_of",
    "slice_model",
]
