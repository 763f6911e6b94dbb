"""The pieces that the solved sub-cycles leave: cuts followed from the whole cycle down."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.chords.subcycles import Subcycles, part_number, path_of, step_offset


@kernel
def traced(
    n: int, numbering: Subcycles, choice: NDArray[np.int32], n_chosen: int
) -> tuple[Int64Array, Int64Array, Int64Array]:
    """The chosen chords, and the pieces' positions with the bounds between the pieces."""
    m, k = len(numbering.first), len(numbering.ends)
    chosen = np.empty(n_chosen, np.int64)
    bounds = np.empty(n_chosen + 1, np.int64)
    positions = np.empty(n + 2 * n_chosen, np.int64)
    path = np.empty(k + 1, np.int64)
    steps = np.empty(k + 1, np.int64)
    open_wraps = np.empty(n_chosen + 1, np.int64)
    open_numbers = np.empty(n_chosen + 1, np.int64)
    open_wraps[0], open_numbers[0] = m, numbering.paths[k, 0] - 1
    n_open, n_cuts, n_pieces, n_positions = 1, 0, 0, 0
    while n_open:
        n_open -= 1
        wrap, number = open_wraps[n_open], open_numbers[n_open]
        n_steps = path_of(numbering, wrap, number, path, steps)
        c = choice[numbering.base[wrap] + number]
        if c < 0:
            n_positions = _written(n, numbering, wrap, path, steps, n_steps, positions, n_positions)
            bounds[n_pieces] = n_positions
            n_pieces += 1
            continue
        chosen[n_cuts] = c
        n_cuts += 1
        a = 0
        while path[a] < numbering.first[c]:
            a += 1
        b = a
        while path[b] < numbering.last[c]:
            b += 1
        stop = path[n_steps]
        without = 0
        for t in range(a, b):
            without += step_offset(numbering, path[t], steps[t], stop)
        open_wraps[n_open], open_numbers[n_open] = c, part_number(numbering, path, steps, a, b)
        n_open += 1
        open_wraps[n_open] = wrap
        open_numbers[n_open] = number - without + numbering.offsets[stop, c]
        n_open += 1
    return chosen, bounds[: n_pieces - 1], positions


@kernel
def _written(
    n: int,
    numbering: Subcycles,
    wrap: int,
    path: Int64Array,
    steps: Int64Array,
    n_steps: int,
    positions: Int64Array,
    at: int,
) -> int:
    """Write a piece's positions from ``at`` on; returns where they stop."""
    ends = numbering.ends
    for t in range(n_steps):
        begin = ends[path[t]]
        stop = begin + 1
        if steps[t] < 0:
            stop = ends[path[t] + 1] if path[t] + 1 < len(ends) else ends[0] + n
        for v in range(begin, stop):
            positions[at] = v % n
            at += 1
    if wrap < len(numbering.first):
        positions[at] = ends[path[n_steps]]
        at += 1
    return at
