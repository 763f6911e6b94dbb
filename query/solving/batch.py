"""Many patterns at once: which of them the strokes leave, and the best widths of each.

A boundary and strokes become a :class:`Question` in the patterns' own terms: lengths, weights and
strokes, once per orientation. The compiled core runs over rows of a table, whose boundary labels
lie one after the other in one array; each thread takes its share of the rows. What a row's answer
is does not depend on the others, nor on the number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.solving.batch import keep_carrying
from patterndb._native.query.solving.batch import solve_rows as _solve_rows
from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary
from query.orientation import list_orientations, list_sides_seen
from query.solving.strokes import orient_strokes
from query.solving.systems import Int16Array
from query.stroke import Stroke

#: What an edge off a stroke's end counts: more than any sum of squares. Perimeters are at most
#: 2,000, so the squares add up to at most 1,000**2, each times a weight of at most MAX_WEIGHT.
OFF = 1 << 28

#: The weight of a square stays within 1..MAX_WEIGHT.
MAX_WEIGHT = 255

#: The weight of a square where all edges are equally long: fine enough to tell proportions.
EVEN_WEIGHT = 16


def pose_question(boundary: Boundary, strokes: Sequence[Stroke], tolerance: int) -> Question:
    """The boundary and the strokes in every orientation; see :mod:`query.orientation`."""
    n = max(boundary.n_sides, 1)
    sides = list_sides_seen(n)
    lengths = np.array(boundary.lengths, np.int32)
    weights = weigh_sides(boundary)
    return Question(
        lengths=np.ascontiguousarray(lengths[sides]),
        weights=np.ascontiguousarray(weights[sides[:, :, None], sides[:, None, :]]),
        flows=np.stack([orient_strokes(strokes, boundary, o) for o in list_orientations(n)]),
        # An end that may be off by a whole side may be anywhere.
        tolerance=min(tolerance, max(boundary.lengths)),
    )


def weigh_sides(boundary: Boundary) -> Int32Array:
    """(n, n) int32: what the square of a width counts for strands between two sides.

    1 where the boundary has no points. Else in proportion to the sum of the squares of the
    sides' edge lengths: then the most even widths are those that take equal lengths of the
    boundary, not equal numbers of edges.
    """
    n = len(boundary.lengths)
    if boundary.points is None:
        return np.ones((n, n), np.int32)
    steps = np.linalg.norm(np.roll(boundary.points, -1, axis=0) - boundary.points, axis=1)
    starts = np.array(boundary.side_starts)
    squares = (np.add.reduceat(steps, starts[:-1]) / np.diff(starts)) ** 2
    sums = squares[:, None] + squares[None, :]
    weights = np.rint(EVEN_WEIGHT * sums / (2 * squares.mean()))
    return np.clip(weights, 1, MAX_WEIGHT).astype(np.int32)


def share_out(
    run: Callable[[int], None],
    tasks: range,
    threads: int | None,
    *,
    lengthy: NDArray[np.uint8] | None = None,
) -> None:
    """Call ``run`` for every task, on at most so many threads (None: one a processor).

    Each thread takes the next task when it is done with the last: tasks differ much in their
    work. The calling thread takes part, unless a task may be ``lengthy``: then this is the flag by
    which tasks are cancelled, and the calling thread waits, so that Ctrl-C reaches it.
    """
    ahead = iter(tasks)

    def work() -> None:
        for task in ahead:
            run(task)

    most = min(threads or os.cpu_count() or 1, len(tasks))
    if lengthy is not None and most:
        helpers = [_pool(most).submit(work) for _ in range(most)]
        try:
            for helper in helpers:
                helper.result()
        except BaseException:
            lengthy[0] = 1
            wait(helpers)
            raise
        return
    others = most - 1
    if others <= 0:
        return work()
    helpers = [_pool(others).submit(work) for _ in range(others)]
    work()
    for helper in helpers:
        helper.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that stay: starting one takes longer than many a query."""
    return ThreadPoolExecutor(threads, thread_name_prefix="patterndb-query")


