"""Least squares by closed splines: those of a period, without a beginning.

The same as :mod:`patterndb_sketch.features.splines.fit` does for curves with ends; rows of the
basis go round, so that the normal matrix is no band.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.linalg import lapack, pinvh
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.splines.knots import chordal_parameters
from patterndb_sketch.features.splines.spline import LEAST_CLOSED, unroll_knots

#: The libraries' routines are known at run time only.
_lapack: Any = lapack

#: A squared pivot below this share of the largest: the matrix is taken as rank-deficient.
SINGULAR = 1e-12

#: Eigenvalues below this share of the largest count as 0 where a matrix is rank-deficient.
CUTOFF = 1e-13


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
    the spline shall be able to interpolate at. The rule is that of
    :func:`patterndb_sketch.features.splines.knots.average_knots`, all the way round: knot i is
    the mean of the ``degree`` sites before site i, so that basis function i is not 0 there.
    """
    count = len(places)
    if held is None or not len(held):
        at = np.arange(n_control) * (count / n_control)
    else:
        step = count / n_control
        gaps = [
            np.linspace(a, b, min(math.ceil((b - a) / step), b - a), endpoint=False)
            for a, b in pairwise([*held.tolist(), int(held[0]) + count])
        ]
        at = np.concatenate(gaps)
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


def solve_period(rows: csr_array, n: int, wanted: Points, held: NDArray[np.int64]) -> Points:
    """(n, 3) the control points C with the least |N C - A|^2 that meet the held rows exactly.

    rows: (m, n) N. wanted: (m, 3) A. held: (q,) numbers of rows. As
    :func:`patterndb_sketch.features.splines.fit.solve_constrained`.
    """
    normal = np.asarray((rows.T @ rows).todense())
    exact = np.asarray(rows[held].todense()) if len(held) else np.zeros((0, n))
    factor, failed = _lapack.dpotrf(normal, lower=1)
    if failed or _is_singular(factor):
        return _deficient(rows, normal, exact, wanted, held)
    lifted = _lapack.dpotrs(factor, exact.T, lower=1)[0] if len(held) else exact.T
    schur, failed = _lapack.dpotrf(exact @ lifted, lower=1) if len(held) else (None, 0)
    if schur is not None and (failed or _is_singular(schur)):
        return _deficient(rows, normal, exact, wanted, held)
    control = np.zeros((n, wanted.shape[1]))
    multipliers = np.zeros((len(held), wanted.shape[1]))
    for _ in range(2):
        off = wanted - rows @ control
        free = _lapack.dpotrs(factor, rows.T @ off - exact.T @ multipliers, lower=1)[0]
        if schur is not None:
            more = _lapack.dpotrs(schur, exact @ free - off[held], lower=1)[0]
            multipliers += more
            free -= lifted @ more
        control += free
    return control


def least_control(degree: int) -> int:
    """The fewest control points of a closed spline that is fitted."""
    return max(degree + 1, LEAST_CLOSED)


def _is_singular(factor: Floats) -> bool:
    pivots = np.diag(factor)
    return bool(pivots.min() ** 2 < SINGULAR * pivots.max() ** 2)


def _deficient(
    rows: csr_array, normal: Floats, exact: Floats, wanted: Points, held: NDArray[np.int64]
) -> Points:
    """The same by the full matrix of the system and its pseudo-inverse."""
    q, n = exact.shape
    inverse = pinvh(np.block([[normal, exact.T], [exact, np.zeros((q, q))]]), rtol=CUTOFF)
    result = np.zeros((n + q, wanted.shape[1]))
    for _ in range(2):
        off = wanted - rows @ result[:n]
        right = rows.T @ off - exact.T @ result[n:]
        result += inverse @ np.concatenate([right, off[held]])
    return result[:n]
