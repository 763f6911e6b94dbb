"""Sides: a loop as the boundary of a fill, with its convex and reflex corners."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import InvalidBoundaryError
from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.network import angles_between
from patterndb_sketch.surfacing.sampling import Loop
from query.boundary import Boundary, CornerKind

#: Interior angles in radians at which a fill has as poor quads with a corner as without: half way
#: between one quad, square at 90 degrees, and two, at 180; and between two and three, at 270.
CONVEX_BELOW = math.radians(135)
REFLEX_ABOVE = math.radians(225)


def interior_angles(n: int, points: Points, triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """(n,) the angle inside a patch at each of its n boundary vertices, in radians, from 0 on.

    points: (v, 3), the boundary's first. triangles: (t, 3) of the patch. The angle is the sum of
    the triangles' there: it is measured along the surface, so that no plane need be chosen for
    a loop that has none.
    """
    corner = points[triangles]
    angle = np.zeros(len(points))
    for e in range(3):
        out, back = corner[:, (e + 1) % 3] - corner[:, e], corner[:, (e + 2) % 3] - corner[:, e]
        np.add.at(angle, triangles[:, e], angles_between(out, back))
    return angle[:n]


def boundary_of(loop: Loop, points: Points, triangles: NDArray[np.integer]) -> tuple[Boundary, int]:
    """The boundary that a fill of the loop has, and the position in the loop where it begins.

    points: (v, 3), the loop's first; triangles: (t, 3), a patch within the loop. Boundary
    vertex i is position (start + i) % n of the loop, in the loop's sense. A corner of the loop is
    one of the boundary if its interior angle is below CONVEX_BELOW or above REFLEX_ABOVE; a loop
    without such corners is one closed side, which fills have a ring of quads along.

    Not every turning by more than 20 degrees, which chords take for a corner, is one here: a turn
    by 25 degrees leaves a single quad with an angle of 155 where two have 77 each. The bounds lie
    half way between what suits one, two and three quads. A corner may be reflex.

    Raises InvalidNetworkError, saying what would mend it, for loops that no quads can fill: with
    an odd number of vertices, fewer than 4, or more than 2,000.
    """
    n = len(loop.points)
    angle = interior_angles(n, points, triangles)
    convex = loop.corners & (angle < CONVEX_BELOW)
    reflex = loop.corners & (angle > REFLEX_ABOVE)
    at = np.flatnonzero(convex | reflex)
    try:
        if not len(at):
            return Boundary.closed(n, loop.points), 0
        lengths = np.diff(np.r_[at, at[0] + n])
        kinds: list[CornerKind] = ["convex" if convex[i] else "reflex" for i in at]
        start = int(at[0])
        return Boundary(lengths.tolist(), kinds, np.roll(loop.points, -start, axis=0)), start
    except InvalidBoundaryError as error:
        raise InvalidNetworkError(f"no quads can fill a loop of {n} vertices: {error}") from error