#: Rows that a thread takes at a time: some milliseconds of work, for which handing it over is
#: worth while.
ROWS_PER_THREAD = 64


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """The boundary labels of many patterns, as a query solves them.

    n_sides: at least 1.
    words:   int16, for every row its label as a word: for every side its length, then the
             strand that crosses each edge (:mod:`patterndb.core.label`).
    start:   (r + 1,) int64, where each word begins.
    """

    n_sides: int
    words: Int16Array
    start: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A boundary and strokes, once for every orientation.

    lengths: (o, n) int32 edges of every side in the pattern's order.
    weights: (o, n, n) int32, what the square of a width counts between two sides.
    flows:   (o, s, 4) int32, see :func:`query.solving.strokes.orient_strokes`.
    tolerance: edges that a strand's end may be off.
    """

    lengths: Int32Array
    weights: Int32Array
    flows: Int32Array
    tolerance: int


@dataclass(frozen=True, slots=True, eq=False)
class BestFits:
    """The best fits of some rows, best first: at most ``keep`` of each.

    row:    (f,) int64, index into the rows asked for, ascending.
    key:    (f,) int64, of the widths.
    orientation: (f,) int32.
    widths: (f, w) int32, of the strands in label order, 0 beyond the last.
    """

    row: NDArray[np.int64]
    key: NDArray[np.int64]
    orientation: Int32Array
    widths: Int32Array


def keep_carriers(
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    question: Question,
    cancelled: NDArray[np.uint8],
    threads: int | None = None,
    *,
    once: bool = False,
) -> NDArray[np.bool_]:
    """(r, o) bool: those of the allowed orientations in which strands can lie on all strokes.

    rows: (r,) rows of the labels; allowed: (r, o). once: at most one of each row, for those who
    only ask whether there is any. Cancelled, the answer is of no use.
    """
    result = allowed.copy()

    def run(first: int) -> None:
        some = slice(first, first + ROWS_PER_THREAD)
        keep_carrying(
            labels.words,
            labels.start,
            rows[some],
            result[some],
            question.lengths,
            question.weights,
            question.flows,
            question.tolerance,
            cancelled,
            once,
        )

    lengthy = cancelled if question.flows.shape[1] else None
    share_out(run, range(0, len(rows), ROWS_PER_THREAD), threads, lengthy=lengthy)
    return result


def solve_rows(
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    question: Question,
    keep: int,
    cancelled: NDArray[np.uint8],
    threads: int | None = None,
) -> BestFits:
    """The ``keep`` best fits of each row over the allowed orientations.

    Arguments as in :func:`keep_carriers`. Cancelled, rows are missing.
    """
    longest = _most_strands(labels.start, rows, labels.n_sides)
    count = np.zeros(len(rows), np.int64)
    key = np.empty((len(rows), keep), np.int64)
    best = np.zeros((len(rows), keep, longest + 1), np.int32)

    def run(first: int) -> None:
        some = slice(first, first + ROWS_PER_THREAD)
        _solve_rows(
            labels.words,
            labels.start,
            rows[some],
            allowed[some],
            question.lengths,
            question.weights,
            question.flows,
            question.tolerance,
            count[some],
            key[some],
            best[some],
            cancelled,
        )

    lengthy = cancelled if question.flows.shape[1] else None
    share_out(run, range(0, len(rows), ROWS_PER_THREAD), threads, lengthy=lengthy)
    at = np.arange(keep) < count[:, None]
    return BestFits(
        row=np.repeat(np.arange(len(rows)), count),
        key=key[at],
        orientation=best[at][:, longest],
        widths=best[at][:, :longest],
    )


def _most_strands(start: NDArray[np.int64], rows: NDArray[np.int64], n_sides: int) -> int:
    """Strands of the longest label."""
    return (int((start[rows + 1] - start[rows]).max(initial=n_sides)) - n_sides) // 2
