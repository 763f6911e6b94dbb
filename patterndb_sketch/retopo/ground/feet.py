"""Points on the surface, each with its triangle and normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.surface import Points


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Points on the surface.

    points: (n, 3) float64. normals: (n, 3) float64 unit normals, interpolated between the
    vertices'. triangles: (n,) int32. weights: (n, 3) float64 barycentric, of the triangle's
    corners; none below 0, sum 1.
    """

    points: Points
    normals: Points
    triangles: Int32Array
    weights: Points

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, which: slice | NDArray[np.integer] | NDArray[np.bool_]) -> Feet:
        """Some of them, by a slice or an index array; for one take ``feet[i : i + 1]``."""
        return Feet(
            self.points[which], self.normals[which], self.triangles[which], self.weights[which]
        )


@dataclass(frozen=True, slots=True, eq=False)
class Projected:
    """Points taken to the surface along their normals.

    feet:   where they are now, all of them on the surface.
    missed: (k,) int32 numbers of those whose line met no triangle that faces as the normal
            does, or only too far off: they are at the nearest point that does face so.
    lost:   (l,) int32 numbers of those, not among ``missed``, for which no triangle of the
            whole surface faces as the normal does: they are at the nearest point of all.
    """

    feet: Feet
    missed: Int32Array
    lost: Int32Array

    @property
    def points(self) -> Points:
        """(n, 3) float64."""
        return self.feet.points

    @property
    def normals(self) -> Points:
        """(n, 3) float64 unit normals of the surface."""
        return self.feet.normals
