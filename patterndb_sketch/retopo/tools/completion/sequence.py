"""Sequences: what a window shows of the boundaries around it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.plane import Boundary

#: How far a window reaches behind the boundary that it stands on, and ahead of it, as multiples
#: of its half-width.
BEHIND, AHEAD = 0.25, 2.0


@dataclass(frozen=True, slots=True)
class Window:
    """What is looked at: abs(u) <= size, and v from -0.25 size to 2 size."""

    size: float

    @property
    def low(self) -> tuple[float, float]:
        return -self.size, -BEHIND * self.size

    @property
    def high(self) -> tuple[float, float]:
        return self.size, AHEAD * self.size

    def has(self, points: Points) -> NDArray[np.bool_]:
        """(n,) are the points in it? NaN is not."""
        return np.all((points >= self.low) & (points <= self.high), axis=1)

    def leaves(self, inside: Points, outside: Points) -> float:
        """Which part of the way from a point inside to one outside is inside."""
        step = outside - inside
        parts = [1.0]
        for k in range(2):
            room = (self.high[k] if step[k] > 0.0 else self.low[k]) - inside[k]
            if abs(room) < abs(step[k]):
                parts.append(room / step[k])
        return max(0.0, min(parts))


@dataclass(frozen=True, eq=False)
class Sequence:
    """A run of edges of a boundary, each with an end in the window.

    boundary: its number. places: (m,) float64, ascending, of its points on the boundary; the
    first and the last may be within an edge, where the window cuts it. points: (m, 2) float64.
    corners:  numbers of the points strictly between the ends at which corners are.
    before, after: (2,) float64, the vertices that the cut edges come from and go to, which tell
    the directions of these edges even where next to nothing of them is left.
    whole:    is it all of a closed boundary? Its last point is then its first again.

    Differs from the released program: runs end on the edge of the window, not a vertex beyond,
    so that a suggestion does not depend on where vertices happen to be.
    """

    boundary: int
    places: NDArray[np.float64]
    points: Points
    corners: tuple[int, ...]
    before: Points
    after: Points
    whole: bool = False

    @property
    def first(self) -> int:
        """The number of the first point."""
        return 0

    @property
    def last(self) -> int:
        """The number of the last point."""
        return len(self.points) - 1

    def reach(self, corner: int, distance: float, *, forward: bool) -> float:
        """The place at this distance from a corner, on the way out; the end if all is nearer.

        corner: number of a point.
        """
        order = range(corner + 1, len(self.points)) if forward else range(corner - 1, -1, -1)
        centre, near = self.points[corner], corner
        for k in order:
            if np.linalg.norm(self.points[k] - centre) >= distance:
                start, step = self.points[near] - centre, self.points[k] - self.points[near]
                # The greater root of |start + t step| = distance: the way out.
                a, b = step @ step, start @ step
                c = start @ start - distance * distance
                t = (-b + np.sqrt(max(b * b - a * c, 0.0))) / a
                return float(self.places[near] + t * (self.places[k] - self.places[near]))
            near = k
        return float(self.places[near])


def sequences(boundaries: list[Boundary], window: Window) -> list[Sequence]:
    """All sequences of the boundaries in a window."""
    return [
        run for number, boundary in enumerate(boundaries) for run in _runs(number, boundary, window)
    ]


def _runs(number: int, boundary: Boundary, window: Window) -> Iterator[Sequence]:
    points, n = boundary.points, len(boundary.points)
    inside = window.has(points)
    if n < 2 or not inside.any():
        return
    known = np.isfinite(points).all(axis=1)
    shown = (inside | np.roll(inside, -1)) & known & np.roll(known, -1)
    if not boundary.closed:
        shown[-1] = False
    if shown.all():
        # All of a closed boundary: from its first corner around to it again.
        at = np.flatnonzero(boundary.corner)
        start = int(at[0]) if len(at) else 0
        order = (start + np.arange(n + 1)) % n
        yield Sequence(
            number,
            start + np.arange(n + 1, dtype=np.float64),
            points[order],
            tuple(int(k) for k in np.flatnonzero(boundary.corner[order][:-1])),
            points[order[-2]],
            points[order[1]],
            whole=True,
        )
        return
    begins = np.flatnonzero(shown & ~np.roll(shown, 1))
    for begin in begins:
        length = 0
        while shown[(begin + length) % n]:
            length += 1
        yield _cut(number, boundary, window, int(begin), length)


def _cut(number: int, boundary: Boundary, window: Window, begin: int, length: int) -> Sequence:
    """The run of ``length`` edges from vertex ``begin`` on, ends cut on the window's edge."""
    n = len(boundary.points)
    order = (begin + np.arange(length + 1)) % n
    points = boundary.points[order]
    places = begin + np.arange(length + 1, dtype=np.float64)
    corners = np.flatnonzero(boundary.corner[order])
    before, after = points[0].copy(), points[-1].copy()
    inside = window.has(points[[0, -1]])
    if not inside[0]:
        part = window.leaves(points[1], points[0])
        places[0] = places[1] - part
        points[0] = boundary.at(places[0]) if part < 1.0 else before
    if not inside[1]:
        part = window.leaves(points[-2], points[-1])
        places[-1] = places[-2] + part
        points[-1] = boundary.at(places[-1]) if part < 1.0 else after
    between = tuple(int(k) for k in corners if 0 < k < length)
    return Sequence(number, places, points, between, before, after)
