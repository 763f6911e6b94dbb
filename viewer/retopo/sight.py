"""Sight: how a surface is looked at first: from where, and which way up."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.ground import Ground
from viewer.looking import UPRIGHT, Looking

#: From where a surface is looked at, by the axis that is upright: over its left front.
HOME = {"y": (0.62, 0.36, 1.0), "z": (-0.62, -1.0, 0.36), "x": (0.36, 1.0, 0.62)}


#: What a surface stands on is at its lower end within this part of its height, and faces down by
#: this cosine.
FOOT, DOWN = 0.02, 0.95

#: It stands along z if it has that much of its box's base there, and that many times what it has
#: along y.
BASE, MORE = 0.05, 3.0


def stands_along(ground: Ground) -> str:
    """The axis, y or z, that a surface seems to stand along: z if it is flat at its lower end there
    and not along y. Most that were modelled stand along y, and some that were measured along z."""
    corners = ground.vertices[ground.triangles]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    low, high = ground.vertices.min(axis=0), ground.vertices.max(axis=0)
    size = np.linalg.norm(area, axis=1)

    def base(axis: int) -> float:
        """The part of the box's base that the surface stands on."""
        feet = (corners[..., axis] <= low[axis] + FOOT * (high - low)[axis]).all(axis=1)
        feet &= -area[:, axis] > DOWN * size
        whole = float(np.delete(high - low, axis).prod())
        return float(size[feet].sum()) / whole if whole > 0.0 else 0.0

    return "z" if base(2) >= BASE and base(2) > MORE * base(1) else "y"


class Sight(Looking):
    """The view of a surface; see :class:`viewer.looking.Looking`.

    upright: the axis that is at first.
    """

    def __init__(self, points: Points, upright: str = "y") -> None:
        Looking.__init__(self, points)
        self.upright = upright
        self._toward = np.array(HOME[upright])
        self.view = self._framed()

    def next_upright(self) -> None:
        """Another axis is upright."""
        self.upright = UPRIGHT[(UPRIGHT.index(self.upright) + 1) % len(UPRIGHT)]
        self.fit()

    def look_along(self, direction: ArrayLike) -> None:
        """Look against a direction (3,), of space; from the other side if that is so already."""
        toward = np.array(direction, np.float64)
        toward /= np.linalg.norm(toward)
        if np.allclose(self.view.axes[2], toward):
            toward = -toward
        self._toward = toward
        self.aim(self._framed())

    def fit(self) -> None:
        """The whole surface into the middle, as it was seen at first."""
        self._toward = np.array(HOME[self.upright])
        self.view = self._framed()
        self._moved = False
