"""Which patterns of a class fit a boundary, and in which orientations.

Whether lengths can be met depends on a pattern's signature and on the orientation alone.
Each is one system, first screened together with the other orientations of its signature, then,
if need be, decided by a flow (:func:`query.solving.matching.is_matchable`). Marcias et al. 2015,
section 4, solve one integer program a pattern.

The screen looks at four orientations at once. A *word* is a 64-bit integer that stands for four
small ones, a *lane* each: the sum of v_l * 2**(16 l) over the lanes l = 0..3. Words add and
subtract lane by lane, whatever the signs. With SIGNS added every v_l in -2**15..2**15 - 1 becomes a
16-bit field of its own, whose highest bit says whether v_l >= 0. So every linear inequality costs
one addition more than it has terms, for four orientations together. The bits of ``refused`` at
SIGNS say which lanes have no solution; its others mean nothing. Perimeters are at most 2,000
(:mod:`query.boundary`), so that no sum below leaves its lane.
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
from query.solving.matching import is_matchable
from query.solving.systems import Int16Array, SignedRows, Systems, systems_of

#: Patterns that a thread takes at a time: a millisecond of work or less, so that all
#: threads end together, and so much that handing it over costs nothing.
ROWS_PER_THREAD = 1024

#: Patterns between two looks at the cancel flag: some ten microseconds.
ROWS_PER_LOOK = 64

Flag = NDArray[np.uint8]


class _Query(NamedTuple):
    """What is asked of a class, for the kernels.

    lengths: (g, w) words, see the module: a lane for each different way in which
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
    query = _Query(pack_words(lengths), kinds, lane, boundary.perimeter, corners is None)
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
        if not screen_system(
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
            cut = is_matchable(need, row, first, class_i, class_j, near_first, near, flow, scratch)
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


#: Orientations in a word, and bits of each.
LANES = 4
BITS = 16

#: 1 in every lane, and the highest bit of every field.
ONES = 0x0001_0001_0001_0001
SIGNS = -0x7FFF_7FFF_7FFF_8000


def pack_words(rows: Int32Array) -> Int64Array:
    """(ceil(o / 4), w) int64 words of the (o, w) rows, filled up with lanes of -1.

    No length is negative, so that a lane that fills up is refused.
    """
    o, w = rows.shape
    padded = np.full((-(-o // LANES) * LANES, w), -1, np.int64)
    padded[:o] = rows
    weights = np.int64(1) << (BITS * np.arange(LANES, dtype=np.int64))
    return np.ascontiguousarray((padded.reshape(-1, LANES, w) * weights[:, None]).sum(axis=1))


@kernel
def mark_negative(word: int) -> int:
    """At SIGNS: the lanes below 0."""
    return ~(word + SIGNS)


@kernel
def lane_of(word: int, lane: int) -> int:
    """The value of one lane."""
    return (((word + SIGNS) >> (BITS * lane)) & 0xFFFF) - 0x8000


@kernel
def is_refused(refused: int, lane: int) -> bool:
    """Is the lane marked?"""
    return (refused >> (BITS * lane + BITS - 1)) & 1 != 0


@kernel(inline="always")
def screen_system(
    row: int,
    base: Int16Array,
    looped: NDArray[np.bool_],
    component: Int16Array,
    colour: Int16Array,
    parity: NDArray[np.bool_],
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
    lengths: Int64Array,
    slack: Int64Array,
    reach: Int64Array,
    refused: Int64Array,
) -> bool:
    """Write the slack of every side, and refuse the lanes that need no closer look.

    Refused is where a side is too short, where parity forbids (see
    :func:`query.solving.systems.is_balanced`), and where a side asks for more than its neighbours
    have together. base to parity, first to class_j: see :class:`query.solving.systems.Systems`,
    of which this is the system in this row. lengths, slack: (g, w) words; reach: (w,) scratch;
    refused: (g,), added to. Returns whether any lane is left.
    """
    n_words, w = lengths.shape
    left = False
    for g in range(n_words):
        bad = refused[g]
        for s in range(w):
            word = lengths[g, s] - base[row, s] * ONES
            slack[g, s] = word
            reach[s] = -word
            bad |= mark_negative(word)
        if bad & SIGNS != SIGNS and parity[row]:
            bad |= _refused_by_parity(component[row], colour[row], slack, g)
        if bad & SIGNS != SIGNS:
            for k in range(first[row], first[row + 1]):
                i = class_i[k]
                j = class_j[k]
                reach[i] += slack[g, j]
                reach[j] += slack[g, i]
            for s in range(w):
                if not looped[row, s]:
                    bad |= mark_negative(reach[s])
            left |= bad & SIGNS != SIGNS
        refused[g] = bad
    return left


@kernel(inline="always")
def _refused_by_parity(component: Int16Array, colour: Int16Array, slack: Int64Array, g: int) -> int:
    """The lanes of word g whose slack some component cannot take."""
    w = slack.shape[1]
    bad = 0
    for root in range(w):
        if component[root] != root:
            continue
        word = 0
        for s in range(root, w):
            if component[s] == root:
                word += -slack[g, s] if colour[s] < 0 else slack[g, s]
        if colour[root] == 0:
            # The lowest bit of every field moves to its highest.
            bad |= (word + SIGNS) << (BITS - 1)
        else:
            bad |= mark_negative(word) | mark_negative(-word)
    return bad


@kernel(inline="always")
def refuse_cut(
    sides: Int32Array, n_sides: int, neighbour: Int32Array, slack: Int64Array, refused: Int64Array
) -> None:
    """Refuse the lanes in which the first sides ask for more than their neighbours have.

    sides: (>= n_sides,) int32; neighbour: (w,) int32, >= 0 at the sides that any of these
    is joined to. What one orientation fails by, others of the same system often do.
    """
    n_words, w = slack.shape
    for g in range(n_words):
        if refused[g] & SIGNS == SIGNS:
            continue
        word = 0
        for at in range(n_sides):
            word -= slack[g, sides[at]]
        for s in range(w):
            if neighbour[s] >= 0:
                word += slack[g, s]
        refused[g] |= mark_negative(word)
