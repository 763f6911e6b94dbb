"""Linear systems that place vertices, dense or sparse: square ones, and those of least squares."""

# scipy has no types: what it returns is typed by the functions' own annotations.
# pyright: reportMissingTypeStubs=false

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from patterndb.geometry.points import Floats, Points

#: The library's routines are known at run time only.
_lapack: Any = lapack

#: Unknowns up to which a dense solver is faster.
DENSE = 160


def solve_held(energy: Any, held: Points) -> Points:
    """Solve (n - h, d) values that make a quadratic energy least, given those before them.

    energy: (n, n) sparse and symmetric. held: (h, d) the first values.
    """
    h = len(held)
    return solve_square(energy[h:, h:], -(energy[h:, :h] @ held))


def join_entries(
    row: NDArray[np.int64], column: NDArray[np.int64], weight: Floats, shape: tuple[int, int]
) -> Any:
    """Join the entries of a matrix, those at one place added: dense up to DENSE columns."""
    if shape[1] > DENSE:
        return csr_array((weight, (row, column)), shape=shape)
    matrix = np.zeros(shape)
    np.add.at(matrix.reshape(-1), row * shape[1] + column, weight)
    return matrix


def solve_square(matrix: Any, right: Points) -> Points:
    """Solve (n, d) unknowns of a square system, dense or sparse, for a right side (n, d)."""
    if not isinstance(matrix, np.ndarray):
        return splu(csc_array(matrix)).solve(right)
    # LAPACK is SciPy's: NumPy's has other last digits.
    _, _, solved, singular = _lapack.dgesv(matrix, right)
    if singular:
        raise np.linalg.LinAlgError("Singular matrix")
    return solved


class LeastSquares:
    """A linear system with more rows than unknowns, dense or sparse, for several right sides.

    ridge: what is added to the normal equations' diagonal.
    """

    def __init__(self, rows: Any, ridge: float = 0.0) -> None:
        self.rows = rows
        self._normal: Any = rows.T @ rows
        self._factor: Any = None
        if isinstance(rows, np.ndarray):
            self._normal[np.diag_indices(len(self._normal))] += ridge
            return
        self._normal = self._normal.tocsc()
        if ridge:
            self._normal.setdiag(self._normal.diagonal() + ridge)
        self._factor = splu(self._normal)

    def solve(self, right: Points) -> Points:
        """Solve (n, d) unknowns for a right side (m, d)."""
        if self._factor is None:
            return solve_square(self._normal, self.rows.T @ right)
        return self._factor.solve(self.rows.T @ right)
