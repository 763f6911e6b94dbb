"""Strips of quads, the strands of polychords, as lines in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, sort_by_edge
from patterndb.geometry.points import Points


def pair_edges(quads: NDArray[np.integer]) -> Int32Array:
    """Pair (4 q,) half-edges with those on the other side, for quads (q, 4); -1 for none.

    Half-edge 4 i + k leads from corner k of quad i to the next. Of an edge with more than two
    quads only two are joined.
    """
    order, start = sort_by_edge(quads.ravel(), np.roll(quads, -1, axis=1).ravel())
    first = start[:-1][np.diff(start) > 1]
    found = np.full(quads.size, -1, np.int32)
    found[order[first]], found[order[first + 1]] = order[first + 1], order[first]
    return found


def follow_strip(twin: Int32Array, half: int) -> list[int]:
    """The half-edges that the strip of quads through one crosses, in order; the first again at the
    end where the strip comes back to it.

    twin: (4 q,) as :func:`pair_edges` gives it.
    """
    onward = _across(twin, half)
    if len(onward) > 1 and onward[-1] == half:
        return onward
    back = _across(twin, int(twin[half])) if twin[half] >= 0 else []
    return back[:0:-1] + onward


def trace_strip(vertices: Points, quads: NDArray[np.integer], half: int) -> Points:
    """Trace (n, 3) the middles of the edges that the strip of quads through a half-edge crosses, in
    order; the first again at the end where it comes back to it."""
    return _middles(vertices, quads, follow_strip(pair_edges(quads), half))


def trace_strips_at(
    vertices: Points, quads: NDArray[np.integer], quad: int, twin: Int32Array | None = None
) -> list[Points]:
    """The lines (n, 3) along the strips of quads that pass a quad: two, or one that passes it both
    ways.

    vertices: (v, 3). quads: (q, 4), all turned alike. twin: as :func:`pair_edges` gives it, if it
    is there already. See :func:`trace_strip`.
    """
    twin = pair_edges(quads) if twin is None else twin
    first = follow_strip(twin, 4 * quad)
    lines = [_middles(vertices, quads, first)]
    # Seen from either of its quads an edge is one.
    crossed = {*first, *(int(twin[half]) for half in first)}
    if 4 * quad + 1 not in crossed and 4 * quad + 3 not in crossed:
        lines.append(_middles(vertices, quads, follow_strip(twin, 4 * quad + 1)))
    return lines


def _middles(vertices: Points, quads: NDArray[np.integer], way: list[int]) -> Points:
    tail, head = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    return 0.5 * (vertices[tail[way]] + vertices[head[way]])


def _across(twin: Int32Array, half: int) -> list[int]:
    """Half-edges from one on, each opposite to the one before in the quad that lies there; it ends
    on an open edge, or with the first again."""
    way = [half]
    while True:
        opposite = way[-1] ^ 2
        way.append(int(twin[opposite]) if twin[opposite] >= 0 else opposite)
        # A strip crosses a quad twice at most.
        if twin[opposite] < 0 or way[-1] == half or len(way) > len(twin) // 2:
            return way
