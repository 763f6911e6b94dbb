"""Retopology: a window in which curves are drawn on a surface and become quads, and pictures."""

from viewer.retopo.state import RetopoState
from viewer.retopo.window import draw, show

__all__ = ["RetopoState", "draw", "show"]
