"""What several sides ask of their neighbours together: claims that refuse systems without a flow.

Sides of which no two are joined, and none to itself, can be no wider together than all sides that
any of them is joined to:

    sum of need_i over a set S <= sum of need_j over its neighbours N(S)

where need is by how much a length exceeds the base length. A single side's claim is the sieve's
(:mod:`query.solving.sieve`); those of all sets together say exactly whether halves would do, as
the flow of :mod:`query.solving.halves` does: a set that breaks its claim is a cut. Of a graph of 12
sides there are some 50 sets that no others imply. Those likeliest to be broken are listed for each
graph, and refuse nine in ten of the systems that the flow would, at a twentieth of its price. What
they let pass is not known to fit.

A claim is one number, the set's bits below those of its neighbours. Sums over sets are looked up:
of every five sides the 32 sums of needs.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel

#: Sides of the largest graphs with joint claims: a set and its neighbours are 30 bits of a number.
MOST_SIDES = 15

#: Claims of a graph: of what all, some 48 of 12 sides, would refuse 24 refuse 90 %, 32 refuse 93 %
#: (2,489 systems that passed the sieve); a line of the processor's cache holds 16.
MOST_CLAIMS = 32

#: Sets of a graph that are looked at, smallest first: beyond some 12 sides not all.
MOST_SETS = 512

#: Sides whose sums stand in one table, tables, and sums in each.
TABLE_SIDES = 5
TABLES = 3
SUMS = 32

#: An odd number that scatters: 2**64 over the golden ratio, as a signed integer.
SCATTER = -7046029254386353131


@kernel
def list_joint_claims(
    claim: Int32Array, near_first: Int32Array, near: NDArray[np.int16]
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """List the joint claims of (s, w) graphs; arguments as in :class:`.systems.Graphs`.

    Returns (s,) int32 the number of each system's graph, systems of equal graphs having one, and
    by graph (g + 1,) int32 and (c,) int32: graph k has the claims first[k]..first[k + 1] - 1.
    """
    n, w = claim.shape
    # Twice as many places as systems, rounded up to a power of two; -1 is a free one.
    size = 2
    while size < 2 * n:
        size *= 2
    places = np.full(size, -1, np.int32)
    graph = np.empty(n, np.int32)
    shown_by = np.empty(n, np.int32)
    first = np.zeros(n + 1, np.int32)
    claims = np.empty(16 * n + MOST_CLAIMS, np.int32)
    seen = np.zeros(1 << w, np.bool_)
    sets = np.empty((2, MOST_SETS), np.int32)
    likely = np.empty(MOST_CLAIMS, np.float64)
    count = 0
    for r in range(n):
        key = np.int64(0)
        for i in range(w):
            key = ((key >> 29) ^ key ^ (claim[r, i] + 1)) * SCATTER
        at = (key >> 32) & (size - 1)
        while places[at] >= 0:
            other = shown_by[places[at]]
            same = True
            for i in range(w):
                same &= claim[other, i] == claim[r, i]
            if same:
                break
            at = (at + 1) & (size - 1)
        if places[at] < 0:
            places[at] = count
            shown_by[count] = r
            if len(claims) < first[count] + MOST_CLAIMS:
                claims = np.concatenate((claims, np.empty(len(claims), np.int32)))
            own = claims[first[count] : first[count] + MOST_CLAIMS]
            found = _list_of_graph(claim[r], near_first, near, seen, sets, own, likely)
            count += 1
            first[count] = first[count - 1] + found
        graph[r] = places[at]
    return graph, first[: count + 1].copy(), claims[: first[count]].copy()


@kernel
def _list_of_graph(
    claim: Int32Array,
    near_first: Int32Array,
    near: NDArray[np.int16],
    seen: NDArray[np.bool_],
    sets: Int32Array,
    claims: Int32Array,
    likely: NDArray[np.float64],
) -> int:
    """Write the claims of one graph, those likeliest to be broken first; return how many.

    seen: (2**w,) bool, all False before and after; sets: (2, MOST_SETS) scratch; likely: as claims.
    """
    w = len(claim)
    joined = np.zeros(w, np.int32)
    for i in range(w):
        for k in range(near_first[claim[i]], near_first[claim[i] + 1]):
            joined[i] |= 1 << near[k]
    tail = 0
    for i in range(w):
        if joined[i] >> i & 1 == 0:
            sets[0, tail] = 1 << i
            sets[1, tail] = joined[i]
            seen[1 << i] = True
            tail += 1
    head = 0
    found = 0
    while head < tail:
        some = sets[0, head]
        around = sets[1, head]
        head += 1
        # Sides that ask for no neighbour more make the claim stronger; without them it is implied.
        whole = True
        n_some = 0
        n_around = 0
        for v in range(w):
            n_some += some >> v & 1
            n_around += around >> v & 1
            if (some | around) >> v & 1 or joined[v] >> v & 1 or joined[v] & some:
                continue
            whole &= joined[v] & ~around != 0
            # Two sets whose neighbours are apart imply the claim of both.
            if joined[v] & around and tail < sets.shape[1] and not seen[some | 1 << v]:
                seen[some | 1 << v] = True
                sets[0, tail] = some | 1 << v
                sets[1, tail] = around | joined[v]
                tail += 1
        if not whole or n_some < 2:
            continue
        # Needs are alike, so that sums grow with numbers, and scatter with their roots.
        margin = (n_around - n_some) / sqrt(n_around + n_some)
        at = found
        while at > 0 and likely[at - 1] > margin:
            at -= 1
        if at == len(claims):
            continue
        found = min(found + 1, len(claims))
        for k in range(found - 1, at, -1):
            claims[k] = claims[k - 1]
            likely[k] = likely[k - 1]
        claims[at] = around << MOST_SIDES | some
        likely[at] = margin
    for k in range(tail):
        seen[sets[0, k]] = False
    return found


@kernel(inline="always")
def sum_needs(need: Int32Array, sums: Int32Array) -> None:
    """Write what sets of five sides need together, for every five of these MOST_SIDES.

    sums: (TABLES * SUMS,), 0 at the empty sets. Loops of a fixed length are unrolled.
    """
    for table in range(TABLES):
        side = table * TABLE_SIDES
        at = table * SUMS
        sums[at + 1] = need[side]
        for k in range(2):
            sums[at + 2 + k] = sums[at + k] + need[side + 1]
        for k in range(4):
            sums[at + 4 + k] = sums[at + k] + need[side + 2]
        for k in range(8):
            sums[at + 8 + k] = sums[at + k] + need[side + 3]
        for k in range(16):
            sums[at + 16 + k] = sums[at + k] + need[side + 4]


@kernel(inline="always")
def is_refused(first: int, last: int, claims: Int32Array, sums: Int32Array) -> bool:
    """Is one of the claims first..last - 1 broken? sums: of :func:`sum_needs`."""
    for k in range(first, last):
        some = claims[k]
        around = some >> MOST_SIDES
        spare = (
            sums[around & 31] + sums[SUMS + (around >> 5 & 31)] + sums[2 * SUMS + (around >> 10)]
        )
        spare -= (
            sums[some & 31] + sums[SUMS + (some >> 5 & 31)] + sums[2 * SUMS + (some >> 10 & 31)]
        )
        if spare < 0:
            return True
    return False
