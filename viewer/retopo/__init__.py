"""Retopology: a window in which curves are drawn on a surface and become quads, and pictures.

Read :mod:`patterndb_sketch.retopo.editing` (the retopology, at work in a thread),
:mod:`~viewer.retopo.pointing` (a camera, what the pointer meets), :mod:`~viewer.retopo.modes`,
:mod:`~viewer.retopo.aiming` (the tool in use), :mod:`~viewer.retopo.state` (holds all these), then
:mod:`~viewer.retopo.keys`, :mod:`~viewer.retopo.picture` and :mod:`~viewer.retopo.window`.
"""

from viewer.retopo.state import RetopoState
from viewer.retopo.window import draw, show

__all__ = ["RetopoState", "draw", "show"]
