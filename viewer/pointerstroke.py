"""What is being drawn with the pointer: corners of a boundary, or a stroke."""

from __future__ import annotations

from enum import Enum

import numpy as np

from patterndb.geometry.points import Points
from query import Boundary, Stroke
from query.contour import Contour, centre_stroke_ends
from query.drawingbase import DrawingBase
from viewer.camera import View

#: A click this near to another, in points, is on the same place; a drag of less is a click.
NEAR = 7.0

#: Points of a drawn stroke are at least so far apart, in points of the picture.
STROKE_STEP = 4.0


class PointerMode(Enum):
    """What the pointer does."""

    LOOK = "look"
    CORNERS = "draw a boundary"
    STROKE = "draw a stroke"
    LOOP = "draw a loop"


class PointerStroke:
    """Draws on a base.

    clicked: (3,) corners so far; paths: (k, 3) between them; preview: from the last to where
    the pointer is. line: (3,) points of the stroke so far.
    """

    def __init__(self, base: DrawingBase) -> None:
        self.base = base
        self.lift()

    def lift(self) -> None:
        """Forget what was not finished."""
        self.clicked: list[Points] = []
        self.paths: list[Points] = []
        self.preview: Points | None = None
        self.line: list[Points] = []

    def closes(self, view: View, x: float, y: float) -> bool:
        """Is a click here on the last corner (a double click) or the first?"""
        ends = [self.clicked[0], self.clicked[-1]] if self.clicked else []
        return any(np.hypot(*(view.seen(at)[:2] - (x, y))) < NEAR for at in ends)

    def add_corner(self, view: View, x: float, y: float) -> bool:
        """Add a corner where the base is seen; return False off it."""
        at = self.base.hit(view.under(x, y), view.axes[2])
        if at is None:
            return False
        if self.clicked:
            self.paths.append(self.base.path(self.clicked[-1], at))
        self.clicked.append(at)
        self.preview = None
        return True

    def undo_corner(self) -> None:
        """Take the last corner back."""
        self.preview = None
        if self.clicked:
            self.clicked.pop()
        if self.paths:
            self.paths.pop()

    def look_ahead(self, view: View, x: float, y: float) -> None:
        """Show the way that a click here would draw."""
        at = self.base.hit(view.under(x, y), view.axes[2])
        self.preview = None if at is None else self.base.path(self.clicked[-1], at)

    def contour(self) -> Contour:
        """The clicked corners, the last joined to the first.

        Raises InvalidBoundaryError if that is no boundary.
        """
        sides = [*self.paths, self.base.path(self.clicked[-1], self.clicked[0])]
        return Contour.drawn(sides, self.base.on(np.stack(self.clicked))[1])

    def extend(self, view: View, x: float, y: float) -> None:
        """The stroke goes on to here, if the base is seen and it is far enough."""
        at = self.base.hit(view.under(x, y), view.axes[2])
        if at is None:
            return
        if self.line:
            step = view.seen(at) - view.seen(self.line[-1])
            if np.hypot(step[0], step[1]) < STROKE_STEP:
                return
        self.line.append(at)

    def stroke(self, boundary: Boundary, *, loop: bool) -> Stroke:
        """The stroke that was drawn, its ends in the middle of boundary edges.

        Raises InvalidQueryError if it is none.
        """
        line = np.stack(self.line)
        if loop:
            return Stroke.loop(line)
        return centre_stroke_ends(boundary, Stroke.drawn(boundary, line))
