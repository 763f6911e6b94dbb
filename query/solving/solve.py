"""Widths that make a pattern meet given side lengths: the kernel's answer.

:mod:`query.solving.cpsat` answers the same calls with a general solver, as a second opinion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array
from query.ending import NEVER
from query.errors import InvalidQueryError
from query.solving.evenness import spread_slack
from query.solving.matching import search_matchings
from query.solving.strokes import FLOW_COLUMNS, carry_strokes, find_chord_ends
from query.solving.systems import Chords


@dataclass(frozen=True, slots=True)
class OrientedStrokes:
    """Strokes as a pattern sees them, see :func:`query.solving.strokes.orient_strokes`.

    rows:      (s, 4) int32 side, edge, side, edge.
    tolerance: K >= 0, edges that a strand's end may be off.
    """

    rows: Int32Array
    tolerance: int


#: No strokes.
NO_FLOWS = OrientedStrokes(np.zeros((0, FLOW_COLUMNS), np.int32), 0)


@dataclass(frozen=True, slots=True)
class Solutions:
    """The best solutions of one system.

    widths:    (k, n) int32 widths >= 1 of the open polychords in label order, best first:
               fewest edges off the strokes, then smallest sum of squares (see
               :mod:`query.solving.evenness`), then lexicographically.
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
        rows, total = find_class_slacks(chords, slack, None)
        return Solutions(_in_order(_split_all(chords, rows, total)), False)
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
    keys = np.empty(keep, np.int64)
    best = np.empty((keep, chords.n + 1), np.int32)
    order = np.empty(keep, np.int64)
    count = _carry(chords, lengths, flows, keys, best, order)
    return best[order[:count], :-1]


def is_feasible(chords: Chords, lengths: ArrayLike, flows: OrientedStrokes = NO_FLOWS) -> bool:
    """Is there any solution? Arguments as in :func:`find_solutions`."""
    none = np.zeros(0, np.int64)
    wanted = np.asarray(lengths, np.int32)
    return _carry(chords, wanted, flows, none, np.zeros((0, chords.n + 1), np.int32), none) > 0


def _carry(
    chords: Chords,
    lengths: Int32Array,
    flows: OrientedStrokes,
    keys: NDArray[np.int64],
    best: Int32Array,
    order: NDArray[np.int64],
) -> int:
    weight = np.ones((chords.n_sides, chords.n_sides), np.int32)
    end = np.empty((chords.n, 2), np.int32)
    find_chord_ends(chords.edges, end)
    return carry_strokes(
        chords.edges,
        end,
        chords.side_start,
        lengths,
        weight,
        flows.rows,
        flows.tolerance,
        0,
        keys,
        best,
        order,
        0,
        NEVER,
    )


def find_class_slacks(
    chords: Chords, slack: Int32Array, limit: int | None
) -> tuple[Int32Array, int]:
    """Slack of every class, for every solution, and how many widths these stand for.

    Returns ((r, m) int32, number of solutions); the rows are whole only while the number
    is at most ``limit`` (None: always).
    """
    m = len(chords.class_n)
    room = 1024 if limit is None else limit
    while True:
        rows = np.empty((room + 1, m), np.int32)
        found, total = search_matchings(
            slack.copy(),
            chords.class_i,
            chords.class_j,
            chords.class_n,
            m,
            room,
            rows,
            np.zeros(m, np.bool_),
            np.empty((5, chords.n_sides), np.int32),
            np.empty((3, m), np.int32),
        )
        if limit is not None or total <= room:
            return rows[:found], total
        room *= 4


def _split_all(chords: Chords, rows: Int32Array, total: int) -> Int32Array:
    """(total, n) int32 widths of all the solutions that the rows stand for."""
    widths = np.empty((total, chords.n), np.int32)
    # A key has no more than the square of the widths' sum.
    unbounded = int(chords.n + rows.sum(axis=1).max(initial=0)) ** 2
    ones = np.ones(len(chords.class_n), np.int32)
    at = 0
    for row in rows:
        room = widths[at:]
        at += spread_slack(
            row, chords.class_n, ones, chords.class_of, unbounded, False, room, len(room), NEVER
        )[0]
    return widths


def _in_order(widths: Int32Array) -> Int32Array:
    """The rows, best first."""
    key = (widths.astype(np.int64) ** 2).sum(axis=1)
    return widths[np.lexsort((*widths.T[::-1], key))]
