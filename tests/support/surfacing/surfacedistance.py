"""How far two surfaces are apart: mean and greatest distance, both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from query.placing import Surface

#: Points on each of the two surfaces.
SAMPLES = 20_000

#: Steps of a sequence that fills the unit square evenly: the inverse powers of the real root of
#: x**3 = x + 1.
EVEN = 1.0 / 1.32471795724474602596 ** np.arange(1, 3)


@dataclass(frozen=True, slots=True)
class Distance:
    """Between two surfaces, in the units of their points.

    mean: the mean of the mean distances from one to the other and back.
    most: the greater of the greatest distances one way and the other (Hausdorff).
    """

    mean: float
    most: float


def spread(surface: Surface, count: int = SAMPLES) -> Points:
    """(count, 3) points on the surface, evenly by area and the same every time."""
    ends = np.cumsum(surface.areas)
    at = np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1])
    corner = surface.vertices[surface.triangles[np.minimum(at, len(ends) - 1)]]
    s, t = (0.5 + np.arange(1, count + 1)[:, None] * EVEN).T % 1.0
    over = s + t > 1.0
    s[over], t[over] = 1.0 - s[over], 1.0 - t[over]
    weights = np.stack([1.0 - s - t, s, t], axis=1)
    return np.einsum("ne,nec->nc", weights, corner)


def distance(one: Surface, other: Surface) -> Distance:
    """How far the two surfaces are apart, by SAMPLES points of each."""
    gaps: list[NDArray[np.float64]] = []
    for a, b in ((one, other), (other, one)):
        points = spread(a)
        gaps.append(np.linalg.norm(points - b.nearest(points).points, axis=1))
    return Distance(
        float(np.mean([gap.mean() for gap in gaps])), float(max(gap.max() for gap in gaps))
    )
