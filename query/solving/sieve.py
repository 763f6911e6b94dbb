"""A sieve for systems: orientations that two conditions refuse, eight at a time and unsolved.

A side of a pattern can be no shorter than its base length, and what it is wider than that its
neighbours must be together, since a polychord takes as much from one end as from the other:

    lengths_i >= base_i
    sum of lengths_j - lengths_i >= sum of base_j - base_i, over the sides j that i is joined to

The right-hand sides are the pattern's, the left-hand ones the boundary's: the first depends on the
side alone, the second on the side and its neighbours, a *claim*
(:class:`query.solving.systems.Graphs`). A class of 20,000 patterns of 12 sides has some 3,000 of
these, so that a query works all left-hand sides out once, and compares.

It compares *words*: 64-bit integers of eight bytes, a byte for each *lane*, which is a way in which
a pattern can see the boundary. The bytes hold v + 128 for a left-hand side v, cut off to 0..127.
Less a number of 0..127 in every byte, the highest bit of each says whether v is at least that
number, and nothing is borrowed from the byte above. Since claims may be below 0, both sides of the
second are one more. What the first says of two sides is looked up by both base lengths, cut off at
LONGEST_BASE. Cut off, more may pass, never less: what passes is not known to fit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel
from query.solving.systems import LONGEST_BASE, MOST_SURPLUS, Int16Array

#: Lanes in a word, and bits of each.
LANES = 8
BITS = 8

#: Words that are compared at once: 32 lanes, as many as 16 sides have. Rows of words are filled up
#: to a multiple.
GROUP = 4

#: 1 in every lane, and the highest bit of one.
ONES = 0x0101_0101_0101_0101
HIGHEST = 128


def mark_lanes(n_lanes: int) -> Int64Array:
    """(g,) words with the highest bit of each of so many lanes, g a multiple of GROUP."""
    marks = np.zeros(-(-n_lanes // (LANES * GROUP)) * GROUP * LANES, np.uint8)
    marks[:n_lanes] = HIGHEST
    return marks.view("<i8")


def pack_lengths(lengths: Int32Array) -> Int64Array:
    """(w, g) words of the (n, w) lengths that n lanes have; lanes that fill up have any."""
    n, w = lengths.shape
    lanes = np.full((w, len(mark_lanes(n)) * LANES), HIGHEST, np.uint8)
    lanes[:, :n] |= np.minimum(lengths.T, MOST_SURPLUS).astype(np.uint8)
    return lanes.view("<i8")


@kernel
def compare_pairs(words: Int64Array) -> Int64Array:
    """Compare the lengths of each two sides with all base lengths that they may have.

    words: (w, g) of :func:`pack_lengths`. Returns (ceil(w / 2), (LONGEST_BASE + 1)**2, g): the
    lanes in which sides 2 p and 2 p + 1 are as long as entry q of
    :class:`query.solving.systems.Systems.pairs` asks.
    """
    w, n = words.shape
    size = LONGEST_BASE + 1
    compared = np.empty(((w + 1) // 2, size * size, n), np.int64)
    for p in range(len(compared)):
        for q in range(size * size):
            for g in range(n):
                word = words[2 * p, g] - q // size * ONES
                # The last side may have none beside it.
                if 2 * p + 1 < w:
                    word &= words[2 * p + 1, g] - q % size * ONES
                compared[p, q, g] = word
    return compared


@kernel
def state_claims(
    lengths: Int32Array,
    claimant: Int16Array,
    near_first: Int32Array,
    near: Int16Array,
    claims: Int32Array,
    first: int,
    stated: NDArray[np.uint8],
) -> None:
    """Write the lanes (k, g * LANES) of those of the claims that have none yet, which are 0.

    lengths: (w, n) of the lanes; claimant to near: see :class:`query.solving.systems.Systems`.
    claims: (c,), some more than once. stated: the lanes of claims first..first + k - 1.
    """
    n = lengths.shape[1]
    spare = np.empty(n, np.int32)
    for q in claims:
        row = q - first
        if stated[row, 0] != 0:
            continue
        for lane in range(n):
            spare[lane] = -lengths[claimant[q], lane]
        for k in range(near_first[q], near_first[q + 1]):
            side = near[k]
            for lane in range(n):
                spare[lane] += lengths[side, lane]
        for lane in range(n):
            stated[row, lane] = HIGHEST + min(max(spare[lane] + 1, 0), MOST_SURPLUS)
        stated[row, n:] = HIGHEST


@kernel(inline="always")
def sift_system(
    row: int,
    pairs: NDArray[np.uint8],
    surplus: NDArray[np.uint8],
    claim: Int32Array,
    marks: Int64Array,
    compared: Int64Array,
    stated: Int64Array,
    left: Int64Array,
) -> bool:
    """Write the lanes (g,) in which the system of a row passes; return whether any does.

    pairs, surplus, claim: see :class:`query.solving.systems.Systems`. marks: of
    :func:`mark_lanes`; compared: of :func:`compare_pairs`; stated: of :func:`state_claims`.
    """
    passing = False
    w = surplus.shape[1]
    for g in range(0, len(marks), GROUP):
        a = marks[g]
        b = marks[g + 1]
        c = marks[g + 2]
        d = marks[g + 3]
        for p in range(pairs.shape[1]):
            q = pairs[row, p]
            a &= compared[p, q, g]
            b &= compared[p, q, g + 1]
            c &= compared[p, q, g + 2]
            d &= compared[p, q, g + 3]
        s = 0
        # Half of the claims refuse most of what all do.
        while s < w and a | b | c | d != 0:
            last = w if s > 0 else (w + 1) // 2
            while s < last:
                q = claim[row, s]
                least = np.int64(surplus[row, s]) * ONES
                a &= stated[q, g] - least
                b &= stated[q, g + 1] - least
                c &= stated[q, g + 2] - least
                d &= stated[q, g + 3] - least
                s += 1
        left[g] = a
        left[g + 1] = b
        left[g + 2] = c
        left[g + 3] = d
        passing |= a | b | c | d != 0
    return passing


@kernel(inline="always")
def has_lane(left: Int64Array, lane: int) -> bool:
    """Is the lane among those left?"""
    return (left[lane // LANES] >> (BITS * (lane % LANES) + BITS - 1)) & 1 != 0


@kernel(inline="always")
def drop_lane(left: Int64Array, lane: int) -> None:
    """Take a lane that is left from those left."""
    left[lane // LANES] ^= np.int64(1) << (BITS * (lane % LANES) + BITS - 1)
