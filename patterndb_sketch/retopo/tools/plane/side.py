"""Sides of a suggested patch: stretches of boundaries that are there, and new curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.plane.boundary import Boundary

#: Points of an arc, ends included. A cubic over a tenth to two brush radii is smooth with these.
ARC_POINTS = 17


@dataclass(frozen=True, slots=True)
class Corner:
    """A corner of a suggested patch: a place on a boundary, or a new point.

    point: (2,) float64. boundary: the number of the boundary, or None if the point is new.
    place: on it; see :meth:`Boundary.at`.
    """

    point: Points
    boundary: int | None = None
    place: float = 0.0


@dataclass(frozen=True, slots=True)
class OldSide:
    """A stretch of a boundary, between two places; a patch on the left of it goes the same way."""

    boundary: int
    start: float
    end: float


@dataclass(frozen=True, slots=True, eq=False)
class NewSide:
    """A new curve from a corner of the patch to the next: (m, 2) float64 points."""

    points: Points


Side = OldSide | NewSide


def stretch(boundary: Boundary, side: OldSide) -> Points:
    """(m, 2) the points of an old side, ends included."""
    inner = np.arange(np.floor(side.start) + 1.0, np.ceil(side.end))
    return np.array([boundary.at(p) for p in (side.start, *inner, side.end)])


def straight(start: Points, end: Points) -> NewSide:
    """A straight new curve."""
    return NewSide(np.array([start, end]))


def arc(start: Points, leaving: Points, end: Points, arriving: Points) -> NewSide:
    """A cubic from a point to another with given directions.

    leaving, arriving: (2,) unit vectors, of the curve at its start and at its end. The tangents
    are as long as the ends are far apart.
    """
    length = np.linalg.norm(end - start)
    t = np.linspace(0.0, 1.0, ARC_POINTS)[:, None]
    points = (
        (2 * t**3 - 3 * t**2 + 1) * start
        + (t**3 - 2 * t**2 + t) * (length * leaving)
        + (3 * t**2 - 2 * t**3) * end
        + (t**3 - t**2) * (length * arriving)
    )
    # Ends exactly: they are vertices that are there already.
    points[0], points[-1] = start, end
    return NewSide(points)
