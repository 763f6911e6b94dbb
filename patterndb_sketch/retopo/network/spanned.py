"""Does a four-sided loop run around a strip of the surface, however far that is bent?

Equation 1 looks at a loop from its middle. A strip that goes three quarters around a limb has its
middle beside itself, inside the limb: seen from there it has hardly any area. What spans the loop
from side to side lies along the strip, and tells.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length

#: Points along a side of what spans the loop.
POINTS = 17

#: A loop runs around a strip if what spans it faces as the surface does, by this share of its
#: area: a ring around a limb, spanned by a disk across it, has 0, and a strip from behind -1.
FACING = 0.5


def is_strip(sides: Sequence[tuple[Points, Points]]) -> bool:
    """Is a loop of four sides counter-clockwise around a strip, seen from outside?

    sides: (n, 3) points and (n, 3) normals of each from corner to corner, in the loop's sense. What
    spans it is a bilinearly blended patch (Coons 1967).
    """
    points = _blended([_even(line, line) for line, _ in sides])
    normals = _blended([_even(line, up) for line, up in sides])
    across = points[1:, 1:] - points[:-1, :-1], points[:-1, 1:] - points[1:, :-1]
    area = np.cross(*across).reshape(-1, 3) / 2.0
    up = units(
        (normals[1:, 1:] + normals[:-1, :-1] + normals[:-1, 1:] + normals[1:, :-1]).reshape(-1, 3)
    )
    whole = float(np.linalg.norm(area, axis=1).sum())
    return whole > 0.0 and float(np.einsum("nc,nc->", area, up)) > FACING * whole


def _even(line: Points, values: Points) -> Points:
    """(POINTS, 3) of the values along a polyline (n, 3), at equal arc length."""
    along = arc_length(line)
    wanted = np.linspace(0.0, along[-1], POINTS)
    return np.stack([np.interp(wanted, along, values[:, d]) for d in range(3)], axis=1)


def _blended(sides: list[Points]) -> Points:
    """(POINTS, POINTS, 3) between the four sides of a loop; rows follow the first."""
    south, east, north, west = sides[0], sides[1], sides[2][::-1], sides[3][::-1]
    t = np.linspace(0.0, 1.0, POINTS)
    u, v = t[:, None, None], t[None, :, None]
    ruled = (1 - v) * south[:, None] + v * north[:, None] + (1 - u) * west[None] + u * east[None]
    corners = (
        (1 - u) * (1 - v) * south[0]
        + u * (1 - v) * south[-1]
        + u * v * north[-1]
        + (1 - u) * v * north[0]
    )
    return ruled - corners
