"""Collapsing one polychord of a mesh in work: may it be, and doing it.

The mesh is changed in place, so that a collapse costs what lies around the polychord and not
what the mesh has in all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array, border_vertices, next_edge, prev_edge
from patterndb.system.kernels import kernel


class Work(NamedTuple):
    """The mesh in work. Corners of a vertex form a ring by ``after`` and ``before``.

    vertex, twin, after, before: (4q,) int32; corner: (v,) int32 one corner of each vertex;
    valence: (v,) int32; border: (v,) bool; alive: (q,) bool. dirty: (2q,) bool strands
    (2 * quad + direction) that may collapse or have not been looked at since something
    changed beside them. stamp: (1,) int64; seen: (v,) int64; passed: (q,) int64.
    merged: (v,) int32 the vertex that each stamped one goes into. uses: (v,) int32.
    """

    vertex: Int32Array
    twin: Int32Array
    after: Int32Array
    before: Int32Array
    corner: Int32Array
    valence: Int32Array
    border: NDArray[np.bool_]
    alive: NDArray[np.bool_]
    dirty: NDArray[np.bool_]
    stamp: NDArray[np.int64]
    seen: NDArray[np.int64]
    passed: NDArray[np.int64]
    merged: Int32Array
    counted: NDArray[np.int64]
    uses: Int32Array


@kernel
def begin(vertex: Int32Array, twin: Int32Array, n_vertices: int) -> Work:
    """The mesh, whose arrays are changed from now on, with every strand dirty."""
    n = len(twin) // 4
    s = Work(
        vertex,
        twin,
        np.empty(4 * n, np.int32),
        np.empty(4 * n, np.int32),
        np.full(n_vertices, -1, np.int32),
        np.zeros(n_vertices, np.int32),
        border_vertices(twin, vertex, n_vertices),
        np.ones(n, np.bool_),
        np.ones(2 * n, np.bool_),
        np.zeros(1, np.int64),
        np.zeros(n_vertices, np.int64),
        np.zeros(n, np.int64),
        np.zeros(n_vertices, np.int32),
        np.zeros(n_vertices, np.int64),
        np.zeros(n_vertices, np.int32),
    )
    for h in range(4 * n):
        v = vertex[h]
        c = s.corner[v]
        if c < 0:
            s.corner[v] = h
            s.after[h] = h
            s.before[h] = h
        else:
            b = s.before[c]
            s.after[b] = h
            s.before[h] = b
            s.after[h] = c
            s.before[c] = h
        s.valence[v] += 1
    return s


@kernel
def trace_strip(h: int, s: Work, strip: Int32Array) -> tuple[int, bool]:
    """Write the half-edges by which the polychord through edge h enters its quads.

    Returns (their number, is it a loop); the number is -1 where it crosses itself.
    """
    s.stamp[0] += 1
    mark = s.stamp[0]
    start = h
    loop = False
    while s.twin[start] >= 0:
        start = s.twin[start] ^ 2
        if start == h:
            loop = True
            break
        # Passing the first quad in the other direction again means a crossing; the walk
        # forward finds it.
    n = 0
    g = start
    while True:
        if s.passed[g >> 2] == mark:
            return -1, loop
        s.passed[g >> 2] = mark
        strip[n] = g
        n += 1
        g = s.twin[g ^ 2]
        if g < 0 or g == start:
            return n, loop


@kernel
def _rung(strip: Int32Array, length: int, i: int, s: Work) -> tuple[Index, Index]:
    """Left and right vertex of rung i; rung ``length`` is the far end of an open strip."""
    if i < length:
        h = strip[i]
        return s.vertex[h], s.vertex[next_edge(h)]
    h = strip[length - 1] ^ 2
    return s.vertex[next_edge(h)], s.vertex[h]


@kernel
def may_collapse(strip: Int32Array, length: int, loop: bool, s: Work) -> bool:
    """Simple disjoint chains, one of them regular, and nothing broken afterwards?

    Leaves ``passed`` stamped on the strip's quads, ``seen`` on its left chain, and
    ``merged`` telling where that goes.
    """
    rungs = length if loop else length + 1
    s.stamp[0] += 1
    mark = s.stamp[0]
    regular_left = True
    regular_right = True
    for i in range(rungs):
        left, right = _rung(strip, length, i, s)
        if s.seen[left] == mark:
            return False
        s.seen[left] = mark
        if s.seen[right] == mark:
            return False
        s.seen[right] = mark
        end = not loop and (i == 0 or i == length)
        quads = 2 if end else 4
        regular_left &= s.border[left] == end and s.valence[left] == quads
        regular_right &= s.border[right] == end and s.valence[right] == quads
    if not (regular_left or regular_right):
        return False

    s.stamp[0] += 1
    mark = s.stamp[0]
    for i in range(length):
        s.passed[strip[i] >> 2] = mark
    for i in range(rungs):
        left, right = _rung(strip, length, i, s)
        s.seen[left] = mark
        s.merged[left] = right
    for i in range(rungs):
        left, right = _rung(strip, length, i, s)
        c = s.corner[left]
        h = c
        while True:
            if s.passed[h >> 2] != mark:
                base = h & ~3
                for e in range(4):
                    if s.vertex[base + e] == right:
                        return False
            h = s.after[h]
            if h == c:
                break
        if _makes_triple_edge(left, right, mark, s):
            return False
    return True


@kernel
def _makes_triple_edge(left: Index, right: Index, mark: int, s: Work) -> bool:
    """Would an edge at the merged vertex have three quads or more, and had not before?"""
    s.stamp[0] += 1
    tally = s.stamp[0]
    for v in (left, right):
        c = s.corner[v]
        h = c
        while True:
            if s.passed[h >> 2] != mark:
                for w in (s.vertex[next_edge(h)], s.vertex[prev_edge(h)]):
                    if s.seen[w] == mark:
                        w = s.merged[w]
                    if s.counted[w] != tally:
                        s.counted[w] = tally
                        s.uses[w] = 0
                    s.uses[w] += 1
                    if s.uses[w] > 2 and not _was_triple(v, h, s):
                        return True
            h = s.after[h]
            if h == c:
                break
    return False


@kernel
def _was_triple(v: Index, h: Index, s: Work) -> bool:
    """Has an edge at corner h of vertex v three quads or more as it is?"""
    for w in (s.vertex[next_edge(h)], s.vertex[prev_edge(h)]):
        count = 0
        c = s.corner[v]
        g = c
        while True:
            count += s.vertex[next_edge(g)] == w
            count += s.vertex[prev_edge(g)] == w
            g = s.after[g]
            if g == c:
                break
        if count > 2:
            return True
    return False


@kernel
def collapse(strip: Int32Array, length: int, loop: bool, s: Work) -> int:
    """Take the strip out and merge its left chain into its right; return the smallest
    strand that became dirty."""
    rungs = length if loop else length + 1
    lefts = np.empty(rungs, np.int32)
    rights = np.empty(rungs, np.int32)
    for i in range(rungs):
        lefts[i], rights[i] = _rung(strip, length, i, s)
    for i in range(length):
        h = strip[i]
        a = s.twin[prev_edge(h)]
        b = s.twin[next_edge(h)]
        if a >= 0:
            s.twin[a] = b
        if b >= 0:
            s.twin[b] = a
        q = h >> 2
        s.alive[q] = False
        for e in range(4):
            c = 4 * q + e
            v = s.vertex[c]
            s.valence[v] -= 1
            s.after[s.before[c]] = s.after[c]
            s.before[s.after[c]] = s.before[c]
            if s.corner[v] == c:
                s.corner[v] = s.after[c] if s.after[c] != c else -1
    for i in range(rungs):
        left, right = lefts[i], rights[i]
        c = s.corner[left]
        if c < 0:
            continue
        h = c
        while True:
            s.vertex[h] = right
            h = s.after[h]
            if h == c:
                break
        k = s.corner[right]
        if k < 0:
            s.corner[right] = c
        else:
            c_last, k_last = s.before[c], s.before[k]
            s.after[k_last] = c
            s.before[c] = k_last
            s.after[c_last] = k
            s.before[k] = c_last
        s.valence[right] += s.valence[left]
        s.valence[left] = 0
        s.corner[left] = -1
    for i in range(rungs):
        _close_slits(rights[i], s)
    for i in range(rungs):
        _update_border(rights[i], s)
    return _make_dirty(rights, s)


@kernel
def _close_slits(v: Index, s: Work) -> None:
    """Join two border edges at v that have come to lie on each other: a hole of two edges
    between the same two vertices is no hole any more."""
    c = s.corner[v]
    if c < 0:
        return
    h = c
    while True:
        # Border half-edges that leave v against those that end in v.
        if s.twin[h] < 0:
            w = s.vertex[next_edge(h)]
            count = 0
            match = -1
            g = c
            while True:
                if s.vertex[next_edge(g)] == w:
                    count += 1
                p = prev_edge(g)
                if s.vertex[p] == w:
                    count += 1
                    if s.twin[p] < 0 and (p >> 2) != (h >> 2):
                        match = p
                g = s.after[g]
                if g == c:
                    break
            if count == 2 and match >= 0:
                s.twin[h] = match
                s.twin[match] = h
                _update_border(w, s)
        h = s.after[h]
        if h == c:
            break


@kernel
def _update_border(v: Index, s: Work) -> None:
    c = s.corner[v]
    s.border[v] = False
    if c < 0:
        return
    h = c
    while True:
        if s.twin[h] < 0 or s.twin[prev_edge(h)] < 0:
            s.border[v] = True
            return
        h = s.after[h]
        if h == c:
            return


@kernel
def _make_dirty(merged: Int32Array, s: Work) -> Index:
    """Mark the strands of all quads within two rings of the merged vertices."""
    smallest = 2 * len(s.alive)
    for v in merged:
        c = s.corner[v]
        if c < 0:
            continue
        h = c
        while True:
            for e in range(4):
                k = s.corner[s.vertex[(h & ~3) + e]]
                g = k
                while True:
                    q = g >> 2
                    s.dirty[2 * q] = True
                    s.dirty[2 * q + 1] = True
                    smallest = min(smallest, 2 * q)
                    g = s.after[g]
                    if g == k:
                        break
            h = s.after[h]
            if h == c:
                break
    return smallest
