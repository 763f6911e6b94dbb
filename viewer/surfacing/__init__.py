"""Looking at surfaced curve networks: a window to work in, and pictures without one."""

from viewer.surfacing.state import SurfacingState
from viewer.surfacing.window import draw, show

__all__ = ["SurfacingState", "draw", "show"]
