"""Strokes: where the edge flow of a fill shall run."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import arc_length
from query.boundary import Boundary
from query.errors import InvalidQueryError

#: (side, edge): an edge of the boundary, both from 0, edges counter-clockwise along the side.
BoundaryEdge = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Stroke:
    """A strand of quads that a fill shall have: from boundary edge to boundary edge, or a loop.

    start, end: the edges that the strand shall cross; both None for a loop inside. Which is
            which does not matter.
    points: (k, 3) float64, the stroke as drawn, from start to end, or None. A loop's last
            point is joined to its first. It decides how fills are ranked and placed, not
            which there are; strokes compare without it.

    Raises InvalidQueryError where only one end is given, for both ends on one edge, and for
    points that are fewer than two, not finite, or all in one place.

    >>> Stroke((0, 2), (3, 1)).is_loop
    False
    """

    start: BoundaryEdge | None
    end: BoundaryEdge | None
    points: Points | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if (self.start is None) != (self.end is None):
            raise InvalidQueryError("a stroke has two ends, or none where it is a loop")
        if self.start is not None and self.start == self.end:
            raise InvalidQueryError(
                f"the stroke begins and ends at edge {self.start[1]} of side {self.start[0]}; "
                "a strand of quads crosses two different edges"
            )
        if self.points is not None:
            object.__setattr__(self, "points", _drawn(self.points))

    @classmethod
    def loop(cls, points: ArrayLike | None = None) -> Stroke:
        """A loop inside the fill."""
        return cls(None, None, points)  # pyright: ignore[reportArgumentType]

    @classmethod
    def drawn(cls, boundary: Boundary, points: ArrayLike) -> Stroke:
        """The stroke that a polyline (k, 3) means on a boundary whose vertices have points.

        It runs between the boundary edges whose midpoints are nearest to its ends. Raises
        InvalidQueryError for a boundary without points, or if both ends are nearest to one
        edge: a loop has to be said to be one.
        """
        if boundary.points is None:
            raise InvalidQueryError(
                "the boundary has no points to tell where the stroke begins and ends; give "
                "them, or name the edges: Stroke((side, edge), (side, edge))"
            )
        line = _drawn(points)
        middle = (boundary.points + np.roll(boundary.points, -1, axis=0)) / 2
        ends = [_edge_at(boundary, _nearest(middle, end)) for end in (line[0], line[-1])]
        return cls(ends[0], ends[1], line)

    @property
    def is_loop(self) -> bool:
        """Is it a loop inside the fill?"""
        return self.start is None

    def refuse_unless_on(self, boundary: Boundary) -> None:
        """InvalidQueryError if the boundary has no such edges."""
        for end in (self.start, self.end):
            if end is None:
                continue
            side, edge = end
            if not 0 <= side < len(boundary.lengths):
                raise InvalidQueryError(
                    f"the stroke ends on side {side}, but the boundary's sides are "
                    f"0 to {len(boundary.lengths) - 1}"
                )
            if not 0 <= edge < boundary.lengths[side]:
                raise InvalidQueryError(
                    f"the stroke ends at edge {edge} of side {side}, whose edges are "
                    f"0 to {boundary.lengths[side] - 1}"
                )


def _drawn(points: ArrayLike) -> Points:
    line = as_points(points, "the points of the stroke", InvalidQueryError)
    if len(line) < 2 or arc_length(line)[-1] == 0:
        raise InvalidQueryError("a stroke needs two points or more that are not all one")
    line.flags.writeable = False
    return line


def _nearest(points: Points, to: Points) -> int:
    return int(np.linalg.norm(points - to, axis=1).argmin())


def _edge_at(boundary: Boundary, position: int) -> BoundaryEdge:
    side = int(np.searchsorted(boundary.side_starts, position, side="right")) - 1
    return side, position - boundary.side_starts[side]
