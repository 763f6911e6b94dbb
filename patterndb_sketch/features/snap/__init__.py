"""Snapping: a sketched curve moves to the feature beside it."""

from patterndb_sketch.features.snap.curve import FeatureCurve
from patterndb_sketch.features.snap.settings import SnapSettings
from patterndb_sketch.features.snap.snap import Snap, snap

__all__ = ["FeatureCurve", "Snap", "SnapSettings", "snap"]
