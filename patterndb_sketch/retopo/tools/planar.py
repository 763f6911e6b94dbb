"""Plan a patch in the plane of a local parameterisation, against the boundaries around it.

Read :class:`PlanarBoundary` (what is there), :class:`OldSide` and :class:`NewSide` (what sides
consist of), :class:`PlanarPatch`, and :func:`find_fault` (what no new patch may do: cross
boundaries or itself, or be inside out).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points


@dataclass(frozen=True, eq=False)
class PlanarBoundary:
    """A boundary of patches in the plane of a local parameterisation, empty to its left.

    points: (n, 2) float64 u and v of its vertices in order, NaN where there are none.
    corner: (n,) bool, the vertices at which some patch has a corner, T-junctions too.
    closed: does the last vertex join the first?
    """

    points: Points
    corner: NDArray[np.bool_]
    closed: bool = False

    @cached_property
    def edges(self) -> tuple[Points, Points]:
        """Starts and ends (m, 2) of the edges that lie in the plane."""
        tail, head = self.points, np.roll(self.points, -1, axis=0)
        if not self.closed:
            tail, head = tail[:-1], head[:-1]
        known = np.isfinite(tail).all(axis=1) & np.isfinite(head).all(axis=1)
        return tail[known], head[known]

    def at(self, place: float) -> Points:
        """(2,) the point at a place: the number of a vertex, and the part of the edge after it.

        Places of a closed boundary go on beyond its last vertex.
        """
        n = len(self.points)
        before = int(np.floor(place))
        part = place - before
        start = self.points[before % n]
        return start if part == 0.0 else start + part * (self.points[(before + 1) % n] - start)


#: Points of an arc, ends included. A cubic over a tenth to two brush radii is smooth with these.
ARC_POINTS = 17


@dataclass(frozen=True, slots=True)
class PlanarCorner:
    """A corner of a suggested patch: a place on a boundary, or a new point.

    point: (2,) float64. boundary: the number of the boundary, or None if the point is new.
    place: on it; see :meth:`PlanarBoundary.at`.
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


def stretch_points(boundary: PlanarBoundary, side: OldSide) -> Points:
    """(m, 2) the points of an old side, ends included."""
    inner = np.arange(np.floor(side.start) + 1.0, np.ceil(side.end))
    return np.array([boundary.at(p) for p in (side.start, *inner, side.end)])


def make_line(start: Points, end: Points) -> NewSide:
    """A straight new curve."""
    return NewSide(np.array([start, end]))


def make_arc(start: Points, leaving: Points, end: Points, arriving: Points) -> NewSide:
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


@dataclass(frozen=True, slots=True, eq=False)
class PlanarPatch:
    """A patch that closes against boundaries.

    corners: counter-clockwise. sides: from each corner to the next, the stretches and new curves
    that it consists of, each beginning where the one before it ends.
    """

    corners: tuple[PlanarCorner, ...]
    sides: tuple[tuple[Side, ...], ...]

    @property
    def points(self) -> Points:
        """(k, 2) the corners."""
        return np.array([corner.point for corner in self.corners])

    @property
    def parts(self) -> tuple[Side, ...]:
        """What the sides consist of, all around."""
        return tuple(chain.from_iterable(self.sides))

    @property
    def curves(self) -> list[Points]:
        """The new curves, each (m, 2)."""
        return [side.points for side in self.parts if isinstance(side, NewSide)]

    def outline(self, boundaries: Sequence[PlanarBoundary]) -> Points:
        """(m, 2) the patch's border, counter-clockwise, its first point not repeated."""
        return np.concatenate(
            [
                (
                    part.points
                    if isinstance(part, NewSide)
                    else stretch_points(boundaries[part.boundary], part)
                )[:-1]
                for part in self.parts
            ]
        )


#: The part of a new curve at either end that is not looked at, since it touches what it joins.
TRIM = 1e-6

#: A loop is a patch if its area is more than this part of a circle's of its length.
ROUNDNESS = 0.1

#: Corners nearer than this part of the patch's extent are one.
APART = 1e-9


def find_fault(patch: PlanarPatch, boundaries: Sequence[PlanarBoundary]) -> str | None:
    """Why the patch cannot be, in words that end "the patch would ...", or None if it can."""
    if not _corners_apart(patch):
        return "have two corners in one place"
    curves = [_trim(curve) for curve in patch.curves]
    old = [np.concatenate(ends) for ends in zip(*(b.edges for b in boundaries), strict=True)]
    for curve in curves:
        if old and _find_crossings(curve[:-1], curve[1:], old[0], old[1]).any():
            return "cross a curve that is there"
        if _crosses_itself(curve):
            return "cross itself"
    for a, b in combinations(curves, 2):
        if _find_crossings(a[:-1], a[1:], b[:-1], b[1:]).any():
            return "cross itself"
    if not _is_patch(patch.outline(boundaries)):
        return "be inside out, or have next to no area"
    return None


def _find_crossings(a: Points, b: Points, c: Points, d: Points) -> NDArray[np.bool_]:
    """(m, n) does segment a b (m, 2) pass through segment c d (n, 2)?

    What lies on a line counts as left of it, so a line through a common end of two segments
    that go on across it passes through one of them, and a line along them through none.
    """
    a, b = a[:, None], b[:, None]
    c, d = c[None], d[None]
    return (_left(a, b, c) != _left(a, b, d)) & (_left(c, d, a) != _left(c, d, b))


def _left(a: Points, b: Points, c: Points) -> NDArray[np.bool_]:
    """Is c left of a b, or on it?"""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] >= 0.0


def _trim(points: Points) -> Points:
    points = points.copy()
    points[0] += TRIM * (points[1] - points[0])
    points[-1] += TRIM * (points[-2] - points[-1])
    return points


def _crosses_itself(curve: Points) -> bool:
    tail, head = curve[:-1], curve[1:]
    found = _find_crossings(tail, head, tail, head)
    # Neighbours touch, and rounding may call that crossing.
    return bool(np.triu(found, 2).any())


def _corners_apart(patch: PlanarPatch) -> bool:
    points = patch.points
    extent = float(np.ptp(points, axis=0).max())
    gaps = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1)
    # A stretch of a boundary may begin and end in one place, if it goes around.
    old = [any(isinstance(part, OldSide) for part in side) for side in patch.sides]
    return bool(((gaps > APART * extent) | np.array(old)).all()) and extent > 0.0


def _is_patch(loop: Points) -> bool:
    """Eq. 1 of the paper, or most of the loop's fan the right way about.

    Differs from the paper: its test alone refuses ribbons, whose area is small for their length.
    """
    centre = loop.mean(axis=0)
    a, b = loop - centre, np.roll(loop, -1, axis=0) - centre
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area, fan = doubled.sum() / 2.0, np.abs(doubled).sum() / 2.0
    length = np.linalg.norm(b - a, axis=1).sum()
    return bool(area > ROUNDNESS * length * length / (4.0 * np.pi) or area > fan / 2.0)
