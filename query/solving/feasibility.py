"""Which patterns of a class fit a boundary, and in which orientations.

Whether lengths can be met depends on a pattern's signature and on the orientation alone. Each is
one system. A sieve refuses most of them, all orientations of a signature together
(:mod:`query.solving.sieve`); parity may refuse others
(:func:`query.solving.systems.is_balanced`); a flow decides the rest
(:func:`query.solving.matching.is_matchable`), and what one orientation fails by, others of the same
system often do. Marcias et al. 2015, section 4, solve one integer program a pattern.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.core.patternclass import PatternClass
from patterndb.system.kernels import kernel
from query.boundary import Boundary
from query.orientation import list_corners_seen, list_sides_seen
from query.solving.batch import share_out
from query.solving.halves import COPY_BY, QUEUE
from query.solving.jointclaims import MOST_SIDES, SUMS, TABLES, is_refused, sum_needs
from query.solving.matching import is_matchable
from query.solving.sieve import (
    LANES,
    compare_pairs,
    drop_lane,
    has_lane,
    mark_lanes,
    pack_lengths,
    sift_system,
    state_claims,
)
from query.solving.systems import Int16Array, SignedRows, Systems, is_balanced, systems_of

#: Patterns that a thread takes at a time: a millisecond of work or less, so that all
#: threads end together, and so much that handing it over costs nothing.
ROWS_PER_THREAD = 2048

#: The most times that patterns are handed over: of many a thread takes more.
MOST_SHARES = 64

#: Claims likewise.
CLAIMS_PER_THREAD = 4096

#: Patterns between two looks at the cancel flag: some ten microseconds.
ROWS_PER_LOOK = 64

Flag = NDArray[np.uint8]


class _Query(NamedTuple):
    """What is asked of a class, for the kernels.

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
    query = _Query(
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
        _mark(
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


@kernel
def _mark(
    systems: Systems,
    query: _Query,
    rows: NDArray[np.int64],
    signature: Int32Array,
    rotation: Int32Array,
    reflected: NDArray[np.bool_],
    corners: NDArray[np.uint8],
    every: bool,
    cancel: Flag,
    fits: NDArray[np.bool_],
) -> None:
    """:func:`_answer` for some rows (r,); corners: (r, N). signature, rotation, reflected: of all
    rows."""
    # Taken apart once: every access to an array in a tuple counts references, in one place
    # for all threads.
    (
        graphs,
        base,
        pairs,
        perimeter,
        surplus,
        _,
        component,
        colour,
        parity,
        graph,
        joint_first,
        joint,
    ) = systems
    first, class_i, class_j, claim, near_first, near = graphs
    lengths, compared, marks, stated, kinds, lane_of_orientation, most, convex = query
    n_lanes, w = lengths.shape
    left = np.empty(len(marks), np.int64)
    # Joint claims count on sides that there are not.
    needs = np.zeros(max(w, MOST_SIDES), np.int32)
    need = needs[:w]
    flow = np.empty((w, w), np.int32)
    scratch = np.empty((5, w), np.int32)
    fit = np.empty(n_lanes, np.bool_)
    sums = np.zeros(TABLES * SUMS, np.int32)
    for u in range(len(rows)):
        if u % ROWS_PER_LOOK == 0 and cancel[0] != 0:
            return
        at = int(rows[u])
        row = int(signature[at])
        if perimeter[row] > most:
            continue
        if not sift_system(row, pairs, surplus, claim, marks, compared, stated, left):
            continue
        if not convex:
            _drop_by_corners(kinds, corners[u], rotation[at], reflected[at], left)
        found = False
        asking = int(joint_first[graph[row]])
        asked = int(joint_first[graph[row] + 1])
        for lane in range(n_lanes):
            fit[lane] = False
            if not has_lane(left, lane):
                continue
            if not _is_within(lengths[lane], base[row], need):
                continue
            if parity[row] and not is_balanced(need, component[row], colour[row], scratch[0]):
                continue
            if asking < asked:
                sum_needs(needs, sums)
                if is_refused(asking, asked, joint, sums):
                    continue
            cut = is_matchable(
                need, row, first, class_i, class_j, claim, near_first, near, flow, scratch
            )
            if cut == 0:
                fit[lane] = True
                found = True
                if not every:
                    break
            elif cut > 0:
                _drop_by_cut(scratch[QUEUE], cut, scratch[COPY_BY], lengths, base[row], lane, left)
        if not every:
            fits[u, 0] = found
        elif found:
            _turn_back(lane_of_orientation, fit, rotation[at], reflected[at], fits[u])


@kernel(inline="always")
def _is_within(lengths: Int32Array, base: Int16Array, need: Int32Array) -> bool:
    """Write by how much lengths exceed base lengths; is that nowhere below 0?"""
    least = 0
    for s in range(len(need)):
        need[s] = lengths[s] - base[s]
        least = min(least, need[s])
    return least >= 0


@kernel
def _drop_by_corners(
    kinds: Int32Array, corners: NDArray[np.uint8], turn: int, reflected: bool, left: Int64Array
) -> None:
    """Drop the lanes in which a corner of the pattern falls on one of another kind."""
    n_lanes, n = kinds.shape
    for lane in range(n_lanes):
        if not has_lane(left, lane):
            continue
        for s in range(n):
            if kinds[lane, s] != corners[(turn + 1 - s if reflected else turn + s) % n]:
                drop_lane(left, lane)
                break


@kernel(inline="always")
def _drop_by_cut(
    sides: Int32Array,
    n_sides: int,
    neighbour: Int32Array,
    lengths: Int32Array,
    base: Int16Array,
    last: int,
    left: Int64Array,
) -> None:
    """Drop the lanes after the last in which the first sides ask for more than their neighbours
    have.

    sides: (>= n_sides,) int32; neighbour: (w,) int32, >= 0 at the sides that any of these
    is joined to.
    """
    n_lanes, w = lengths.shape
    for lane in range(last + 1, n_lanes):
        if not has_lane(left, lane):
            continue
        spare = 0
        for at in range(n_sides):
            spare -= lengths[lane, sides[at]] - base[sides[at]]
        for s in range(w):
            if neighbour[s] >= 0:
                spare += lengths[lane, s] - base[s]
        if spare < 0:
            drop_lane(left, lane)


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
