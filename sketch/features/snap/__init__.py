"""Snapping: a sketched curve moves to the feature beside it."""

from sketch.features.snap.curve import FeatureCurve
from sketch.features.snap.settings import SnapSettings
from sketch.features.snap.snap import Snap, snap

__all__ = ["FeatureCurve", "Snap", "SnapSettings", "snap"]
