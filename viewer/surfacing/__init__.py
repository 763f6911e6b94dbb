"""Looking at surfaced curve networks: a window to work in, and pictures without one.

Read :mod:`patterndb_sketch.surfacing.edits` (what users made of a drawing),
:mod:`patterndb_sketch.surfacing.editing` (the surface that is made of it, in a thread),
:mod:`~viewer.surfacing.state` (a camera and the pointer on it), then
:mod:`~viewer.surfacing.picture` and :mod:`~viewer.surfacing.window`.
"""

from viewer.surfacing.state import SurfacingState, look_from
from viewer.surfacing.window import draw, show

__all__ = ["SurfacingState", "draw", "look_from", "show"]
