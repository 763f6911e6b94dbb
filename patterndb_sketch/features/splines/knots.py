"""Parameters of samples along a curve, knots that follow them, and whether samples determine a
spline.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.features.errors import InvalidFeatureError

#: Parameters this close are one: samples projected to one edge differ by rounding alone.
SAME = 1e-12


def chordal_parameters(samples: Points) -> NDArray[np.float64]:
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


def find_distinct(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
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


def as_period(parameters: ArrayLike, n: int) -> NDArray[np.float64]:
    """(n,) parameters of a closed curve, checked: they ascend, all within a period of 1."""
    result = np.array(parameters, np.float64)
    if result.shape != (n,):
        raise InvalidFeatureError(
            f"the parameters have the shape {result.shape}; give one for each of the {n} samples"
        )
    if not np.isfinite(result).all() or (np.diff(result) < 0.0).any() or np.ptp(result) > 1.0:
        raise InvalidFeatureError(
            "the parameters of a closed curve must ascend, the last by at most 1 above the first; "
            "sort the samples along the curve"
        )
    return result


def average_knots(
    parameters: Floats, degree: int, n_control: int, held: Floats | None = None
) -> Floats:
    """(n + degree + 1,) knots on [0, 1], as dense as the parameters (m,).

    n is n_control, or somewhat more if some parameters are held (q,): the spline can then
    interpolate whatever values there, however close together they are. Wanted: degree <
    n_control <= how many distinct parameters there are; held: some of the parameters.

    Every inner knot is the mean of ``degree`` successive ones of n sites, which lie at steps of
    number among the distinct parameters, equal ones unless some are held: these are sites.

    The samples determine every control point (Schoenberg and Whitney): the numbers x_i of sites
    ascend by 1 or more, so sites i - 1 and i + 1 enclose parameter floor(x_i), and knots i and
    i + degree + 1 enclose the sites. A held parameter is site i itself.

    Source: Piegl and Tiller 1995, "The NURBS Book", equation 9.8 for as many control points as
    samples. Differs from the paper's reference for fewer (equation 9.69, a knot at every d-th
    parameter): averaged sites are one rule for all numbers, and the condition holds for any
    spacing of the samples.
    """
    places = find_distinct(parameters)
    last = len(places) - 1
    if held is None:
        at = np.linspace(0.0, last, n_control)
    else:
        step = last / (n_control - 1)
        numbers = np.searchsorted(places, held, "right") - 1
        fixed = np.unique(np.r_[0, numbers, last])
        gaps = [
            np.linspace(a, b, min(math.ceil((b - a) / step), b - a), endpoint=False)
            for a, b in pairwise(fixed.tolist())
        ]
        at = np.concatenate([*gaps, [last]])
    sites = np.interp(at, np.arange(last + 1), places)
    sums = np.convolve(sites[1:-1], np.ones(degree), "valid") if len(at) > degree + 1 else []
    inner = np.asarray(sums, np.float64) / degree
    return np.r_[np.zeros(degree + 1), inner, np.ones(degree + 1)]
