"""Exploring shape models: a window to pull feature curves in, and pictures without one.

Read :mod:`patterndb_sketch.features.shapemodel.shaping` (the shape that is made, and the way back),
:mod:`~viewer.shapes.skin` and :mod:`~viewer.shapes.sight` (how it is seen),
:mod:`~viewer.shapes.state` (holds the shaping, a camera and the pointer), then
:mod:`~viewer.shapes.picture` and :mod:`~viewer.shapes.window`.
"""

from viewer.shapes.state import ShapesState
from viewer.shapes.window import draw, show

__all__ = ["ShapesState", "draw", "show"]
