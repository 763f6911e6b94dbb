"""A patch that a tool would make, in the plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.plane.boundary import Boundary
from patterndb_sketch.retopo.tools.plane.side import Corner, NewSide, Side, stretch


@dataclass(frozen=True, slots=True, eq=False)
class PlanarPatch:
    """A patch that closes against boundaries.

    corners: counter-clockwise. sides: from each corner to the next, the stretches and new curves
    that it consists of, each beginning where the one before it ends.
    """

    corners: tuple[Corner, ...]
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

    def outline(self, boundaries: Sequence[Boundary]) -> Points:
        """(m, 2) the patch's border, counter-clockwise, its first point not repeated."""
        return np.concatenate(
            [
                (
                    part.points
                    if isinstance(part, NewSide)
                    else stretch(boundaries[part.boundary], part)
                )[:-1]
                for part in self.parts
            ]
        )
