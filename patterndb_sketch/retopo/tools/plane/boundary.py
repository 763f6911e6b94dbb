"""Boundaries of patches in the plane of a local parameterisation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points


@dataclass(frozen=True, eq=False)
class Boundary:
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
