"""Feature curves on models: a window to draw them in, and pictures without one.

Read :mod:`patterndb_sketch.features.edits` (curves and what they snap to),
:mod:`patterndb_sketch.features.editing` (what is done to them, in a thread),
:mod:`~viewer.features.pointing`, :mod:`~viewer.features.state` (holds the editing, a camera and the
pointer), then :mod:`~viewer.features.keys`, :mod:`~viewer.features.picture` and
:mod:`~viewer.features.window`.
"""

from viewer.features.state import FeatureState
from viewer.features.window import draw, show

__all__ = ["FeatureState", "draw", "show"]
