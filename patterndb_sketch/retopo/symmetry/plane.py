"""The plane of symmetry."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.errors import InvalidRetopoError

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane that mirrors; what is drawn lies on the side that its normal points to.

    point: on it. normal: of unit length. By default x = 0, and drawn is where x > 0.
    Raises InvalidRetopoError for what is not finite, and for a normal of another length.
    """

    point: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not (_three(self.point) and _three(self.normal)):
            raise InvalidRetopoError(
                f"the plane has the point {self.point} and the normal {self.normal}; "
                "give three finite numbers for each"
            )
        if abs(math.hypot(*self.normal) - 1.0) > 1e-9:
            raise InvalidRetopoError(
                f"the plane's normal {self.normal} is not of length 1; Plane.of takes any"
            )

    @classmethod
    def of(cls, point: ArrayLike, normal: ArrayLike) -> Plane:
        """Through a point (3,), at right angles to a direction (3,) of any length but 0."""
        at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
        size = float(np.linalg.norm(up)) if up.shape == (3,) else 0.0
        if at.shape != (3,) or not (math.isfinite(size) and size > 0.0):
            raise InvalidRetopoError(
                f"the plane has the point {point!r} and the normal {normal!r}; "
                "give [x, y, z] for each, the normal not 0"
            )
        # Adding 0 makes 0 of -0.
        x, y, z = (at + 0.0).tolist()
        u, v, w = (up / size + 0.0).tolist()
        return cls((x, y, z), (u, v, w))

    @property
    def reversed(self) -> Plane:
        """The same plane, drawn on its other side."""
        u, v, w = self.normal
        return replace(self, normal=(0.0 - u, 0.0 - v, 0.0 - w))

    def heights(self, points: Points) -> NDArray[np.float64]:
        """(n,) how far (n, 3) points are from it, positive on the side that is drawn on."""
        return (points - np.array(self.point)) @ np.array(self.normal)

    def mirrored(self, points: Points) -> Points:
        """(n, 3) the images of points."""
        return points - (2.0 * self.heights(points))[:, None] * np.array(self.normal)

    def mirrored_directions(self, directions: Points) -> Points:
        """(n, 3) the images of directions."""
        up = np.array(self.normal)
        return directions - (2.0 * (directions @ up))[:, None] * up

    def flattened(self, points: Points) -> Points:
        """(n, 3) the points of the plane nearest to points."""
        return points - self.heights(points)[:, None] * np.array(self.normal)

    def flattened_normals(self, normals: Points) -> Points:
        """(n, 3) unit normals turned into the plane; those at right angles to it stay.

        Half of a surface and its image have together these normals at the seam.
        """
        up = np.array(self.normal)
        flat = normals - (normals @ up)[:, None] * up
        level = np.linalg.norm(flat, axis=1) > 1e-6
        return np.where(level[:, None], units(flat), normals)


def _three(vector: Vector) -> bool:
    return len(vector) == 3 and all(math.isfinite(x) for x in vector)
