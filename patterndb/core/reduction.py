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

from patterndb.core.halfedge import Index, Int32Array, fans, next_edge, prev_edge
from patterndb.errors import InvalidMeshError
from patterndb.system.kernels import kernel

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


@kernel
def reduction_work(n_vertices: int, max_quads: int) -> ReductionWork:
    """Scratch for patches of at most ``max_quads`` quads of a mesh with ``n_vertices``."""
    return ReductionWork(
        np.zeros(n_vertices, np.int64),
        np.zeros(n_vertices, np.int64),
        np.zeros(2, np.int64),
        np.zeros(4 * max_quads, np.int32),
        np.full(4 * max_quads, -1, np.int32),
        np.zeros(4 * max_quads, np.int32),
        np.zeros(4 * max_quads, np.int32),
        np.zeros(4 * max_quads, np.int32),
    )


@kernel(borrowing=True)
def dissolve(
    n_quads: int,
    twin: Int32Array,
    vertex: Int32Array,
    count: Int32Array,
    full: Int32Array,
    work: ReductionWork,
) -> tuple[int, int]:
    """Reduce the disk ``twin``; return (quads, starting half-edges) of the pattern.

    twin, vertex: (>= 4 * n_quads,) int32 half-edges of the disk and the mesh vertex of
    each corner. count: per mesh vertex, the disk's quads at it. full: the count at which
    the vertex is interior (its valence in the mesh; NEVER_FULL on the mesh's border).
    The pattern is left in ``work.reduced`` and ``work.starts``.
    """
    n_border = 0
    work.stamp[1] += 1
    mark = work.stamp[1]
    curvature = 0
    for h in range(4 * n_quads):
        if twin[h] < 0:
            work.border[n_border] = h
            n_border += 1
        v = vertex[h]
        if work.seen[v] != mark:
            work.seen[v] = mark
            if count[v] == full[v] and count[v] < 4:
                curvature += 4 - count[v]
    mark_chains(n_quads, twin, vertex, count, full, work, n_border, curvature)
    return cut_blocks(n_quads, twin, vertex, count, work)


@kernel(borrowing=True)
def mark_chains(
    n_quads: int,
    twin: Int32Array,
    vertex: Int32Array,
    count: Int32Array,
    full: Int32Array,
    work: ReductionWork,
    n_border: Index,
    curvature: Index,
) -> None:
    """Mark the vertices of a disk's chains that dissolve: ``work.gone`` is ``work.stamp[0]`` there.

    The disk is as in :func:`dissolve`; ``work.border[:n_border]`` are the half-edges of its border,
    and ``curvature`` is the sum of 4 - valence over its interior vertices of valence 1 to 3.
    """
    gone, seen, stamp = work.gone, work.seen, work.stamp
    n = 4 * n_quads
    stamp[0] += 1
    removed = stamp[0]

    # Chains between flat boundary vertices.
    for i in range(n_border):
        h = work.border[i]
        v = vertex[h]
        if count[v] != 2 or gone[v] == removed:
            continue
        first = twin[prev_edge(h)]
        if first < 0:
            continue
        stamp[1] += 1
        mark = stamp[1]
        seen[v] = mark
        t = first
        while True:
            ahead = next_edge(t)
            w = vertex[ahead]
            if seen[w] == mark:
                straight = False
                break
            seen[w] = mark
            if count[w] == full[w]:
                if count[w] != 4:
                    straight = False
                    break
                t = next_edge(twin[ahead])
            else:
                straight = count[w] == 2
                break
        if straight:
            gone[v] = removed
            t = first
            while True:
                ahead = next_edge(t)
                w = vertex[ahead]
                gone[w] = removed
                if count[w] != full[w]:
                    break
                t = next_edge(twin[ahead])

    # Closed chains. By Gauss-Bonnet one encloses irregular vertices with a sum of
    # 4 - valence of 4, so most patches need no search.
    if curvature >= 4:
        for h in range(n):
            v = vertex[h]
            if twin[h] < 0 or count[v] != 4 or full[v] != 4:
                continue
            stamp[1] += 1
            mark = stamp[1]
            closed = False
            t = h
            while True:
                ahead = next_edge(t)
                w = vertex[ahead]
                if w == v:
                    closed = next_edge(twin[ahead]) == h
                    break
                if seen[w] == mark or count[w] != 4 or full[w] != 4:
                    break
                seen[w] = mark
                t = next_edge(twin[ahead])
            if closed:
                t = h
                while True:
                    gone[vertex[t]] = removed
                    t = next_edge(twin[next_edge(t)])
                    if t == h:
                        break


