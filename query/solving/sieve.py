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

from patterndb.core.halfedge import Int32Array, Int64Array
from query.solving.systems import MOST_SURPLUS

#: Lanes in a word, and bits of each.
LANES = 8

#: Words that are compared at once: 32 lanes, as many as 16 sides have. Rows of words are filled up
#: to a multiple.
GROUP = 4

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
