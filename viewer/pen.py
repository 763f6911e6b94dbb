"""What is being drawn with the pointer: corners of a boundary, or a stroke."""

from __future__ import annotations

from enum import Enum
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from query import Boundary, Stroke
from viewer.contour import Contour
from viewer.ground import Ground
from viewer.view import View

#: A click this near to another, in points, is on the same place; a drag of less is a click.
NEAR = 7.0

#: Points of a drawn stroke are at least so far apart, in points of the picture.
STROKE_STEP = 4.0

#: A drawn stroke gives way to the way to the middle of its boundary edges for so many times the
#: length of that.
EASE = 2.0


class Mode(Enum):
    """What the pointer does."""

    LOOK = "look"
    CORNERS = "draw a boundary"
    STROKE = "draw a stroke"
    LOOP = "draw a loop"


class Pen:
    """Draws on a ground.

    clicked: (3,) corners so far; paths: (k, 3) between them; preview: from the last to where
    the pointer is. line: (3,) points of the stroke so far.
    """

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
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
        """A corner where the ground is seen; False beside it."""
        at = self.ground.hit(view, x, y)
        if at is None:
            return False
        if self.clicked:
            self.paths.append(self.ground.path(self.clicked[-1], at))
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
        at = self.ground.hit(view, x, y)
        self.preview = None if at is None else self.ground.path(self.clicked[-1], at)

    def contour(self) -> Contour:
        """The clicked corners, the last joined to the first.

        Raises InvalidBoundaryError if that is no boundary.
        """
        sides = [*self.paths, self.ground.path(self.clicked[-1], self.clicked[0])]
        return Contour.drawn(sides, self.ground.on(np.stack(self.clicked))[1])

    def extend(self, view: View, x: float, y: float) -> None:
        """The stroke goes on to here, if the ground is seen and it is far enough."""
        at = self.ground.hit(view, x, y)
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
        return Stroke.loop(line) if loop else _snapped(boundary, Stroke.drawn(boundary, line))


def _snapped(boundary: Boundary, stroke: Stroke) -> Stroke:
    """A stroke made to begin and end in the middle of its boundary edges."""
    assert boundary.points is not None and stroke.points is not None
    ends: list[Points] = []
    for end in (stroke.start, stroke.end):
        assert end is not None
        at = boundary.side_starts[end[0]] + end[1]
        ends.append((boundary.points[at] + boundary.points[(at + 1) % boundary.perimeter]) / 2.0)
    # What was drawn nearer to its ends than they were off would leave a kink.
    along = arc_length(stroke.points)
    off = EASE * np.array(
        [np.linalg.norm(e - p) for e, p in zip(ends, stroke.points[[0, -1]], strict=True)]
    )
    inner = stroke.points[(along >= off[0]) & (along[-1] - along >= off[1])]
    line = np.concatenate([ends[:1], inner, ends[1:]])
    apart = [True, *(bool((a != b).any()) for a, b in pairwise(line))]
    return Stroke(stroke.start, stroke.end, line[apart])
