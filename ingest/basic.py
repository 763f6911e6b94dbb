"""Basic enumeration: every patch of at most so many quads, each exactly once.

Connected sets of quads are built from their smallest quad, never returning to a quad that
was passed over (Redelmeier's way to count polyominoes), so each set comes up once and
nothing need be remembered; those that are disks are patches. Differs from the paper, which
grows disks and remembers them by a hash.

Most small patches look alike. A running hash of how each quad is attached to those before
it finds the pattern of a patch that was built the same way before, without reducing it.
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
from ingest.hashing import UInt64Array, double_map, empty_keys, find, has_slot, mix
from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel


@kernel
def count_basic(
    first: int,
    last: int,
    limit: int,
    mesh: KernelMesh,
    bench: Bench,
    census: Census,
    pulse: NDArray[np.int64],
) -> tuple[int, Census]:
    """Count the patches of at most ``limit`` quads whose smallest quad is in first..last - 1.

    pulse: (2,) int64; the work is broken off once pulse[0] is not 0, and pulse[1] is raised
    by the patches met. Returns their number and the census with their patterns counted.
    """
    slots = min(1 << 16, census.most[0])
    keys = np.zeros((slots, 2), np.uint64)
    rows = np.zeros(slots, np.int32)
    stack = _new_stack(first, limit, len(mesh.zobrist))
    while not _count_on(last, limit, mesh, bench, census, pulse, stack, keys, rows):
        if not has_slot(stack.n_keys[0], keys):
            if len(keys) < census.most[0]:
                keys, rows = double_map(keys, rows)
            else:
                empty_keys(keys)
                stack.n_keys[0] = 0
        census = with_room(census, 4 * limit)
    return stack.total[0], census


class _Stack(NamedTuple):
    """How far the search has come.

    quads, entry: the candidates, with the edge by which each was reached; those of a patch of d
    quads are quads[at[d]:end[d]]. euler, build, hashes: of the patch of d quads V - E + F, the hash
    of how it was built, and that of its quads; entered: (limit,) the edge by which each of its
    quads was reached. reached: (q,) bool, is a quad a candidate, or was it one below?

    place: (2,) int64, the root, and quads of the patch at hand, -1 between two roots. n_keys,
    total: (1,) int64, how many there are so far.
    """

    quads: Int32Array
    entry: Int32Array
    at: Int32Array
    end: Int32Array
    euler: Int32Array
    build: UInt64Array
    hashes: UInt64Array
    entered: Int32Array
    reached: NDArray[np.bool_]
    place: NDArray[np.int64]
    n_keys: NDArray[np.int64]
    total: NDArray[np.int64]


@kernel
def _new_stack(first: int, limit: int, n_quads: int) -> _Stack:
    place = np.empty(2, np.int64)
    place[0] = first
    place[1] = -1
    return _Stack(
        np.empty(4 * limit + 4, np.int32),
        np.empty(4 * limit + 4, np.int32),
        np.zeros(limit + 1, np.int32),
        np.zeros(limit + 1, np.int32),
        np.zeros(limit + 1, np.int32),
        np.zeros((limit + 1, 2), np.uint64),
        np.zeros((limit + 1, 2), np.uint64),
        np.zeros(limit, np.int32),
        np.zeros(n_quads, np.bool_),
        place,
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
    )


@kernel(borrowing=True)
def _count_on(
    last: int,
    limit: int,
    mesh: KernelMesh,
    bench: Bench,
    census: Census,
    pulse: NDArray[np.int64],
    stack: _Stack,
    keys: UInt64Array,
    rows: Int32Array,
) -> bool:
    """Go on with the search of :func:`count_basic` until it is over, or broken off by ``pulse``;
    False if it stands still before a patch for which one of the tables may have no room.

    keys, rows: what a patch that was built in some way was recognised as.
    """
    twin, zobrist, member, quads = mesh.twin, mesh.zobrist, bench.member, bench.quads
    disk, border = bench.twin, bench.reduction.border
    candidates, entry, at, end = stack.quads, stack.entry, stack.at, stack.end
    euler, build, hashes = stack.euler, stack.build, stack.hashes
    entered, reached, place = stack.entered, stack.reached, stack.place

    while place[0] < last and pulse[0] == 0:
        root = place[0]
        if place[1] < 0:
            place[1] = 0
            candidates[0] = root
            entry[0] = 0
            reached[root] = True
            at[0] = 0
            end[0] = 1
        d = place[1]
        while True:
            if at[d] < end[d]:
                if not (has_slot(stack.n_keys[0], keys) and has_room(census, 4 * limit)):
                    place[1] = d
                    return False
                q = candidates[at[d]]
                enter = entry[at[d]]
                entered[d] = enter
                a, b = build[d, 0], build[d, 1]
                for r in range(4):
                    t = twin[4 * q + ((enter + r) & 3)]
                    if t >= 0:
                        j = member[t >> 2]
                        if j >= 0:
                            how = ((d * limit + j) * 4 + r) * 4 + (((t & 3) - entered[j]) & 3)
                            x = mix(np.uint64(how + 1) * np.uint64(0x9E3779B97F4A7C15))
                            a ^= x
                            b ^= mix(x ^ np.uint64(0xA0761D6478BD642F))
                # The size belongs to the hash: it tells a lone quad from nothing.
                build[d + 1, 0] = a
                build[d + 1, 1] = b
                hashes[d + 1, 0] = hashes[d, 0] ^ zobrist[q, 0]
                hashes[d + 1, 1] = hashes[d, 1] ^ zobrist[q, 1]
                euler[d + 1] = euler[d] + add_quad(q, d, mesh, bench)
                n = d + 1
                if euler[n] == 1:
                    stack.total[0] += 1
                    pulse[1] += 1
                    a += np.uint64(n)
                    slot = find(keys, a, b)
                    if slot >= 0:
                        value = rows[slot]
                    else:
                        n_border = 0
                        for h in range(4 * n):
                            if disk[h] < 0:
                                border[n_border] = h
                                n_border += 1
                        value = recognise(n, n_border, mesh, bench, census)
                        if value < 0:
                            value = add_reading(n, n_border, mesh, bench, census)
                        slot = -1 - slot
                        keys[slot, 0] = a
                        keys[slot, 1] = b
                        rows[slot] = value
                        stack.n_keys[0] += 1
                    count_patch(value, census)
                    propose_example(value >> 1, n, hashes[n, 0], hashes[n, 1], quads, census)
                if n < limit:
                    e = end[d]
                    for r in range(4):
                        t = twin[4 * q + r]
                        if t >= 0 and (t >> 2) > root and not reached[t >> 2]:
                            reached[t >> 2] = True
                            candidates[e] = t >> 2
                            entry[e] = t & 3
                            e += 1
                    end[n] = e
                    at[n] = at[d] + 1
                    d = n
                else:
                    remove_quad(q, mesh, bench)
                    at[d] += 1
            else:
                d -= 1
                if d < 0:
                    break
                for i in range(end[d], end[d + 1]):
                    reached[candidates[i]] = False
                remove_quad(candidates[at[d]], mesh, bench)
                at[d] += 1
        reached[root] = False
        place[0] += 1
        place[1] = -1
    return True
