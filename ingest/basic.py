"""Basic enumeration: every patch of at most so many quads, each exactly once.

Connected sets of quads are built from their smallest quad, never returning to a quad that
was passed over (Redelmeier's way to count polyominoes), so each set comes up once and
nothing need be remembered; those that are disks are patches. Differs from the paper, which
grows disks and remembers them by a hash.

Most small patches look alike. A running hash of how each quad is attached to those before
it finds the pattern of a patch that was built the same way before, without reducing it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ingest.census import (
    Bench,
    Census,
    KernelMesh,
    add_quad,
    propose_example,
    recognise,
    remove_quad,
)
from ingest.hashing import LOAD, double_map, find, mix
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
    n_quads = len(mesh.twin) // 4
    reached = np.zeros(n_quads, np.bool_)
    # Candidates are a stack of quads, with the edge by which each was reached.
    stack = np.empty(4 * limit + 4, np.int32)
    entry = np.empty(4 * limit + 4, np.int32)
    at = np.zeros(limit + 1, np.int32)
    end = np.zeros(limit + 1, np.int32)
    euler = np.zeros(limit + 1, np.int32)
    build = np.zeros((limit + 1, 2), np.uint64)
    hashes = np.zeros((limit + 1, 2), np.uint64)
    entered = np.zeros(limit, np.int32)

    keys = np.zeros((1 << 16, 2), np.uint64)
    rows = np.zeros(1 << 16, np.int32)
    n_keys = 0

    total = 0
    for root in range(first, last):
        if pulse[0] != 0:
            break
        before = total
        stack[0] = root
        entry[0] = 0
        reached[root] = True
        at[0] = 0
        end[0] = 1
        d = 0
        while True:
            if at[d] < end[d]:
                q = stack[at[d]]
                enter = entry[at[d]]
                entered[d] = enter
                a, b = build[d, 0], build[d, 1]
                for r in range(4):
                    t = mesh.twin[4 * q + ((enter + r) & 3)]
                    if t >= 0:
                        j = bench.member[t >> 2]
                        if j >= 0:
                            how = ((d * limit + j) * 4 + r) * 4 + (((t & 3) - entered[j]) & 3)
                            x = mix(np.uint64(how + 1) * np.uint64(0x9E3779B97F4A7C15))
                            a ^= x
                            b ^= mix(x ^ np.uint64(0xA0761D6478BD642F))
                # The size belongs to the hash: it tells a lone quad from nothing.
                build[d + 1, 0] = a
                build[d + 1, 1] = b
                hashes[d + 1, 0] = hashes[d, 0] ^ mesh.zobrist[q, 0]
                hashes[d + 1, 1] = hashes[d, 1] ^ mesh.zobrist[q, 1]
                euler[d + 1] = euler[d] + add_quad(q, d, mesh, bench)
                n = d + 1
                if euler[n] == 1:
                    total += 1
                    a += np.uint64(n)
                    slot = find(keys, a, b)
                    if slot >= 0:
                        value = rows[slot]
                    else:
                        value, census = recognise(n, mesh, bench, census)
                        if n_keys + 1 > LOAD * keys.shape[0]:
                            keys, rows = double_map(keys, rows)
                        slot = -1 - find(keys, a, b)
                        keys[slot, 0] = a
                        keys[slot, 1] = b
                        rows[slot] = value
                        n_keys += 1
                    row = value >> 1
                    census.patches[row, value & 1] += 1
                    propose_example(row, n, hashes[n, 0], hashes[n, 1], bench.quads, census)
                if n < limit:
                    e = end[d]
                    for r in range(4):
                        t = mesh.twin[4 * q + r]
                        if t >= 0 and (t >> 2) > root and not reached[t >> 2]:
                            reached[t >> 2] = True
                            stack[e] = t >> 2
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
                    reached[stack[i]] = False
                remove_quad(stack[at[d]], mesh, bench)
                at[d] += 1
        reached[root] = False
        pulse[1] += total - before
    return total, census
