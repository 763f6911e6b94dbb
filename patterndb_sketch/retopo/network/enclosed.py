"""Does a loop enclose a part of the surface, seen from outside?"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

#: A loop encloses if its area is this part of a circle's of its length. Source: Takayama et
#: al. 2013, section 5.1.
ROUND = 0.1

#: ... or this part of the area that its triangles have without their signs: long ribbons are
#: far from round.
FLAT = 0.5

#: ... and is more than this part of a circle's: less is rounding, of a curve that runs back upon
#: itself. A ribbon is so round if it is a million times as long as wide.
NOTHING = 1e-6


@dataclass(frozen=True, slots=True)
class Enclosed:
    """What a loop encloses.

    area:     signed, positive if the loop runs counter-clockwise seen from outside.
    unsigned: the same without the signs of its triangles.
    length:   of the loop.
    """

    area: float
    unsigned: float
    length: float

    @property
    def roundness(self) -> float:
        """The area as a part of that of a circle of the same length: 1 for a circle."""
        return self.area * 4.0 * math.pi / self.length**2 if self.length > 0.0 else 0.0

    @property
    def encloses(self) -> bool:
        """Is it to be a patch?

        Differs from the paper: counter-clockwise ribbons count however long they are. Equation
        1 with its lambda = 0.1 loses rectangles longer than 29 to 1.
        """
        roundness = self.roundness
        return roundness > ROUND or (roundness > NOTHING and self.area > FLAT * self.unsigned)


def enclosed(points: Points, normals: Points) -> Enclosed:
    """Of a closed polyline (n, 3), which does not repeat its first point, with the surface's
    normals (n, 3).

    Source: Takayama et al. 2013, equation 1, with the mean of the points as the centre.
    """
    if len(points) < 2:
        return Enclosed(0.0, 0.0, 0.0)
    return Enclosed(*_sums(np.ascontiguousarray(points), np.ascontiguousarray(normals)))


@kernel
def _sums(points: Points, normals: Points) -> tuple[float, float, float]:
    n = len(points)
    centre = np.zeros(3)
    for i in range(n):
        for c in range(3):
            centre[c] += points[i, c] / n
    area = 0.0
    unsigned = 0.0
    length = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        ux, uy, uz = points[i, 0] - centre[0], points[i, 1] - centre[1], points[i, 2] - centre[2]
        vx, vy, vz = points[j, 0] - centre[0], points[j, 1] - centre[1], points[j, 2] - centre[2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        area += 0.5 * (x * normals[i, 0] + y * normals[i, 1] + z * normals[i, 2])
        unsigned += 0.5 * math.sqrt(x * x + y * y + z * z)
        length += math.sqrt((vx - ux) ** 2 + (vy - uy) ** 2 + (vz - uz) ** 2)
    return area, unsigned, length
