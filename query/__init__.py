"""Boundary -> fills: which patterns fit, with which widths, expanded to quads and ranked."""

from query.boundary import Boundary
from query.engine import best, fills
from query.fill import Fill
from query.listing.stream import Fills
from query.stroke import Stroke

__all__ = ["Boundary", "Fill", "Fills", "Stroke", "best", "fills"]
