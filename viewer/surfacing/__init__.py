"""Looking at surfaced curve networks: a window to work in, and pictures without one.

Read :mod:`patterndb_sketch.surfacing.edits` (what users made of a drawing),
:mod:`~viewer.surfacing.maker` and :mod:`~viewer.surfacing.surfaces` (the surface that is made of
it), :mod:`~viewer.surfacing.ink` (a stroke while it is drawn), :mod:`~viewer.surfacing.body`,
:mod:`~viewer.surfacing.state` (holds surfaces, a camera and the pointer), then
:mod:`~viewer.surfacing.picture` and :mod:`~viewer.surfacing.window`.
"""

from viewer.surfacing.state import SurfacingState, look_from
from viewer.surfacing.window import draw, show

__all__ = ["SurfacingState", "draw", "look_from", "show"]
