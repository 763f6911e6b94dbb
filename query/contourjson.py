"""A boundary and strokes while they are drawn, as JSON has them.

    {"sides": [[[x, y, z], ...], ...], "corners": ["convex", ...], "lengths": [4, ...],
     "placed": false}
    {"start": [0, 1], "end": [2, 0], "points": [[x, y, z], ...]}

A loop has null for both ends, and a stroke that was named, not drawn, null for its points.
"""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.documents import JsonModel, Pair, Point, Polyline, complete_points
from query.boundary import CornerKind
from query.contour import Contour
from query.stroke import BoundaryEdge, Stroke


class ContourEntries(JsonModel):
    """A boundary."""

    sides: list[Polyline]
    corners: list[CornerKind]
    lengths: list[int]
    placed: bool


class DrawnStrokeEntries(JsonModel):
    """A stroke."""

    start: Pair | None
    end: Pair | None
    points: list[Point] | None


def contour_document(contour: Contour) -> dict[str, object]:
    """Make the document of a boundary."""
    return {
        "sides": [side.tolist() for side in contour.sides],
        "corners": list(contour.corners),
        "lengths": list(contour.lengths),
        "placed": contour.placed,
    }


def contour_of(entries: ContourEntries) -> Contour:
    """Make a boundary of its entries; it need not be a boundary yet."""
    sides = tuple(map(_points, entries.sides))
    return Contour(sides, tuple(entries.corners), tuple(entries.lengths), entries.placed)


def stroke_document(stroke: Stroke) -> dict[str, object]:
    """Make the document of a stroke."""
    return {
        "start": None if stroke.start is None else list(stroke.start),
        "end": None if stroke.end is None else list(stroke.end),
        "points": None if stroke.points is None else stroke.points.tolist(),
    }


def stroke_of(entries: DrawnStrokeEntries) -> Stroke:
    """Make a stroke of its entries; raises InvalidQueryError for what is none."""
    points = None if entries.points is None else _points(entries.points)
    return Stroke(_edge(entries.start), _edge(entries.end), points)


def _edge(found: list[int] | None) -> BoundaryEdge | None:
    return None if found is None else (found[0], found[1])


def _points(points: list[list[float]]) -> Points:
    return np.array(complete_points(points), np.float64)
