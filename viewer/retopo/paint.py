"""Density as colours while it is painted: finer is warm, coarser is cold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.ground import Ground
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


class GroundPaint:
    """The density at the vertices of a ground; measured once for each."""

    def __init__(self) -> None:
        self._density: Density = EVEN
        self._value: NDArray[np.float64] | None = None

    def at_vertices(self, ground: Ground, density: Density) -> NDArray[np.float64]:
        """(v,) of one ground, always the same."""
        if self._value is None or self._density != density:
            self._density, self._value = density, density.at(ground.vertices, ground.normals)
        return self._value


def measure_corners(density: Density, corners: Points, normals: Points) -> NDArray[np.float64]:
    """(t, 3) the density at corners (t, 3, 3) of triangles with normals (t, 3, 3)."""
    return density.at(corners.reshape(-1, 3), normals.reshape(-1, 3)).reshape(corners.shape[:2])
