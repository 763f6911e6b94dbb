"""min |N C - A|^2 subject to M C = B, N and M being rows of a B-spline basis.

The rows have degree + 1 entries next to each other, so the normal matrix is banded: no product
of full matrices, which would also wake up the threads of a numerical library for nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.linalg import lapack, pinvh

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel

#: The libraries' routines are known at run time only.
_lapack: Any = lapack

#: A squared pivot below this share of the largest: the matrix is taken as rank-deficient.
SINGULAR = 1e-12

#: Eigenvalues below this share of the largest count as 0 where a matrix is rank-deficient.
CUTOFF = 1e-13


def basis_rows(parameters: Floats, knots: Floats, degree: int) -> tuple[Floats, Int32Array]:
    """((m, degree + 1) basis functions not 0 at parameters (m,), (m,) the number of the first)."""
    matrix = BSpline.design_matrix(parameters, knots, degree)
    width = degree + 1
    values = np.asarray(matrix.data, np.float64).reshape(-1, width)
    return values, matrix.indices[::width].astype(np.int32)


def constrained_least_squares(
    values: Floats, first: Int32Array, n: int, wanted: Points, held: NDArray[np.int64]
) -> Points:
    """(n, 3) the control points C with the least |N C - A|^2 that meet the held rows exactly.

    values, first: rows of N as of :func:`basis_rows`; wanted: (m, 3) A; held: (q,) the numbers
    of the rows that are constraints: M and B are those rows of N and A.

    With multipliers L: N'N C + M'L = N'A and M C = B. C is taken out of the second by the
    first. Refined once: the residual is taken from A, not from N'N, which has half the digits.
    Where a matrix is rank-deficient, least squares and the smallest solution of the whole.
    """
    bands = _normal_bands(values, first, n)
    exact = np.zeros((len(held), n))
    for k in range(values.shape[1]):
        exact[np.arange(len(held)), first[held] + k] = values[held, k]
    factor, failed = _lapack.dpbtrf(bands, lower=1)
    pivots = factor[0]
    if failed or pivots.min() ** 2 < SINGULAR * pivots.max() ** 2:
        return _deficient(values, first, exact, bands, wanted, held)
    lifted = _lapack.dpbtrs(factor, exact.T, lower=1)[0] if len(held) else exact.T
    schur, failed = _lapack.dpotrf(exact @ lifted, lower=1) if len(held) else (None, 0)
    if schur is not None:
        pivots = np.diag(schur)
        if failed or pivots.min() ** 2 < SINGULAR * pivots.max() ** 2:
            return _deficient(values, first, exact, bands, wanted, held)
    control = np.zeros((n, wanted.shape[1]))
    multipliers = np.zeros((len(held), wanted.shape[1]))
    for _ in range(2):
        off = wanted - _times(values, first, control)
        right = _transposed(values, first, n, off) - exact.T @ multipliers
        free = _lapack.dpbtrs(factor, right, lower=1)[0]
        if schur is not None:
            more = _lapack.dpotrs(schur, exact @ free - off[held], lower=1)[0]
            multipliers += more
            free -= lifted @ more
        control += free
    return control


def distances(values: Floats, first: Int32Array, control: Points, wanted: Points) -> Floats:
    """(m,) of the points that the rows give from wanted (m, 3)."""
    return np.linalg.norm(_times(values, first, control) - wanted, axis=1)


def _deficient(
    values: Floats,
    first: Int32Array,
    exact: Floats,
    bands: Floats,
    wanted: Points,
    held: NDArray[np.int64],
) -> Points:
    """The same by the full matrix of the system and its pseudo-inverse."""
    q, n = exact.shape
    system = np.zeros((n + q, n + q))
    for k in range(len(bands)):
        at = np.arange(n - k)
        system[at + k, at] = system[at, at + k] = bands[k, : n - k]
    system[:n, n:] = exact.T
    system[n:, :n] = exact
    inverse = pinvh(system, rtol=CUTOFF)
    result = np.zeros((n + q, wanted.shape[1]))
    for _ in range(2):
        off = wanted - _times(values, first, result[:n])
        right = _transposed(values, first, n, off) - exact.T @ result[n:]
        result += inverse @ np.concatenate([right, off[held]])
    return result[:n]


@kernel
def _normal_bands(values: Floats, first: Int32Array, n: int) -> Floats:
    """(degree + 1, n) N'N: the diagonal, and the diagonals below it."""
    bands = np.zeros((values.shape[1], n))
    for i in range(len(values)):
        for a in range(values.shape[1]):
            for b in range(a, values.shape[1]):
                bands[b - a, first[i] + a] += values[i, a] * values[i, b]
    return bands


@kernel
def _times(values: Floats, first: Int32Array, control: Points) -> Points:
    """(m, c) N times (n, c)."""
    result = np.zeros((len(values), control.shape[1]))
    for i in range(len(values)):
        for k in range(values.shape[1]):
            for c in range(control.shape[1]):
                result[i, c] += values[i, k] * control[first[i] + k, c]
    return result


@kernel
def _transposed(values: Floats, first: Int32Array, n: int, points: Points) -> Points:
    """(n, c) the transpose of N times (m, c)."""
    result = np.zeros((n, points.shape[1]))
    for i in range(len(values)):
        for k in range(values.shape[1]):
            for c in range(points.shape[1]):
                result[first[i] + k, c] += values[i, k] * points[i, c]
    return result
