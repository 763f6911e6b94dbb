"""Widths that make a pattern meet given side lengths: the compiled core's answer.

:mod:`query.solving.cpsat` answers the same calls with a general solver, as a second opinion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from patterndb._native.query.solving.evenness import list_splits
from patterndb._native.query.solving.matching import search_matchings
from patterndb._native.query.solving.strokes import can_carry, find_carrying_widths
from patterndb.core.halfedge import Int32Array
from query.errors import InvalidQueryError
from query.solving.strokes import FLOW_COLUMNS
from query.solving.systems import Chords


@dataclass(frozen=True, slots=True)
class OrientedStrokes:
    """Strokes as a pattern sees them, see :func:`query.solving.strokes.orient_strokes`.

    rows:      (s, 4) int32 side, edge, side, edge.
    tolerance: K >= 0, edges that a strand's end may be off.
    """

    rows: Int32Array
    tolerance: int


#: Counting stops here, far above what a caller asks for, as in rust/query/src/solving/matching.rs.
MANY = 1 << 30

#: No strokes.
NO_FLOWS = OrientedStrokes(np.zeros((0, FLOW_COLUMNS), np.int32), 0)


@dataclass(frozen=True, slots=True)
class Solutions:
    """The best solutions of one system.

    widths:    (k, n) int32 widths >= 1 of the open polychords in label order, best first:
               fewest edges off the strokes, then smallest sum of squares, then
               lexicographically.
    truncated: are there more than these?
    """

    widths: Int32Array
    truncated: bool


class Solver(Protocol):
    """What a solver answers: :func:`find_solutions`, here and in :mod:`query.solving.cpsat`."""

    def __call__(
        self,
        chords: Chords,
        lengths: ArrayLike,
        limit: int | None,
        flows: OrientedStrokes = NO_FLOWS,
    ) -> Solutions: ...


def find_solutions(
    chords: Chords, lengths: ArrayLike, limit: int | None = None, flows: OrientedStrokes = NO_FLOWS
) -> Solutions:
    """The ``limit`` best solutions (None: all) of one pattern in one orientation.

    lengths: (n_sides,) edges asked for, in the pattern's order of sides. Where there is no
    solution the list is empty. Long sides with limit=None mean a list as long as there are
    solutions, often millions. Raises InvalidQueryError for a limit below 1.
    """
    if limit is not None and limit < 1:
        raise InvalidQueryError(f"limit is {limit}; ask for at least 1, or None for all")
    wanted = np.asarray(lengths, np.int32)
    if limit is None and not len(flows.rows):
        slack = wanted - chords.base_lengths()
        if (slack < 0).any():
            return Solutions(np.zeros((0, chords.n), np.int32), False)
        rows, _ = find_class_slacks(chords, slack, None)
        return Solutions(_in_order(list_splits(rows, chords.class_n, chords.class_of)), False)
    keep = 1024 if limit is None else limit + 1
    while True:
        widths = find_best_widths(chords, wanted, flows, keep)
        if limit is not None:
            return Solutions(widths[:limit], len(widths) > limit)
        if len(widths) < keep:
            return Solutions(widths, False)
        keep *= 4


def find_best_widths(
    chords: Chords, lengths: Int32Array, flows: OrientedStrokes, keep: int
) -> Int32Array:
    """(k <= keep, n) int32 widths of the best solutions, best first; all if fewer than keep."""
    return find_carrying_widths(
        chords.edges, chords.side_start, lengths, flows.rows, flows.tolerance, keep
    )


def is_feasible(chords: Chords, lengths: ArrayLike, flows: OrientedStrokes = NO_FLOWS) -> bool:
    """Is there any solution? Arguments as in :func:`find_solutions`."""
    wanted = np.asarray(lengths, np.int32)
    return can_carry(chords.edges, chords.side_start, wanted, flows.rows, flows.tolerance)


def find_class_slacks(
    chords: Chords, slack: Int32Array, limit: int | None
) -> tuple[Int32Array, int]:
    """Slack of every class, for every solution, and how many widths these stand for.

    Returns ((r, m) int32, number of solutions); the rows are whole only while the number
    is at most ``limit`` (None: always).
    """
    most = MANY if limit is None else limit
    return search_matchings(slack, chords.class_i, chords.class_j, chords.class_n, most)


def _in_order(widths: Int32Array) -> Int32Array:
    """The rows, best first."""
    key = (widths.astype(np.int64) ** 2).sum(axis=1)
    return widths[np.lexsort((*widths.T[::-1], key))]
