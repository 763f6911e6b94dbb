"""Reduction of a disk to its pattern, in one pass.

Collapsing polychords until none may collapse leaves the same pattern as dissolving, all at
once, every edge chain that runs straight through interior vertices of valence 4, crosses
itself nowhere, and is closed or ends at flat boundary vertices. Dissolving is the faster
of the two; the tests hold it against collapsing.

Source: Marcias et al. 2015, section 3.2 ("Pattern reduction"). Differs from the paper: it
asks both chains of a polychord to be free of irregular vertices; one is enough (the
polychord then runs parallel to its neighbour on that side), and with two many patterns
would be left half reduced.

Copies of a polychord that crosses itself cross themselves, so neither way takes one of them
away. :func:`dissolve_straight` does: it undoes all that expansion does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.halfedge import fans
from patterndb._native.core.reduction import dissolve, reduction_work
from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidMeshError

#: ``full`` of a vertex on the mesh's border, which no number of quads closes.
NEVER_FULL = 2**30


class ReductionWork(NamedTuple):
    """Scratch of :func:`dissolve`, made once for many patches.

    gone, seen: (n_vertices,) int64 stamps; stamp: (2,) int64, the last ones used.
    border: (4 * max_quads,) int32. block: (4 * max_quads,) int32, -1 between two calls. head:
    (4 * max_quads,) int32. reduced: (4 * max_quads,) int32, the result's half-edges. starts:
    (4 * max_quads,) int32, its corners' half-edges.
    """

    gone: NDArray[np.int64]
    seen: NDArray[np.int64]
    stamp: NDArray[np.int64]
    border: Int32Array
    block: Int32Array
    head: Int32Array
    reduced: Int32Array
    starts: Int32Array


def reduce_disk(twin: Int32Array) -> Int32Array:
    """The half-edges (4m,) int32 of the pattern of a disk given by (4q,) int32 half-edges.

    Raises InvalidMeshError if the quads have no border (reduction is of disks).
    """
    twin = np.ascontiguousarray(twin, dtype=np.int32)
    q = len(twin) // 4
    if not (twin < 0).any():
        raise InvalidMeshError("the quads have no border: only disks reduce to patterns")
    vertex, n_vertices = fans(twin)
    count = np.bincount(vertex, minlength=n_vertices).astype(np.int32)
    full = count.copy()
    border = np.flatnonzero(twin < 0)
    full[vertex[border]] = NEVER_FULL
    full[vertex[(border & ~3) | ((border + 1) & 3)]] = NEVER_FULL
    work = reduction_work(n_vertices, q)
    m, _ = dissolve(q, twin, vertex, count, full, work)
    return work.reduced[: 4 * m].copy()
