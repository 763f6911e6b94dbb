"""Growth by whole sides: the *side* and *convex* modes of enumeration.

From every quad, all quads beyond one whole side of the patch are added at once, again and
again; in the convex mode the quads around reflex corners follow until none is left. Patches
are reached along many ways, so those met are remembered by a hash of their quads, and the
search goes depth-first: a patch is grown on from the state it was reached in.

Source: Marcias et al. 2015, section 3.2 ("Patch enumeration", "Managing duplicates").
Differs from the paper: it hashes the boundary vertices, which on a closed mesh cannot tell a
patch from its complement; here the quads are hashed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ingest.census import (
    Bench,
    Census,
    KernelMesh,
    add_quad,
    add_reading,
    count_patch,
    has_room,
    propose_example,
    recognise,
    remove_quad,
    with_room,
)
from ingest.hashing import UInt64Array, double_set, find, has_slot
from patterndb.core.buffers import copy_items, copy_rows
from patterndb.core.halfedge import Index, Int32Array, next_edge
from patterndb.system.kernels import kernel


@kernel
def grow(
    roots: Int32Array,
    limit: int,
    convex: bool,
    smaller: int,
    others: UInt64Array,
    shard: Int32Array,
    mesh: KernelMesh,
    bench: Bench,
    census: Census,
    pulse: NDArray[np.int64],
) -> tuple[int, UInt64Array, UInt64Array, Int32Array, Census]:
    """Count all patches of at most ``limit`` quads that grow from the roots.

    smaller: patches of at most so many quads were counted by another mode already; they
    are grown on, and counted in the total, but not in the census. others: set of hashes of
    patches counted by another mode. shard: (q,) int32; the roots are all quads of one
    shard. A patch that reaches into another shard may be found from there too, so it is
    not counted but returned.

    Returns (patches counted, the set of all hashes met, and of the patches that reach
    into other shards: (r, 2) hashes and (r,) int32 2 * row + handedness, -1 where another
    mode counts it; the census). pulse: as in :func:`ingest.basic.count_basic`.
    """
    met = np.zeros((1 << 12, 2), np.uint64)
    far_hash = np.empty((64, 2), np.uint64)
    far_value = np.empty(64, np.int32)
    frames = _new_frames(limit, len(mesh.zobrist))
    while not _grow_on(
        roots, limit, convex, smaller, others, shard, mesh, bench, census, pulse, frames, met,
        far_hash, far_value,
    ):  # fmt: skip
        if not has_slot(frames.n_met[0], met):
            met = double_set(met)
        if frames.n_far[0] == len(far_hash):
            far_hash, far_value = _longer(far_hash, far_value)
        census = with_room(census, 4 * limit)
    n_far = frames.n_far[0]
    return frames.total[0], met, far_hash[:n_far].copy(), far_value[:n_far].copy(), census


class _Frames(NamedTuple):
    """How far the search has come: one frame a patch on the way, frame 0 the empty one.

    A patch's quads are ``bench.quads[:size]``; its boundary and the places of its corners on it
    lie in pools, up to ``border_end`` and ``corner_end``. side: the next to grow beyond. euler,
    foreign, hashes, pattern: V - E + F, the quads of other shards, the hash, 2 * row + handedness
    or -1.

    mark: (q,) int64, of the last strip looked at, by its number ``stamp``. at: (4,) int64 place of
    the root, or of the next one; frame, -1 between two roots; quads, candidate included; is there
    a candidate above the frame? n_met, n_far, total: (1,) int64, how many there are so far.
    """

    border: Int32Array
    border_end: Int32Array
    corners: Int32Array
    corner_end: Int32Array
    side: Int32Array
    size: Int32Array
    euler: Int32Array
    foreign: Int32Array
    hashes: UInt64Array
    pattern: Int32Array
    mark: NDArray[np.int64]
    stamp: NDArray[np.int64]
    at: NDArray[np.int64]
    n_met: NDArray[np.int64]
    n_far: NDArray[np.int64]
    total: NDArray[np.int64]


@kernel
def _new_frames(limit: int, n_quads: int) -> _Frames:
    # A patch of n quads has at most 2n + 2 edges.
    pool = (limit + 1) * (2 * limit + 2)
    at = np.zeros(4, np.int64)
    at[1] = -1
    return _Frames(
        np.empty(pool, np.int32),
        np.zeros(limit + 2, np.int32),
        np.empty(pool, np.int32),
        np.zeros(limit + 2, np.int32),
        np.zeros(limit + 1, np.int32),
        np.zeros(limit + 2, np.int32),
        np.zeros(limit + 2, np.int32),
        np.zeros(limit + 2, np.int32),
        np.zeros((limit + 2, 2), np.uint64),
        np.full(limit + 2, -1, np.int32),
        np.zeros(n_quads, np.int64),
        np.zeros(1, np.int64),
        at,
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
    )


@kernel(borrowing=True)
def _grow_on(
    roots: Int32Array,
    limit: int,
    convex: bool,
    smaller: int,
    others: UInt64Array,
    shard: Int32Array,
    mesh: KernelMesh,
    bench: Bench,
    census: Census,
    pulse: NDArray[np.int64],
    frames: _Frames,
    met: UInt64Array,
    far_hash: UInt64Array,
    far_value: Int32Array,
) -> bool:
    """Go on with the search of :func:`grow` until it is over, or broken off by ``pulse``; False if
    it stands still before a patch for which one of the tables may have no room."""
    twin, zobrist, member, quads = mesh.twin, mesh.zobrist, bench.member, bench.quads
    own_border = bench.reduction.border
    border, border_end = frames.border, frames.border_end
    corners, corner_end = frames.corners, frames.corner_end
    side, size, euler, foreign = frames.side, frames.size, frames.euler, frames.foreign
    hashes, pattern, mark, at = frames.hashes, frames.pattern, frames.mark, frames.at
    stamp = frames.stamp[0]

    while at[0] < len(roots) and pulse[0] == 0:
        root = roots[at[0]]
        home = shard[root]
        if at[1] < 0:
            at[1] = 0
            at[2] = 1
            at[3] = 1
            euler[1] = add_quad(root, 0, mesh, bench)
            hashes[1, 0] = zobrist[root, 0]
            hashes[1, 1] = zobrist[root, 1]
            foreign[1] = 0
            pattern[1] = -1
        d = at[1]
        n = at[2]
        candidate = at[3] != 0
        while pulse[0] == 0:
            # A candidate is quads[:n] above frame d: keep it or take it back.
            if candidate:
                if (
                    not has_slot(frames.n_met[0], met)
                    or frames.n_far[0] == len(far_hash)
                    or not has_room(census, 4 * limit)
                ):
                    at[1] = d
                    at[2] = n
                    at[3] = 1
                    frames.stamp[0] = stamp
                    return False
                a, b = hashes[d + 1, 0], hashes[d + 1, 1]
                slot = find(met, a, b) if euler[d + 1] == 1 else 0
                if slot < 0:
                    met[-1 - slot, 0] = a
                    met[-1 - slot, 1] = b
                    frames.n_met[0] += 1
                    pulse[1] += 1
                    d += 1
                    size[d] = n
                    side[d] = 0
                    value = -1
                    alone = foreign[d] == 0
                    counted = n > smaller and not (alone and find(others, a, b) >= 0)
                    if n < limit or (counted and pattern[d] < 0):
                        _walk(n, d, mesh, bench, border, border_end, corners, corner_end)
                    if counted:
                        if pattern[d] < 0:
                            first = border_end[d - 1]
                            perimeter = border_end[d] - first
                            for i in range(perimeter):
                                h = border[first + i]
                                own_border[i] = 4 * member[h >> 2] + (h & 3)
                            value = recognise(n, perimeter, mesh, bench, census)
                            if value < 0:
                                value = add_reading(n, perimeter, mesh, bench, census)
                            pattern[d] = value
                        value = pattern[d]
                        row = value >> 1
                        propose_example(row, n, a, b, quads, census)
                        if alone:
                            count_patch(value, census)
                    if alone:
                        frames.total[0] += 1
                    else:
                        n_far = frames.n_far[0]
                        far_hash[n_far, 0] = a
                        far_hash[n_far, 1] = b
                        far_value[n_far] = value
                        frames.n_far[0] = n_far + 1
                    if n == limit:
                        border_end[d] = border_end[d - 1]
                        corner_end[d] = corner_end[d - 1]
                        side[d] = 1
                else:
                    for i in range(n - 1, size[d] - 1, -1):
                        remove_quad(quads[i], mesh, bench)
                    if d == 0:
                        break
            # Grow the patch of frame d beyond its next side.
            n_corners = corner_end[d] - corner_end[d - 1]
            if side[d] < max(n_corners, 1):
                s = side[d]
                side[d] += 1
                n = size[d]
                first = border_end[d - 1]
                perimeter = border_end[d] - first
                if n_corners == 0:
                    begin, length = 0, perimeter
                else:
                    begin = corners[corner_end[d - 1] + s]
                    if s + 1 < n_corners:
                        length = corners[corner_end[d - 1] + s + 1] - begin
                    else:
                        length = corners[corner_end[d - 1]] + perimeter - begin
                # Look before adding anything: is there a quad beyond every edge, are they
                # few enough, and do they make a patch that was met before? (No patch is
                # met before it is convex, so none around reflex corners is missed.)
                stamp += 1
                room = limit - n
                a, b = hashes[d, 0], hashes[d, 1]
                candidate = True
                # Where the side runs past the boundary's first edge: wrapped (no division).
                wrap = perimeter - begin
                for i in range(length):
                    t = twin[border[first + (begin + i if i < wrap else i - wrap)]]
                    if t < 0:
                        candidate = False
                        break
                    q = t >> 2
                    if mark[q] != stamp:
                        mark[q] = stamp
                        a ^= zobrist[q, 0]
                        b ^= zobrist[q, 1]
                        room -= 1
                        if room < 0:
                            candidate = False
                            break
                if not candidate or find(met, a, b) >= 0:
                    candidate = False
                    continue
                chi = euler[d]
                outside = foreign[d]
                for i in range(length):
                    q = twin[border[first + (begin + i if i < wrap else i - wrap)]] >> 2
                    if member[q] < 0:
                        chi += add_quad(q, n, mesh, bench)
                        outside += shard[q] != home
                        n += 1
                added = n - size[d]
                if convex:
                    n, chi, a, b, outside, candidate = _mend_reflex(
                        size[d], n, limit, chi, a, b, outside, home, shard, mesh, bench
                    )
                    if not candidate:
                        for j in range(n - 1, size[d] - 1, -1):
                            remove_quad(quads[j], mesh, bench)
                        continue
                euler[d + 1] = chi
                hashes[d + 1, 0] = a
                hashes[d + 1, 1] = b
                foreign[d + 1] = outside
                pattern[d + 1] = -1
                if added == length and n == size[d] + added and n_corners != 1:
                    side_of = border[first : border_end[d]]
                    if _runs_straight(side_of, begin, length, n_corners == 0, mesh, bench):
                        pattern[d + 1] = pattern[d]
            else:
                # Done with frame d: take its quads back and go on with the one below.
                for i in range(size[d] - 1, size[d - 1] - 1, -1):
                    remove_quad(quads[i], mesh, bench)
                d -= 1
                candidate = False
                if d == 0:
                    break
        at[0] += 1
        at[1] = -1
    return True


@kernel(borrowing=True)
def _mend_reflex(
    first_new: Index,
    n: Index,
    limit: int,
    chi: Index,
    a: np.uint64,
    b: np.uint64,
    outside: Index,
    home: Index,
    shard: Int32Array,
    mesh: KernelMesh,
    bench: Bench,
) -> tuple[Index, Index, np.uint64, np.uint64, Index, bool]:
    """Add the quads around reflex corners until there is none; only vertices of the quads
    from place ``first_new`` on can be one.

    Returns the patch's size, V - E + F, hash and number of foreign quads, and whether it
    worked out: not where a reflex corner lies on the mesh's border, nor beyond the limit.
    """
    i = first_new
    while i < n:
        for e in range(4):
            v = mesh.vertex[4 * bench.quads[i] + e]
            k = bench.held[v]
            if k < 3 or k == mesh.full[v]:
                continue
            if mesh.full[v] != mesh.valence[v] or n + mesh.valence[v] - k > limit:
                return n, chi, a, b, outside, False
            for j in range(mesh.star_start[v], mesh.star_start[v + 1]):
                q = mesh.star[j]
                if bench.member[q] < 0:
                    chi += add_quad(q, n, mesh, bench)
                    a ^= mesh.zobrist[q, 0]
                    b ^= mesh.zobrist[q, 1]
                    outside += shard[q] != home
                    n += 1
        i += 1
    return n, chi, a, b, outside, True


@kernel(borrowing=True)
def _runs_straight(
    border: Int32Array, begin: Index, length: Index, closed: bool, mesh: KernelMesh, bench: Bench
) -> bool:
    """Is the side, of the boundary as it was before the patch grew over it, now a chain
    through vertices of valence 4, closed or between flat boundary vertices, and is the strip
    that grew over it open along its far side?"""
    perimeter = len(border)
    for i in range(length):
        h = border[(begin + i) % perimeter]
        v = mesh.vertex[h]
        # Where the far sides of the strip's quads are one edge (about a vertex of valence 2),
        # collapsing the strip folds the old side just so, and the pattern is another.
        beyond = mesh.twin[mesh.twin[h] ^ 2]
        if beyond >= 0 and bench.member[beyond >> 2] >= 0:
            return False
        if i == 0 and not closed:
            w = mesh.vertex[border[(begin + length) % perimeter]]
            if bench.held[v] != 2 or mesh.full[v] == 2:
                return False
            if bench.held[w] != 2 or mesh.full[w] == 2:
                return False
        elif bench.held[v] != 4 or mesh.full[v] != 4:
            return False
    return True


@kernel(borrowing=True)
def _walk(
    n: Index,
    d: int,
    mesh: KernelMesh,
    bench: Bench,
    border: Int32Array,
    border_end: Int32Array,
    corners: Int32Array,
    corner_end: Int32Array,
) -> None:
    """Write the boundary of the patch ``bench.quads[:n]``, and where its corners lie on it,
    behind those of frame d - 1."""
    h0 = -1
    for i in range(n):
        base = 4 * bench.quads[n - 1 - i]
        for e in range(4):
            t = mesh.twin[base + e]
            if t < 0 or bench.member[t >> 2] < 0:
                h0 = base + e
                break
        if h0 >= 0:
            break
    at = border_end[d - 1]
    corner = corner_end[d - 1]
    h = h0
    while True:
        if bench.held[mesh.vertex[h]] != 2:
            corners[corner] = at - border_end[d - 1]
            corner += 1
        border[at] = h
        at += 1
        h = next_edge(h)
        while True:
            t = mesh.twin[h]
            if t < 0 or bench.member[t >> 2] < 0:
                break
            h = next_edge(t)
        if h == h0:
            break
    border_end[d] = at
    corner_end[d] = corner


@kernel
def _longer(hashes: UInt64Array, values: Int32Array) -> tuple[UInt64Array, Int32Array]:
    n = len(hashes)
    more_hashes = np.empty((2 * n, 2), np.uint64)
    copy_rows(hashes, n, more_hashes)
    more_values = np.empty(2 * n, np.int32)
    copy_items(values, n, more_values, 0)
    return more_hashes, more_values
