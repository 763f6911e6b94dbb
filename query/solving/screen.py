"""Which orientations of a system can be ruled out at a glance, four of them at once.

A *word* is a 64-bit integer that stands for four small ones, a *lane* each: the sum of
v_l * 2**(16 l) over the lanes l = 0..3. Words add and subtract lane by lane, whatever the
signs. With SIGNS added every v_l in -2**15..2**15 - 1 becomes a 16-bit field of its own,
whose highest bit says whether v_l >= 0. So every linear inequality costs one addition more
than it has terms, for four orientations together.

The bits of ``refused`` at SIGNS say which lanes have no solution; its others mean nothing.
Perimeters are at most 2,000 (:mod:`query.boundary`), so that no sum below leaves its lane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel
from query.solving.systems import Int16Array

#: Orientations in a word, and bits of each.
LANES = 4
BITS = 16

#: 1 in every lane, and the highest bit of every field.
ONES = 0x0001_0001_0001_0001
SIGNS = -0x7FFF_7FFF_7FFF_8000


def words(rows: Int32Array) -> Int64Array:
    """(ceil(o / 4), w) int64 words of the (o, w) rows, filled up with lanes of -1.

    No length is negative, so that a lane that fills up is refused.
    """
    o, w = rows.shape
    padded = np.full((-(-o // LANES) * LANES, w), -1, np.int64)
    padded[:o] = rows
    weights = np.int64(1) << (BITS * np.arange(LANES, dtype=np.int64))
    return np.ascontiguousarray((padded.reshape(-1, LANES, w) * weights[:, None]).sum(axis=1))


@kernel
def negative(word: int) -> int:
    """At SIGNS: the lanes below 0."""
    return ~(word + SIGNS)


@kernel
def lane_of(word: int, lane: int) -> int:
    """The value of one lane."""
    return (((word + SIGNS) >> (BITS * lane)) & 0xFFFF) - 0x8000


@kernel
def is_refused(refused: int, lane: int) -> bool:
    """Is the lane marked?"""
    return (refused >> (BITS * lane + BITS - 1)) & 1 != 0


@kernel(inline="always")
def screen(
    row: int,
    base: Int16Array,
    looped: NDArray[np.bool_],
    component: Int16Array,
    colour: Int16Array,
    parity: NDArray[np.bool_],
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
    lengths: Int64Array,
    slack: Int64Array,
    reach: Int64Array,
    refused: Int64Array,
) -> bool:
    """Write the slack of every side, and refuse the lanes that need no closer look.

    Refused is where a side is too short, where parity forbids (see
    :func:`query.solving.colouring.balanced`), and where a side asks for more than its neighbours
    have together. base to parity, first to class_j: see :class:`query.solving.systems.Systems`,
    of which this is the system in this row. lengths, slack: (g, w) words; reach: (w,) scratch;
    refused: (g,), added to. Returns whether any lane is left.
    """
    n_words, w = lengths.shape
    left = False
    for g in range(n_words):
        bad = refused[g]
        for s in range(w):
            word = lengths[g, s] - base[row, s] * ONES
            slack[g, s] = word
            reach[s] = -word
            bad |= negative(word)
        if bad & SIGNS != SIGNS and parity[row]:
            bad |= _refused_by_parity(component[row], colour[row], slack, g)
        if bad & SIGNS != SIGNS:
            for k in range(first[row], first[row + 1]):
                i = class_i[k]
                j = class_j[k]
                reach[i] += slack[g, j]
                reach[j] += slack[g, i]
            for s in range(w):
                if not looped[row, s]:
                    bad |= negative(reach[s])
            left |= bad & SIGNS != SIGNS
        refused[g] = bad
    return left


@kernel(inline="always")
def _refused_by_parity(component: Int16Array, colour: Int16Array, slack: Int64Array, g: int) -> int:
    """The lanes of word g whose slack some component cannot take."""
    w = slack.shape[1]
    bad = 0
    for root in range(w):
        if component[root] != root:
            continue
        word = 0
        for s in range(root, w):
            if component[s] == root:
                word += -slack[g, s] if colour[s] < 0 else slack[g, s]
        if colour[root] == 0:
            # The lowest bit of every field moves to its highest.
            bad |= (word + SIGNS) << (BITS - 1)
        else:
            bad |= negative(word) | negative(-word)
    return bad


@kernel(inline="always")
def refuse_cut(
    sides: Int32Array, n_sides: int, neighbour: Int32Array, slack: Int64Array, refused: Int64Array
) -> None:
    """Refuse the lanes in which the first sides ask for more than their neighbours have.

    sides: (>= n_sides,) int32; neighbour: (w,) int32, >= 0 at the sides that any of these
    is joined to. What one orientation fails by, others of the same system often do.
    """
    n_words, w = slack.shape
    for g in range(n_words):
        if refused[g] & SIGNS == SIGNS:
            continue
        word = 0
        for at in range(n_sides):
            word -= slack[g, sides[at]]
        for s in range(w):
            if neighbour[s] >= 0:
                word += slack[g, s]
        refused[g] |= negative(word)
