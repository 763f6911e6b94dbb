"""Where a thing is looked at from at first."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from viewer.view import View

#: Part of the picture's width and height that a thing is fitted into.
FILLED = 0.86


def framed(points: Points, toward: ArrayLike, up: ArrayLike, width: float, height: float) -> View:
    """Looking against ``toward`` (3,), ``up`` (3,) upright, with points (n, 3) in the middle of
    a picture of this size, in points."""
    z = np.asarray(toward, np.float64)
    z = z / np.linalg.norm(z)
    x = np.cross(np.asarray(up, np.float64), z)
    size = float(np.linalg.norm(x))
    # Looking along the upright direction, any other will do.
    x = x / size if size > 1e-9 else np.linalg.svd(z[None])[2][1]
    axes = np.stack([x, np.cross(z, x), z])
    if not len(points):
        return View(axes, np.zeros(3), 100.0)
    flat = points @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    across = np.maximum(high - low, 1e-300)
    scale = FILLED * min(width / across[0], height / across[1])
    if scale > 1e200:
        scale = 1.0
    return View(axes, axes.T @ ((low + high) / 2.0), float(scale))
