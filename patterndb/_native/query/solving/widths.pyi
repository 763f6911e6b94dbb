# Bound by rust/python/src/query/solving.rs.
import numpy as np
from numpy.typing import NDArray

from query.cancellation import CancelFlag
from query.solving.problem import Labels, WidthProblem

def filter_stroke_feasible(
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    problem: WidthProblem,
    once: bool,
    cancelled: CancelFlag,
) -> None:
    """Clear those of the allowed orientations (r, o) in which strands cannot lie on all strokes.

    once: keep at most one of each row.
    """

def find_best_widths(
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    problem: WidthProblem,
    fits: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int32]],
    cancelled: CancelFlag,
) -> None:
    """Do :meth:`query.solving.widths.WidthSolver.find_best` for some rows.

    fits: written; (r,) numbers of fits, (r, keep) keys, and (r, keep, longest + 1) widths with the
    orientation last.
    """
