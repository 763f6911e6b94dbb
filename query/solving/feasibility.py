"""Which patterns of a class fit a boundary, and in which orientations.

Whether lengths can be met depends on a pattern's signature and on the orientation alone. Each is
one system. A sieve refuses most of them, all orientations of a signature together
(:mod:`query.solving.sieve`); parity may refuse others
(:func:`query.solving.systems.is_balanced`); a flow decides the rest
(rust/query/src/solving/matching.rs), and what one orientation fails by, others of the same
system often do. Marcias et al. 2015, section 4, solve one integer program a pattern.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.solving.feasibility import mark
from patterndb._native.query.solving.sieve import compare_pairs, state_claims
from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.core.patternclass import PatternClass
from query.boundary import Boundary
from query.orientation import list_corners_seen, list_sides_seen
from query.solving.batch import share_out
from query.solving.sieve import LANES, mark_lanes, pack_lengths
from query.solving.systems import SignedRows, systems_of

#: Patterns that a thread takes at a time: a millisecond of work or less, so that all
#: threads end together, and so much that handing it over costs nothing.
ROWS_PER_THREAD = 2048

#: The most times that patterns are handed over: of many a thread takes more.
MOST_SHARES = 64

#: Claims likewise.
CLAIMS_PER_THREAD = 4096


Flag = NDArray[np.uint8]


class FeasibilityQuery(NamedTuple):
    """What is asked of a class, for the compiled core.

    lengths: (n, w) int32, a *lane* for each different way in which a signature sees the boundary.
    compared: what they are to base lengths, of :func:`query.solving.sieve.compare_pairs`.
    marks:   (g,) the words of all lanes.
    stated:  (k, g) words, what the boundary has for every claim.
    kinds:   (n, N) int32 quads at the corners in each lane; corner s is where side s of the
             signature begins.
    lane:    (2 N,) int32 the lane of each orientation.
    perimeter: edges around the boundary.
    convex:  do corners not matter?
    """

    lengths: Int32Array
    compared: Int64Array
    marks: Int64Array
    stated: Int64Array
    kinds: Int32Array
    lane: Int32Array
    perimeter: int
    convex: bool


def _distinct(boundary: Boundary) -> tuple[Int32Array, Int32Array, Int32Array]:
    """The boundary as a signature sees it, once per orientation that looks different.

    Returns ((d, max(N, 1)) int32 lengths, (d, N) int32 quads at the corners, (2N,) int32 which
    of these rows each orientation is).
    """
    lengths = np.array(boundary.lengths, np.int32)[list_sides_seen(max(boundary.n_sides, 1))]
    counts = np.array(boundary.corner_counts, np.int32)[list_corners_seen(boundary.n_sides)]
    rows = np.concatenate([lengths, counts.reshape(len(lengths), boundary.n_sides)], axis=1)
    number: dict[bytes, int] = {}
    which = np.array([number.setdefault(row.tobytes(), len(number)) for row in rows], np.int32)
    rows = rows[np.unique(which, return_index=True)[1]]
    width = len(boundary.lengths)
    return (
        np.ascontiguousarray(rows[:, :width]),
        np.ascontiguousarray(rows[:, width:]),
        which,
    )


def find_feasible_rows(
    patterns: PatternClass,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
    cancel: Flag | None = None,
) -> NDArray[np.int64]:
    """Those of the rows, in order, whose pattern fits the boundary strictly.

    rows: (r,) int64 row numbers of the class; each must have as many reflex corners as the
    boundary. threads: at most so many (default: one a processor); the result does not
    depend on it. cancel: (1,) uint8; once another thread makes it other than 0, the call
    ends within a fraction of a millisecond, and rows not looked at count as unfit.
    """
    fits = np.zeros((len(rows), 1), np.bool_)
    corners = None if boundary.convex else patterns.corners[rows]
    _answer(patterns, boundary, rows, corners, False, threads, cancel, fits)
    return rows[fits[:, 0]]


def find_feasible_orientations(
    patterns: PatternClass,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
    cancel: Flag | None = None,
) -> NDArray[np.bool_]:
    """(r, o) bool: in which orientations the patterns in these rows fit strictly.

    o = 2 max(N, 1), in the order of :func:`query.orientation.list_orientations`; none is left
    out for a symmetry of the pattern. Where the boundary has reflex corners, those of the
    pattern must fall on them. Arguments as in :func:`find_feasible_rows`.
    """
    fits = np.zeros((len(rows), 2 * max(patterns.n_sides, 1)), np.bool_)
    corners = None if boundary.convex else patterns.corners[rows]
    _answer(patterns, boundary, rows, corners, True, threads, cancel, fits)
    return fits


def find_met_lengths(
    rows_of: SignedRows,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
    cancel: Flag | None = None,
) -> NDArray[np.bool_]:
    """As :func:`find_feasible_orientations`, of all that has signatures, whatever the corners."""
    fits = np.zeros((len(rows), 2 * rows_of.lengths.shape[1]), np.bool_)
    _answer(rows_of, boundary, rows, None, True, threads, cancel, fits)
    return fits


def _answer(
    patterns: SignedRows,
    boundary: Boundary,
    rows: NDArray[np.int64],
    corners: NDArray[np.uint8] | None,
    every: bool,
    threads: int | None,
    cancel: Flag | None,
    fits: NDArray[np.bool_],
) -> None:
    """Set ``fits``: (r, 2N), or with ``every`` False (r, 1), does any orientation fit?

    corners: (r, N) quads at the rows' corners, or None where they do not matter.
    """
    systems = systems_of(patterns)
    lengths, kinds, lane = _distinct(boundary)
    compared, marks = compare_pairs(pack_lengths(lengths)), mark_lanes(len(lengths))
    stated = np.zeros((len(systems.claimant), len(marks) * LANES), np.uint8)
    seen = np.ascontiguousarray(lengths.T)
    flag = np.zeros(1, np.uint8) if cancel is None else cancel
    claim, near_first, near = systems.graphs[3:]
    of_claims = seen, systems.claimant, near_first, near
    # Few rows make few of the claims.
    if len(rows) * claim.shape[1] < len(stated):
        state_claims(*of_claims, claim[patterns.signature[rows]].ravel(), 0, stated)
    else:
        claims = np.arange(len(stated), dtype=np.int32)

        def state(first: int) -> None:
            last = first + CLAIMS_PER_THREAD
            state_claims(*of_claims, claims[first:last], first, stated[first:last])

        share_out(state, range(0, len(claims), CLAIMS_PER_THREAD), threads)
    query = FeasibilityQuery(
        lengths,
        compared,
        marks,
        stated.view("<i8"),
        kinds,
        lane,
        boundary.perimeter,
        corners is None,
    )
    if corners is None:
        corners = np.zeros((0, 0), np.uint8)

    share = max(ROWS_PER_THREAD, len(rows) // MOST_SHARES)

    def run(first: int) -> None:
        last = first + share
        mark(
            systems,
            query,
            rows[first:last],
            patterns.signature,
            patterns.rotation,
            patterns.reflected,
            corners[first:last],
            every,
            flag,
            fits[first:last],
        )

    share_out(run, range(0, len(rows), share), threads)
