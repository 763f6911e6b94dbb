"""Parameters of samples along a curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.features.errors import InvalidFeatureError

#: Parameters this close are one: samples projected to one edge differ by rounding alone.
SAME = 1e-12


def chordal(samples: Points) -> NDArray[np.float64]:
    """(m,) parameters from 0 to 1 in proportion to the length of the polyline (m, 3).

    Samples that coincide have the same parameter. Raises InvalidFeatureError if all do.
    """
    along = arc_length(samples)
    steps = np.diff(along)
    steps[steps <= SAME * np.ptp(samples, axis=0).max()] = 0.0
    along[1:] = np.cumsum(steps)
    if not along[-1] > 0.0:
        raise InvalidFeatureError(
            f"the {len(samples)} samples of a curve are all at one place; give at least two places"
        )
    return np.minimum(along / along[-1], 1.0)


def distinct(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
    """(d,) the ascending parameters (m,) that differ, the first and the last as they are."""
    kept = parameters[np.r_[True, np.diff(parameters) > SAME]].copy()
    kept[-1] = parameters[-1]
    return kept


def as_parameters(parameters: ArrayLike, n: int) -> NDArray[np.float64]:
    """(n,) parameters, checked: they ascend from 0 to 1, equal neighbours allowed."""
    result = np.array(parameters, np.float64)
    if result.shape != (n,):
        raise InvalidFeatureError(
            f"the parameters have the shape {result.shape}; give one for each of the {n} samples"
        )
    if not (np.isfinite(result).all() and result[0] == 0.0 and result[-1] == 1.0):
        raise InvalidFeatureError("the parameters of a curve must run from exactly 0 to exactly 1")
    falling = np.flatnonzero(np.diff(result) < 0.0)
    if len(falling):
        raise InvalidFeatureError(
            f"parameter {falling[0] + 1} is below the one before; sort the samples along the curve"
        )
    return result