@kernel
def dissolve_straight(
    n_quads: int,
    twin: Int32Array,
    vertex: Int32Array,
    count: Int32Array,
    full: Int32Array,
    work: ReductionWork,
) -> tuple[int, int]:
    """Reduce a disk as :func:`dissolve` does, and dissolve chains that cross themselves, too.

    Expanding what is left gives the disk back: on both sides of a straight chain lie copies of one
    polychord, wherever it goes.
    """
    work.stamp[0] += 1
    removed = work.stamp[0]
    # Half-edges inside from which a walk comes to no end, or to the border.
    passed = np.zeros(4 * n_quads, np.bool_)
    for h in range(4 * n_quads):
        v = vertex[h]
        is_open = twin[h] < 0
        if is_open:
            first = twin[prev_edge(h)] if count[v] == 2 else -1
        else:
            first = h if full[v] != NEVER_FULL and not passed[h] else -1
        if first < 0:
            continue
        t = first
        while True:
            ahead = next_edge(t)
            w = vertex[ahead]
            if full[w] == NEVER_FULL or count[w] != 4:
                straight = is_open and full[w] == NEVER_FULL and count[w] == 2
                break
            passed[t] = True
            t = next_edge(twin[ahead])
            if not is_open and (t == first or passed[t]):
                straight = t == first
                break
        if not straight:
            continue
        work.gone[vertex[first]] = removed
        t = first
        while True:
            ahead = next_edge(t)
            work.gone[vertex[ahead]] = removed
            if full[vertex[ahead]] == NEVER_FULL:
                break
            t = next_edge(twin[ahead])
            if t == first:
                break
    return cut_blocks(n_quads, twin, vertex, count, work)


@kernel(borrowing=True)
def _walk_block(
    start: Index, number: Index, twin: Int32Array, vertex: Int32Array, work: ReductionWork
) -> None:
    """Number the sides of a block from 4 number on, counter-clockwise from the half-edge that
    begins the first; note what lies across."""
    gone, removed = work.gone, work.stamp[0]
    h = start
    for b in range(4 * number, 4 * number + 4):
        work.block[h] = b
        work.head[b] = h
        while True:
            ahead = next_edge(h)
            if gone[vertex[ahead]] != removed:
                break
            h = next_edge(twin[ahead])
        work.reduced[b] = twin[h]
        h = ahead


@kernel(borrowing=True)
def cut_blocks(
    n_quads: int, twin: Int32Array, vertex: Int32Array, count: Int32Array, work: ReductionWork
) -> tuple[int, int]:
    """Cut a disk into the blocks of quads between the vertices that :func:`mark_chains` left;
    return as :func:`dissolve` does."""
    gone, removed = work.gone, work.stamp[0]
    block, head, reduced, starts = work.block, work.head, work.reduced, work.starts
    n = 4 * n_quads
    n_blocks = 0
    for h in range(n):
        if block[h] < 0 and gone[vertex[h]] != removed:
            _walk_block(h, n_blocks, twin, vertex, work)
            n_blocks += 1

    n_starts = 0
    for b in range(4 * n_blocks):
        t = reduced[b]
        if t >= 0:
            reduced[b] = block[t]
        elif count[vertex[head[b]]] != 2:
            starts[n_starts] = b
            n_starts += 1
    for b in range(4 * n_blocks):
        block[head[b]] = -1
    if n_starts == 0:
        for b in range(4 * n_blocks):
            if reduced[b] < 0:
                starts[n_starts] = b
                n_starts += 1
    return n_blocks, n_starts


@kernel(borrowing=True)
def read_pattern(
    start: Index,
    twin: Int32Array,
    vertex: Int32Array,
    code: NDArray[np.uint16],
    work: ReductionWork,
) -> Index:
    """Write the pattern of a disk as :func:`patterndb.core.code.rooted_code` reads it, counter-
    clockwise from a half-edge whose tail :func:`mark_chains` left; return its number of quads.

    It looks at the blocks in the order of the reading, and at no others.
    """
    block, head, reduced = work.block, work.head, work.reduced
    n_blocks = 0
    at = -1
    t = start
    while True:
        if t >= 0 and block[t] < 0:
            # A block met for the first time, by this edge of it.
            _walk_block(t, n_blocks, twin, vertex, work)
            n_blocks += 1
        if at >= 0:
            code[at] = 1 + block[t] if t >= 0 else 0
        at += 1
        if at == 4 * n_blocks:
            break
        t = reduced[at]
    for b in range(4 * n_blocks):
        block[head[b]] = -1
    return n_blocks


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
