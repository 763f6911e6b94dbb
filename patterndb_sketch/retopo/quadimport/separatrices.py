"""Separatrices: edges that cut a mesh of quads into regular grids."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Index, Int32Array, next_edge, prev_edge
from patterndb.geometry.points import Bools
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.quadimport.connectivity import Quads


def separatrices(mesh: Quads) -> tuple[Bools, Bools]:
    """(4q,) bool, half-edges on curves between patches; (v,) bool, vertices that are corners.

    From every irregular vertex edges are followed straight ahead, to an irregular vertex or the
    border; border edges count too. A part without an irregular vertex is cut along one strip
    each way. All edges of a corner are on curves, and a curve passes every other vertex straight:
    what is left is grids of w x h quads, never with a T-junction.

    Differs from the program of Takayama et al. 2013: parts without irregular vertices are cut.
    """
    marked = mesh.twin < 0
    _run_all(mesh.twin, mesh.tail, mesh.irregular, mesh.border, marked)
    _cut_regular(mesh.twin, mesh.tail, mesh.irregular, mesh.border, marked)
    unmarked = np.zeros(len(mesh.points), np.bool_)
    unmarked[mesh.tail[~marked]] = True
    unmarked[np.roll(mesh.quads, -1, axis=1).ravel()[~marked]] = True
    return marked, ~unmarked & (mesh.valence > 0)


@kernel
def _run(twin: Int32Array, tail: Int32Array, stop: Bools, marked: Bools, h: Index) -> None:
    """Mark edges straight ahead from half-edge h on, until one that is marked, or a stop."""
    while not marked[h]:
        marked[h] = True
        if twin[h] >= 0:
            marked[twin[h]] = True
        ahead = next_edge(h)
        if stop[tail[ahead]]:
            return
        # Across the edge ahead, and on: a regular vertex inside has four.
        h = next_edge(twin[ahead])


@kernel
def _run_all(
    twin: Int32Array, tail: Int32Array, irregular: Bools, border: Bools, marked: Bools
) -> None:
    stop = irregular | border
    for h in range(len(twin)):
        if irregular[tail[h]]:
            _run(twin, tail, stop, marked, h)


@kernel
def _cut_regular(
    twin: Int32Array, tail: Int32Array, irregular: Bools, border: Bools, marked: Bools
) -> None:
    """Cut parts without irregular vertices: across from a vertex of the border, where there is
    one; else from the first vertex along both of its lines."""
    stop = irregular | border
    seen = np.zeros(len(twin) // 4, np.bool_)
    stack = np.empty(len(twin) // 4, np.int32)
    for root in range(len(seen)):
        if seen[root]:
            continue
        seen[root] = True
        stack[0] = root
        top = 1
        regular = True
        begin = -1
        while top:
            top -= 1
            f = stack[top]
            for e in range(4):
                h = 4 * f + e
                if irregular[tail[h]]:
                    regular = False
                if twin[h] < 0:
                    begin = h if begin < 0 else min(begin, h)
                elif not seen[twin[h] >> 2]:
                    seen[twin[h] >> 2] = True
                    stack[top] = twin[h] >> 2
                    top += 1
        if not regular:
            continue
        # The edge to the left of a half-edge's start, seen along it.
        if begin >= 0:
            _run(twin, tail, stop, marked, twin[prev_edge(begin)])
        else:
            _run(twin, tail, stop, marked, 4 * root)
            _run(twin, tail, stop, marked, twin[prev_edge(4 * root)])
