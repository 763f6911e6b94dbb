"""Density as colours while it is painted: finer is warm, coarser is cold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network import EVEN, Density
from viewer import style

FINER, COARSER = "#d9541e", "#1e7fd9"

#: How much of the colour there is where quads shall be twice as fine, and at most.
SHARE, MOST_SHARE = 0.45, 0.85


def tint(colours: NDArray[np.float32], value: NDArray[np.float64]) -> NDArray[np.float32]:
    """Tint colours (..., 3) by the density (...) there."""
    doublings = np.log2(value)
    share = np.minimum(SHARE * np.abs(doublings), MOST_SHARE)[..., None]
    warm = (doublings > 0.0)[..., None]
    paint = np.where(warm, style.parse_colour(FINER), style.parse_colour(COARSER))
    # As bright as what is painted: its shape stays to be seen.
    bright = colours.mean(axis=-1, keepdims=True) / paint.mean(axis=-1, keepdims=True)
    return np.clip(colours + share * (paint * bright - colours), 0.0, 1.0).astype(np.float32)


class KeptDensity:
    """The density at points, measured once for each density and each array of points."""

    def __init__(self) -> None:
        self._density: Density = EVEN
        self._points: Points | None = None
        self._value = np.zeros(0)

    def at(self, density: Density, points: Points, normals: Points) -> NDArray[np.float64]:
        """(...) the density at points (..., 3) with normals (..., 3)."""
        if self._points is not points or self._density != density:
            self._density, self._points = density, points
            found = density.at(points.reshape(-1, 3), normals.reshape(-1, 3))
            self._value = found.reshape(points.shape[:-1])
        return self._value
