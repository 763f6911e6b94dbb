"""Exploring shape models: a window to pull feature curves in, and pictures without one."""

from viewer.shapes.state import ShapesState
from viewer.shapes.window import draw, show

__all__ = ["ShapesState", "draw", "show"]
