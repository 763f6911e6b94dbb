"""Feature curves on models: a window to draw them in, and pictures without one."""

from viewer.features.state import FeatureState
from viewer.features.window import draw, show

__all__ = ["FeatureState", "draw", "show"]
