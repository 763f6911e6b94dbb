"""Which patterns of a class fit a boundary in at least one orientation.

Whether lengths can be met depends on a pattern's signature alone, so one test serves
every pattern that shares it; only where the boundary has reflex corners is each pattern
looked at by itself. Marcias et al. 2015, section 4, solve one integer program a pattern.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit
from numpy.typing import NDArray

from patterndb.halfedge import Int32Array
from patterndb.patternclass import PatternClass
from query.boundary import Boundary
from query.matching import balanced, search, two_colour
from query.orientation import orientations
from query.transport import integral, transport

#: Signatures that are worth a thread of their own: some ten milliseconds of work.
ROWS_PER_THREAD = 2048


def targets(boundary: Boundary) -> tuple[Int32Array, Int32Array]:
    """The boundary as a signature sees it, once per orientation that looks different.

    Returns ((o, max(N, 1)) int32 lengths, (o, N) int32 quads at the corners).
    """
    seen = [o.seen(boundary) for o in orientations(boundary.n_sides)]
    rows = np.unique(np.array([np.r_[lengths, counts] for lengths, counts in seen]), axis=0)
    width = len(boundary.lengths)
    return np.ascontiguousarray(rows[:, :width]), np.ascontiguousarray(rows[:, width:])


def corners_in_signature_order(patterns: PatternClass, rows: NDArray[np.int64]) -> Int32Array:
    """(r, N) int32 quads at the corners of the patterns in these rows.

    Corner s is where side s of the pattern's signature begins; see ``PatternClass.rotation``.
    """
    n = patterns.n_sides
    s = np.arange(n)
    turn = patterns.rotation[rows, None].astype(np.int64)
    reflected = patterns.reflected[rows, None]
    corner = np.where(reflected, turn + 1 - s, turn + s) % max(n, 1)
    return np.take_along_axis(patterns.corners[rows].astype(np.int32), corner, axis=1)


def units(
    patterns: PatternClass, boundary: Boundary, rows: NDArray[np.int64], kinds: Int32Array
) -> tuple[Int32Array, NDArray[np.bool_], NDArray[np.int64]]:
    """What has to be tested so that each of the rows is answered.

    kinds: (o, N) quads at the corners in each orientation. Returns ((u,) int32
    signatures, (u, o) bool orientations in which the corners match kind for kind,
    (r,) int64 the unit that answers each row).
    """
    if boundary.convex:
        signature, unit = np.unique(patterns.signature[rows], return_inverse=True)
        allowed = np.ones((len(signature), len(kinds)), np.bool_)
        return signature.astype(np.int32), allowed, unit.ravel()
    corners = corners_in_signature_order(patterns, rows)
    allowed = np.stack([(corners == kind).all(axis=1) for kind in kinds], axis=1)
    return patterns.signature[rows].astype(np.int32), allowed, np.arange(len(rows))


def feasible_rows(
    patterns: PatternClass,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
) -> NDArray[np.int64]:
    """Those of the rows, in order, whose pattern fits the boundary strictly.

    rows: (r,) int64 row numbers of the class; each must have as many reflex corners as the
    boundary. threads: at most so many (default: one a processor); the result does not
    depend on it.
    """
    lengths, kinds = targets(boundary)
    signature, allowed, unit = units(patterns, boundary, rows, kinds)
    fits = np.zeros(len(signature), np.bool_)
    wanted = min(threads or os.cpu_count() or 1, -(-len(signature) // ROWS_PER_THREAD))
    cuts = np.linspace(0, len(signature), max(wanted, 1) + 1).astype(np.int64)

    def run(first: int, last: int) -> None:
        _mark_feasible(
            patterns.lengths, patterns.joins, lengths, signature, allowed, first, last, fits
        )

    if wanted <= 1:
        run(0, len(signature))
    else:
        with ThreadPoolExecutor(wanted) as pool:
            list(pool.map(run, cuts[:-1].tolist(), cuts[1:].tolist()))
    return rows[fits[unit]]


@njit(cache=True, nogil=True)
def _mark_feasible(
    base: Int32Array,
    joins: Int32Array,
    lengths: Int32Array,
    signature: Int32Array,
    allowed: NDArray[np.bool_],
    first: int,
    last: int,
    fits: NDArray[np.bool_],
) -> None:
    """Set ``fits`` for the units first..last - 1.

    base: (s, w), joins: (s, w, w) of :class:`PatternClass`; lengths: (o, w) edges asked
    for; signature: (u,), allowed: (u, o), fits: (u,) of :func:`units`.
    """
    n_orientations, w = lengths.shape
    most = w * (w + 1) // 2
    class_i = np.empty(most, np.int32)
    class_j = np.empty(most, np.int32)
    class_n = np.ones(most, np.int32)
    closed = np.zeros(most, np.bool_)
    rows = np.empty((1, most), np.int32)
    component = np.empty(w, np.int32)
    colour = np.empty(w, np.int32)
    side_scratch = np.empty((5, w), np.int32)
    class_scratch = np.empty((3, most), np.int32)
    flow = np.empty((2, most), np.int32)
    slack = np.empty(w, np.int32)
    perimeter = lengths[0].sum()
    for u in range(first, last):
        row = signature[u]
        if base[row].sum() > perimeter:
            continue
        m = 0
        for i in range(w):
            for j in range(i, w):
                if joins[row, i, j] > 0:
                    class_i[m] = i
                    class_j[m] = j
                    m += 1
        for k in range(m):
            closed[k] = False
        two_colour(class_i, class_j, m, closed, component, colour, side_scratch[0])
        for o in range(n_orientations):
            if not allowed[u, o]:
                continue
            enough = True
            for s in range(w):
                slack[s] = lengths[o, s] - base[row, s]
                if slack[s] < 0:
                    enough = False
                    break
            if not enough or not balanced(slack, component, colour, side_scratch[0]):
                continue
            if not transport(slack, class_i, class_j, m, closed, flow, side_scratch):
                continue
            # Seldom is the flow not a matching yet, and seldom then is there none.
            if integral(flow, m):
                found = 1
            else:
                found, _ = search(
                    slack,
                    class_i,
                    class_j,
                    class_n,
                    m,
                    0,
                    rows,
                    closed,
                    side_scratch,
                    class_scratch,
                )
            if found > 0:
                fits[u] = True
                break
