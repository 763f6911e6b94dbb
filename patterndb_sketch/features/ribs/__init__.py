"""Ribs: the outlines of a model in planes across a curve, whatever the model's state."""

from patterndb_sketch.features.ribs.build import SAMPLES, build_rib, build_ribs
from patterndb_sketch.features.ribs.rib import Rib
from patterndb_sketch.features.ribs.segments import STITCH, Segments, segments_of
from patterndb_sketch.features.ribs.slicing import RADIUS, Slice, slice_model

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
