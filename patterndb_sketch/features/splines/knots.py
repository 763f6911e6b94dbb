"""Parameters of samples along a curve, knots that follow them, and whether samples determine a
spline; of curves with ends, and of closed ones, whose knots are those of one period.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines.spline import LEAST_CLOSED, unroll_knots

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


def as_parameters(parameters: ArrayLike, n: int, *, closed: bool = False) -> NDArray[np.float64]:
    """(n,) parameters, checked: they ascend from 0 to 1, equal neighbours allowed.

    closed: those of a closed curve ascend within a period of 1.
    """
    result = np.array(parameters, np.float64)
    if result.shape != (n,):
        raise InvalidFeatureError(
            f"the parameters have the shape {result.shape}; give one for each of the {n} samples"
        )
    if closed:
        if not np.isfinite(result).all() or (np.diff(result) < 0.0).any() or np.ptp(result) > 1.0:
            raise InvalidFeatureError(
                "the parameters of a closed curve must ascend, the last by at most 1 above the "
                "first; sort the samples along the curve"
            )
        return result
    if not (np.isfinite(result).all() and result[0] == 0.0 and result[-1] == 1.0):
        raise InvalidFeatureError("the parameters of a curve must run from exactly 0 to exactly 1")
    falling = np.flatnonzero(np.diff(result) < 0.0)
    if len(falling):
        raise InvalidFeatureError(
            f"parameter {falling[0] + 1} is below the one before; sort the samples along the curve"
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
        at = np.r_[_spread_sites(fixed.tolist(), step), last]
    sites = np.interp(at, np.arange(last + 1), places)
    sums = np.convolve(sites[1:-1], np.ones(degree), "valid") if len(at) > degree + 1 else []
    inner = np.asarray(sums, np.float64) / degree
    return np.r_[np.zeros(degree + 1), inner, np.ones(degree + 1)]


def _spread_sites(fixed: Sequence[int], step: float) -> Floats:
    """(s,) sites at fixed numbers and, evenly, between them, ``step`` apart or less; the last of
    the fixed ones is left out."""
    gaps = [
        np.linspace(a, b, min(math.ceil((b - a) / step), b - a), endpoint=False)
        for a, b in pairwise(fixed)
    ]
    return np.concatenate(gaps)


def chordal_period(samples: Points) -> Floats:
    """(m,) parameters from 0 to below 1 in proportion to the length of the polygon (m, 3).

    Raises InvalidFeatureError if all samples are at one place.
    """
    return chordal_parameters(np.concatenate([samples, samples[:1]]))[:-1]


def average_period(
    places: Floats, degree: int, n_control: int, held: NDArray[np.int64] | None = None
) -> Floats:
    """(n + 1,) the knots of one period, as dense as distinct parameters (d,), from 0 to below 1.

    n is n_control, or somewhat more where places are held: numbers (q,), ascending, of those that
    the spline must be able to interpolate at. The rule is that of :func:`average_knots`, all the
    way round: knot i is the mean of the ``degree`` sites before site i, so that basis function i is
    not 0 there.
    """
    count = len(places)
    if held is None or not len(held):
        at = np.arange(n_control) * (count / n_control)
    else:
        at = _spread_sites([*held.tolist(), int(held[0]) + count], count / n_control)
        n_control = len(at)
    around = np.r_[places, places + 1.0, places[0] + 2.0]
    sites = np.interp(at, np.arange(len(around)), around)
    before = np.arange(n_control)[:, None] + np.arange(-degree, 0)
    turns, number = np.divmod(before, n_control)
    knots = (sites[number] + turns).mean(axis=1)
    return np.r_[knots, knots[0] + 1.0]


def count_interpolated(parameters: Floats, knots: Floats, degree: int) -> int:
    """How many parameters (q,) can have control points of their own, whose basis functions are
    not 0 there: as many as there are, and values there can be interpolated (Schoenberg and
    Whitney's condition, by a greatest matching)."""
    if not len(parameters):
        return 0
    rows = evaluate_period(parameters, knots, degree)
    rows.data = (rows.data > 0.0).astype(np.float64)
    rows.eliminate_zeros()
    matched = np.asarray(maximum_bipartite_matching(rows, perm_type="column"))
    return int((matched >= 0).sum())


def evaluate_period(parameters: Floats, knots: Floats, degree: int) -> csr_array:
    """(m, n) the basis functions of a closed spline at parameters (m,)."""
    n = len(knots) - 1
    low, period = knots[0], knots[-1] - knots[0]
    at = low + np.mod(parameters - low, period)
    matrix = BSpline.design_matrix(at, unroll_knots(knots, degree), degree)
    wrapped = csr_array((matrix.data, matrix.indices % n, matrix.indptr), (len(at), n))
    wrapped.sum_duplicates()
    return wrapped


def least_control(degree: int) -> int:
    """The fewest control points of a closed spline that is fitted."""
    return max(degree + 1, LEAST_CLOSED)
