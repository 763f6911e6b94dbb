"""The solver of width problems: which rows of a table of patterns fit, and which widths are best.

The compiled core tests lengths (:mod:`query.solving.feasibility`), then strokes, and finds the best
widths by branch and bound (rust/query/src/solving); CP-SAT is a second solver of the same
(:mod:`query.solving.cpsat`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.solving.widths import filter_stroke_feasible, find_best_widths
from query.cancellation import CancelFlag, share_out
from query.solving.cpsat import filter_feasible, list_best
from query.solving.feasibility import LengthTest
from query.solving.problem import BestWidths, Labels, WidthProblem
from query.solving.systems import SignatureRows

#: Rows that a thread takes at a time: some milliseconds of work, for which handing it over is
#: worth while.
ROWS_PER_THREAD = 64


class WidthTable(Protocol):
    """Rows of patterns whose widths can be solved for.

    labels:     of the rows.
    signatures: the same rows by the sides that their polychords join.
    """

    @property
    def labels(self) -> Labels: ...
    @property
    def signatures(self) -> SignatureRows: ...


class WidthSolver:
    """Solves a width problem for rows of tables of patterns.

    What a row's answer is depends neither on other rows nor on the number of threads. Once
    ``cancelled`` is set, rows may be missing from an answer, or count as unfit; with CP-SAT,
    QueryCancelledError is raised.

    cancelled: the flag that another thread may set; None where nobody cancels.
    threads:   at most so many; None is one a processor.
    by_cpsat:  solve with OR-Tools CP-SAT instead: the same answers, slowly.
    """

    def __init__(
        self,
        problem: WidthProblem,
        *,
        cancelled: CancelFlag | None = None,
        threads: int | None = None,
        by_cpsat: bool = False,
    ) -> None:
        self.problem = problem
        self.cancelled = np.zeros(1, np.uint8) if cancelled is None else cancelled
        self.threads = threads
        self.by_cpsat = by_cpsat
        self._by_lengths = LengthTest(problem.lengths, self.cancelled, threads)

    def find_feasible(
        self,
        table: WidthTable,
        rows: NDArray[np.int64],
        allowed: NDArray[np.uint8],
        *,
        once: bool = False,
    ) -> NDArray[np.bool_]:
        """(r, o) bool: the allowed orientations in which a row has widths.

        rows: (r,) of the table. allowed: (r, ceil(o / 8)) uint8, the allowed orientations in
        the order of :func:`query.orientation.list_orientations`, as np.packbits packs them.
        once: where strokes decide, stop at the first orientation of each row.
        """
        if self.by_cpsat:
            unpacked = _unpack(allowed, len(self.problem.lengths))
            return filter_feasible(
                self.problem, table.labels, rows, unpacked, self.cancelled, self.threads
            )
        found = self._by_lengths.find(table.signatures, rows, allowed)
        if self.problem.has_strokes:
            some = np.flatnonzero(found.any(axis=1))
            found[some] = self._filter_by_strokes(table.labels, rows[some], found[some], once)
        return found

    def is_feasible(
        self, table: WidthTable, rows: NDArray[np.int64], allowed: NDArray[np.uint8]
    ) -> NDArray[np.bool_]:
        """(r,) bool: has a row widths in any allowed orientation? As :meth:`find_feasible`."""
        if self.by_cpsat or self.problem.has_strokes:
            return np.any(self.find_feasible(table, rows, allowed, once=True), axis=1)
        return self._by_lengths.find(table.signatures, rows, allowed, once=True)[:, 0]

    def find_best(
        self,
        labels: Labels,
        rows: NDArray[np.int64],
        allowed: NDArray[np.bool_],
        keep: int,
    ) -> BestWidths:
        """The ``keep`` best widths of each row over its allowed orientations.

        allowed: (r, o) bool, such as :meth:`find_feasible` returns. Fewest edges off the strokes
        come first, then the most even widths: the least weighted sum of squares, and among
        equals the lexicographically least.
        """
        if self.by_cpsat:
            return list_best(self.problem, labels, rows, allowed, keep, self.cancelled)
        longest = _count_strands(labels, rows)
        count = np.zeros(len(rows), np.int64)
        key = np.empty((len(rows), keep), np.int64)
        best = np.zeros((len(rows), keep, longest + 1), np.int32)

        def run(first: int) -> None:
            some = slice(first, first + ROWS_PER_THREAD)
            fits = count[some], key[some], best[some]
            find_best_widths(labels, rows[some], allowed[some], self.problem, fits, self.cancelled)

        self._share_rows(run, len(rows))
        at = np.arange(keep) < count[:, None]
        return BestWidths(
            row=np.repeat(np.arange(len(rows)), count),
            key=key[at],
            orientation=best[at][:, longest],
            widths=best[at][:, :longest],
        )

    def _filter_by_strokes(
        self, labels: Labels, rows: NDArray[np.int64], allowed: NDArray[np.bool_], once: bool
    ) -> NDArray[np.bool_]:
        """(r, o) bool: the allowed orientations in which strands can lie on all strokes."""
        result = allowed.copy()

        def run(first: int) -> None:
            some = slice(first, first + ROWS_PER_THREAD)
            filter_stroke_feasible(
                labels, rows[some], result[some], self.problem, once, self.cancelled
            )

        self._share_rows(run, len(rows))
        return result

    def _share_rows(self, run: Callable[[int], None], n_rows: int) -> None:
        lengthy = self.cancelled if self.problem.has_strokes else None
        share_out(run, range(0, n_rows, ROWS_PER_THREAD), self.threads, lengthy=lengthy)


def _unpack(packed: NDArray[np.uint8], n: int) -> NDArray[np.bool_]:
    return np.unpackbits(packed, axis=1, count=n).view(np.bool_)


def _count_strands(labels: Labels, rows: NDArray[np.int64]) -> int:
    """Strands of the longest label of some rows."""
    sizes = labels.start[rows + 1] - labels.start[rows]
    return (int(sizes.max(initial=labels.n_sides)) - labels.n_sides) // 2
