"""Which patterns of a class fit a boundary, and in which orientations.

Whether lengths can be met depends on a pattern's signature and on the orientation alone.
Each is one system, first screened together with the other orientations of its signature
(:mod:`.screen`), then, if need be, decided by a flow (:mod:`.rounding`). Marcias
et al. 2015, section 4, solve one integer program a pattern.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.core.patternclass import PatternClass
from patterndb.system.kernels import kernel
from query.boundary import Boundary
from query.orientation import corners_seen, sides_seen
from query.solving.halves import COPY_BY, QUEUE
from query.solving.rounding import matchable
from query.solving.screen import BITS, LANES, is_refused, lane_of, refuse_cut, screen, words
from query.solving.systems import Signed, Systems, systems_of
from query.solving.threads import share_out

#: Patterns that a thread takes at a time: a millisecond of work or less, so that all
#: threads end together, and so much that handing it over costs nothing.
ROWS_PER_THREAD = 1024

#: Patterns between two looks at the cancel flag: some ten microseconds.
ROWS_PER_LOOK = 64

Flag = NDArray[np.uint8]


class _Query(NamedTuple):
    """What is asked of a class, for the kernels.

    lengths: (g, w) words, see :mod:`query.solving.screen`: a lane for each different way in which
             a signature sees the boundary.
    kinds:   (n, N) int32 quads at the corners in each lane; corner s is where side s of the
             signature begins.
    lane:    (2 N,) int32 the lane of each orientation.
    perimeter: edges around the boundary.
    convex:  do corners not matter?
    """

    lengths: Int64Array
    kinds: Int32Array
    lane: Int32Array
    perimeter: int
    convex: bool


def _distinct(boundary: Boundary) -> tuple[Int32Array, Int32Array, Int32Array]:
    """The boundary as a signature sees it, once per orientation that looks different.

    Returns ((d, max(N, 1)) int32 lengths, (d, N) int32 quads at the corners, (2N,) int32 which
    of these rows each orientation is).
    """
    lengths = np.array(boundary.lengths, np.int32)[sides_seen(max(boundary.n_sides, 1))]
    counts = np.array(boundary.corner_counts, np.int32)[corners_seen(boundary.n_sides)]
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


def feasible_rows(
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


def feasible_orientations(
    patterns: PatternClass,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
    cancel: Flag | None = None,
) -> NDArray[np.bool_]:
    """(r, o) bool: in which orientations the patterns in these rows fit strictly.

    o = 2 max(N, 1), in the order of :func:`query.orientation.orientations`; none is left
    out for a symmetry of the pattern. Where the boundary has reflex corners, those of the
    pattern must fall on them. Arguments as in :func:`feasible_rows`.
    """
    fits = np.zeros((len(rows), 2 * max(patterns.n_sides, 1)), np.bool_)
    corners = None if boundary.convex else patterns.corners[rows]
    _answer(patterns, boundary, rows, corners, True, threads, cancel, fits)
    return fits


def lengths_met(
    rows_of: Signed,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
    cancel: Flag | None = None,
) -> NDArray[np.bool_]:
    """As :func:`feasible_orientations`, of anything with signatures and whatever the corners."""
    fits = np.zeros((len(rows), 2 * rows_of.lengths.shape[1]), np.bool_)
    _answer(rows_of, boundary, rows, None, True, threads, cancel, fits)
    return fits


def _answer(
    patterns: Signed,
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
    query = _Query(words(lengths), kinds, lane, boundary.perimeter, corners is None)
    if corners is None:
        corners = np.zeros((0, 0), np.uint8)
    flag = np.zeros(1, np.uint8) if cancel is None else cancel
    signature = patterns.signature[rows]
    turn = patterns.rotation[rows]
    reflected = patterns.reflected[rows]

    def run(first: int) -> None:
        last = first + ROWS_PER_THREAD
        _mark(
            systems,
            query,
            signature[first:last],
            turn[first:last],
            reflected[first:last],
            corners[first:last],
            every,
            flag,
            fits[first:last],
        )

    share_out(run, range(0, len(rows), ROWS_PER_THREAD), threads)


@kernel
def _mark(
    systems: Systems,
    query: _Query,
    signature: Int32Array,
    turn: Int32Array,
    reflected: NDArray[np.bool_],
    corners: NDArray[np.uint8],
    every: bool,
    cancel: Flag,
    fits: NDArray[np.bool_],
) -> None:
    """:func:`_answer` for some rows: signature, turn, reflected: (r,); corners: (r, N)."""
    # Taken apart once: every access to an array in a tuple counts references, in one place
    # for all threads.
    graphs, base, perimeter, looped, component, colour, parity = systems
    first, class_i, class_j, near_first, near = graphs
    lengths, kinds, lane_of_orientation, most, convex = query
    n_words, w = lengths.shape
    slack = np.empty((n_words, w), np.int64)
    reach = np.empty(w, np.int64)
    refused = np.empty(n_words, np.int64)
    need = np.empty(w, np.int32)
    flow = np.empty((w, w), np.int32)
    scratch = np.empty((5, w), np.int32)
    fit = np.empty(n_words * LANES, np.bool_)
    for u in range(len(signature)):
        if u % ROWS_PER_LOOK == 0 and cancel[0] != 0:
            return
        row = signature[u]
        if perimeter[row] > most:
            continue
        refused[:] = 0
        if not convex:
            _refuse_by_corners(kinds, corners[u], turn[u], reflected[u], refused)
        if not screen(
            row,
            base,
            looped,
            component,
            colour,
            parity,
            first,
            class_i,
            class_j,
            lengths,
            slack,
            reach,
            refused,
        ):
            continue
        found = False
        for lane in range(len(fit)):
            g = lane // LANES
            at = lane % LANES
            fit[lane] = False
            if is_refused(refused[g], at):
                continue
            for s in range(w):
                need[s] = lane_of(slack[g, s], at)
            cut = matchable(need, row, first, class_i, class_j, near_first, near, flow, scratch)
            if cut == 0:
                fit[lane] = True
                found = True
                if not every:
                    break
            elif cut > 0:
                refuse_cut(scratch[QUEUE], cut, scratch[COPY_BY], slack, refused)
        if not every:
            fits[u, 0] = found
        elif found:
            _turn_back(lane_of_orientation, fit, turn[u], reflected[u], fits[u])


@kernel
def _refuse_by_corners(
    kinds: Int32Array, corners: NDArray[np.uint8], turn: int, reflected: bool, refused: Int64Array
) -> None:
    """Refuse the lanes in which a corner of the pattern falls on one of another kind."""
    n_lanes, n = kinds.shape
    for lane in range(n_lanes):
        for s in range(n):
            if kinds[lane, s] != corners[(turn + 1 - s if reflected else turn + s) % n]:
                refused[lane // LANES] |= np.int64(1) << (BITS * (lane % LANES) + BITS - 1)
                break


@kernel
def _turn_back(
    lane: Int32Array,
    fit: NDArray[np.bool_],
    turn: int,
    reflected: bool,
    fits: NDArray[np.bool_],
) -> None:
    """Set ``fits``, by orientation of the pattern, from ``fit``, by lane of its signature.

    Side i of the signature is the pattern's side turn + i, or turn - i where reflected. So
    what the orientation (mirrored, r) of the pattern is to its sides, (mirrored, r - turn)
    is to the signature's, or, where reflected, (not mirrored, turn - r).
    """
    n = len(fits) // 2
    for r in range(n):
        at = (turn - r if reflected else r - turn) % n
        fits[r] = fit[lane[at + n if reflected else at]]
        fits[n + r] = fit[lane[at if reflected else at + n]]
