"""Boundary -> fills: which patterns fit, with which widths, expanded to quads and ranked."""

from query.boundary import Boundary
from query.engine import best, fills
from query.fill import Fill

__all__ = ["Boundary", "Fill", "best", "fills"]
