"""Sight: how a surface is looked at first. Most stand along y and face along z."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewer.features.looking import UPRIGHT, Looking

Points = NDArray[np.float64]

#: From where a surface is looked at, by the axis that is upright: over its left front.
HOME = {"y": (0.62, 0.36, 1.0), "z": (-0.62, -1.0, 0.36), "x": (0.36, 1.0, 0.62)}


class Sight(Looking):
    """The view of a surface; see :class:`viewer.features.looking.Looking`."""

    def __init__(self, points: Points) -> None:
        Looking.__init__(self, points)
        self.upright = "y"
        self._toward = np.array(HOME["y"])
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
        self.view = self._framed()
        self._moved = True

    def fit(self) -> None:
        """The whole surface into the middle, as it was seen at first."""
        self._toward = np.array(HOME[self.upright])
        self.view = self._framed()
        self._moved = False
