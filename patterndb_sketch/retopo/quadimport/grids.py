"""Grids: the regular regions between separatrices, and fills that are such grids."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from patterndb.core.halfedge import Index, Int32Array, next_edge, prev_edge
from patterndb.core.pattern import Pattern
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.filling.choice import Choice
from query.expand import expand
from query.fill import Fill

#: Grids of so many sizes are kept.
KEPT = 4096


@kernel
def grid(twin: Int32Array, tail: Int32Array, h: Index, w: Index, n: Index) -> Int32Array:
    """(n + 1, w + 1) the vertices of the grid of w x n quads whose first row begins with
    half-edge h: row 0 from its start on, ahead of it; rows lie one left of the other."""
    found = np.empty((n + 1, w + 1), np.int32)
    row = h
    for j in range(n):
        at = row
        for i in range(w):
            found[j, i] = tail[at]
            if j == n - 1:
                found[n, i] = tail[prev_edge(at)]
            if i == w - 1:
                found[j, w] = tail[next_edge(at)]
                if j == n - 1:
                    found[n, w] = tail[prev_edge(prev_edge(at))]
            else:
                at = next_edge(twin[next_edge(at)])
        if j < n - 1:
            row = twin[prev_edge(prev_edge(row))]
    return found


@lru_cache(maxsize=KEPT)
def regular_choice(w: int, n: int) -> tuple[Choice, Int32Array]:
    """The fill of a patch of w x n edges by a regular grid, as the query engine gives it, taken by
    the user; and (n + 1, w + 1) the numbers of its vertices, row 0 along side 0."""
    fill = regular_fill(w, n)
    tail = fill.quads.ravel()
    head = np.roll(fill.quads, -1, axis=1).ravel()
    number = {(int(a), int(b)): h for h, (a, b) in enumerate(zip(tail, head, strict=True))}
    twin = np.array(
        [number.get((int(b), int(a)), -1) for a, b in zip(tail, head, strict=True)], np.int32
    )
    vertices = grid(twin, tail, number[0, 1], w, n)
    vertices.flags.writeable = False
    return Choice.of(fill, "user"), vertices


def regular_fill(w: int, n: int) -> Fill:
    """The pattern of one quad, expanded to w x n."""
    return expand(Pattern.from_code(np.zeros(4, np.uint16)), (w, n))
