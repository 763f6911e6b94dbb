"""Corner placement: where the corners of a boundary may fall on patterns.

A relaxed match of a pattern is a strict match of a *marked* pattern: marks, on which corners fall,
part its boundary into N sides, and its strands take the part of polychords. A mark lies on a
boundary vertex, or at a *slot* inside a boundary edge, where it parts the polychord that crosses
the edge into *strands*. The slots of a polychord are ordered across it; its two ends see the same
order, reversed. On one polychord with m marks, any sequence of slots is a choice, each with a mark
at the one end, the other, or both: no other sites matter.

:func:`mark_patterns` makes a table of marked patterns from any set of patterns,
:func:`load_marked_family` from the complete family.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.relaxed.corner_placement import list_records
from patterndb.core.halfedge import Int32Array
from patterndb.core.label import split_word
from patterndb.core.packing import unpack_many
from query.cancellation import NEVER, CancelFlag, raise_if_cancelled
from query.errors import InvalidQueryError
from query.relaxed.family import CACHE, MOST_QUADS, PatternTable, load_family

#: Bits of an edge's slots in one number: more marks than that on one polychord are refused.
MOST_SLOTS = 12


@dataclass(frozen=True, slots=True, eq=False)
class CornerSites:
    """All ways to set up to m marks into the slots of one polychord, fewest marks first.

    marks: (a,) int32 how many marks; row 0 has none.
    slots: (a,) int32 how many slots; there is one strand more.
    near, far: (a,) int32 bit s is set where slot s has a mark at the polychord's first end,
        and at its other end; slots are counted across it as its first end sees them.
    """

    marks: Int32Array
    slots: Int32Array
    near: Int32Array
    far: Int32Array

    @classmethod
    def up_to(cls, most: int) -> CornerSites:
        """Those with at most ``most`` marks: 2.41**most of them, about."""
        rows = [(0, 0, 0, 0)]
        level = rows
        for s in range(most):
            level = [
                (marks + more, s + 1, near | a << s, far | b << s)
                for marks, _, near, far in level
                for more, a, b in ((1, 1, 0), (1, 0, 1), (2, 1, 1))
                if marks + more <= most
            ]
            rows = rows + level
        columns = np.array(sorted(rows), np.int32).T.copy()
        return cls(columns[0], columns[1], columns[2], columns[3])


# Columns of a record's head; the counts at its N marks follow, then the upper triangle of
# the strands that join its sides, row by row, in the order of its system.
PATTERN = 0
COST = 1
UNMARKED = 2  # corners of the pattern without a mark
RELAXED = 3  # 0 where the marks are the pattern's corners
PERIMETER = 4  # strand ends
START_EDGE = 5
START_STRAND = 6
ROTATION = 7
REFLECTED = 8
STRANDS = 9
HEAD = 10


@dataclass(frozen=True, slots=True, eq=False)
class MarkedClass:
    """r marked patterns of N sides: all that a boundary with N corners may be matched with.

    Rows are in order of cost, then those whose marks are the pattern's own corners, then
    base perimeter, pattern id, and label. A choice of marks and its images under the
    pattern's symmetries are one row, begun at any mark: a query tries all 2N orientations.

    n_sides:     N >= 1, the number of marks.
    free:        are these for a boundary without corners? Then N = 1, and the one mark is
                 where the boundary's vertex 0 falls, a flat place (2 quads) for choice.
    most:        cost, plus the marks whose count is not 1 (2 where free), is at most this.
    patterns:    the different patterns.
    pattern:     (r,) int32 row of ``patterns``.
    cost:        (r,) int32 irregular interior vertices, and the pattern's corners that have
                 no mark. Against a boundary each mark whose count is not what its corner
                 asks for adds one.
    n_unmarked:  (r,) int32 of the cost, the corners without a mark.
    strict:      (r,) bool: are the marks the pattern's corners, all of them and no others?
    counts:      (r, N) uint8 quads at each mark in the expanded pattern: 1 at a convex
                 corner, 2 at a flat vertex or a slot, 3 and more at a reflex corner. Mark
                 s is where side s begins.
    label, label_start: the word (see :mod:`patterndb.core.label`) of row i is
                 ``label[label_start[i]:label_start[i + 1]]``, int16 and (r + 1,) int64.
                 Strands are numbered in order from mark 0.
    strand_chord, strand_start: polychord of each strand of row i, in the pattern's label
                 order, ``strand_chord[strand_start[i]:strand_start[i + 1]]``, int16 and
                 (r + 1,) int64. The polychord is as wide as its strands together.
    start_edge, start_strand: (r,) int32 where mark 0 lies: on that edge of the pattern's
                 boundary, from its corner 0 on, after that many strands; 0 at the vertex
                 where the edge begins.
    signature:   (r,) int32 row of ``lengths`` and ``joins``.
    rotation, reflected: (r,) int32 and bool; side i of the signature is side rotation + i,
                 or, reflected, side rotation - i read backwards.
    lengths:     (s, N) int32 strand ends on each side of a signature.
    joins:       (s, N, N) int32 strands that join two sides of a signature, symmetric; one
                 with both ends on side i counts once in entry (i, i).
    """

    n_sides: int
    free: bool
    most: int
    patterns: PatternTable
    pattern: Int32Array
    cost: Int32Array
    n_unmarked: Int32Array
    strict: NDArray[np.bool_]
    counts: NDArray[np.uint8]
    label: NDArray[np.int16]
    label_start: NDArray[np.int64]
    strand_chord: NDArray[np.int16]
    strand_start: NDArray[np.int64]
    start_edge: Int32Array
    start_strand: Int32Array
    signature: Int32Array
    rotation: Int32Array
    reflected: NDArray[np.bool_]
    lengths: Int32Array
    joins: Int32Array

    def __len__(self) -> int:
        return len(self.pattern)

    @property
    def n_irregular(self) -> Int32Array:
        """(r,) int32 irregular interior vertices."""
        return self.cost - self.n_unmarked

    def sides(self, row: int) -> list[list[int]]:
        """The strands along every side, counter-clockwise."""
        word = self.label[self.label_start[row] : self.label_start[row + 1]]
        return split_word(word, self.n_sides)

    def chords(self, row: int) -> NDArray[np.int16]:
        """(n,) int16 polychord of each strand."""
        return self.strand_chord[self.strand_start[row] : self.strand_start[row + 1]]

    def counts_in_signature_order(self) -> NDArray[np.uint8]:
        """(r, N) uint8 ``counts`` where mark s is where side s of the signature begins."""
        s = np.arange(self.n_sides)
        turn = self.rotation[:, None].astype(np.int64)
        # A side read backwards begins where the next one does.
        mark = np.where(self.reflected[:, None], turn + 1 - s, turn + s) % self.n_sides
        return np.take_along_axis(self.counts, mark, axis=1)

    def within(self, valence: tuple[int, int]) -> NDArray[np.bool_]:
        """(r,) bool: do all interior vertices have between so many quads?"""
        least, most = valence
        ok = (self.patterns.min_valence >= least) & (self.patterns.max_valence <= most)
        return ok[self.pattern]


#: Raise it whenever a table of the same parameters comes out another way.
VERSION = 3

#: The marked families in use, by their parameters.
LOADED: dict[tuple[int, int, int, bool], MarkedClass] = {}


def mark_patterns(
    patterns: PatternTable,
    n_sides: int,
    *,
    most: int = 4,
    free: bool = False,
    cancelled: CancelFlag = NEVER,
) -> MarkedClass:
    """Every marked pattern of ``n_sides`` sides within a cost.

    patterns: those that may be marked. most: with convex corners all round a row costs at
    most that many irregular vertices, of the interior and the boundary together. free: for
    one closed side; ``n_sides`` is 1 then, and the mark asks for 2 quads. Raises
    InvalidQueryError for numbers that mean nothing, QueryCancelledError once ``cancelled`` is set.
    """
    _check(n_sides, most, free)
    patterns = patterns.take(np.flatnonzero(patterns.cost <= most))
    return _from_arrays(n_sides, most, free, _make(patterns, n_sides, most, free, cancelled))


def load_marked_family(
    n_sides: int,
    *,
    most: int = 4,
    valence: int = 5,
    free: bool = False,
    cancelled: CancelFlag = NEVER,
) -> MarkedClass:
    """:func:`mark_patterns` of a complete family, kept in the user's cache folder."""
    _check(n_sides, most, free)

    def make() -> dict[str, NDArray[Any]]:
        family = load_family(most, valence, cancelled=cancelled)
        return _make(family, n_sides, most, free, cancelled)

    key = (n_sides, most, valence, free)
    if key not in LOADED:
        kind = f"{n_sides}-free" if free else f"{n_sides}"
        what = f"marked-{VERSION}-{most}-{valence}-{MOST_QUADS}-{kind}"
        LOADED[key] = _from_arrays(n_sides, most, free, CACHE.find_or_make(what, make))
    return LOADED[key]


def _check(n_sides: int, most: int, free: bool) -> None:
    if n_sides < 1 or (free and n_sides != 1) or not 0 <= most <= MOST_SLOTS:
        raise InvalidQueryError(
            f"marked patterns need n_sides >= 1, or 1 where free (got {n_sides}), and most in "
            f"0..{MOST_SLOTS} (got {most}); a closed side is n_sides=1, free=True"
        )


def _make(
    patterns: PatternTable, n_sides: int, most: int, free: bool, cancelled: CancelFlag
) -> dict[str, NDArray[Any]]:
    """What :func:`_from_arrays` takes: the rows, sorted, and their patterns."""
    symbols, offsets = unpack_many(patterns.codes)
    head, labels, chords = list_records(
        (symbols.astype(np.uint16), offsets, patterns.n_irregular, patterns.n_reflex),
        n_sides,
        most,
        free,
        CornerSites.up_to(n_sides if free else min(most, n_sides)),
        cancelled,
    )
    raise_if_cancelled(cancelled)
    label_size = n_sides + 2 * head[:, STRANDS]
    order = np.lexsort(
        (
            _rank(labels, label_size),
            patterns.ids[head[:, PATTERN]],
            head[:, PERIMETER],
            head[:, RELAXED],
            head[:, COST],
        )
    )
    label = _gather(labels, label_size, order)
    chord = _gather(chords, head[:, STRANDS], order)
    head = head[order]
    used, head[:, PATTERN] = np.unique(head[:, PATTERN], return_inverse=True)
    # Rows as single items: numpy sorts these much faster than rows of numbers.
    upper = np.ascontiguousarray(head[:, HEAD + n_sides :].astype(">u2"))
    items = upper.view(np.dtype((np.void, upper.itemsize * upper.shape[1]))).ravel()
    _, first, signature = np.unique(items, return_index=True, return_inverse=True)
    return {
        "head": np.ascontiguousarray(head[:, : HEAD + n_sides]),
        "label": label,
        "strand_chord": chord,
        "systems": upper[first].astype(np.int32),
        "signature": signature.ravel().astype(np.int32),
        **patterns.take(used.astype(np.int64)).to_arrays(),
    }


def _from_arrays(
    n_sides: int, most: int, free: bool, arrays: Mapping[str, NDArray[Any]]
) -> MarkedClass:
    head, systems = arrays["head"], arrays["systems"]
    n = n_sides
    joins = np.zeros((len(systems), n, n), np.int32)
    i, j = np.triu_indices(n)
    joins[:, i, j] = systems
    joins[:, j, i] = systems
    # A strand with both ends on one side counts once in joins and twice in its length.
    lengths = joins.sum(axis=2) + joins[:, np.arange(n), np.arange(n)]
    return MarkedClass(
        n_sides=n,
        free=free,
        most=most,
        patterns=PatternTable.from_arrays(arrays),
        pattern=head[:, PATTERN].copy(),
        cost=head[:, COST].copy(),
        n_unmarked=head[:, UNMARKED].copy(),
        strict=head[:, RELAXED] == 0,
        counts=head[:, HEAD:].astype(np.uint8),
        label=arrays["label"],
        label_start=_starts(n + 2 * head[:, STRANDS]),
        strand_chord=arrays["strand_chord"],
        strand_start=_starts(head[:, STRANDS]),
        start_edge=head[:, START_EDGE].copy(),
        start_strand=head[:, START_STRAND].copy(),
        signature=arrays["signature"],
        rotation=head[:, ROTATION].copy(),
        reflected=head[:, REFLECTED] != 0,
        lengths=lengths.astype(np.int32),
        joins=joins,
    )


def _starts(sizes: NDArray[Any]) -> NDArray[np.int64]:
    return np.r_[0, np.cumsum(sizes)].astype(np.int64)


def _rank(flat: NDArray[Any], sizes: NDArray[Any]) -> NDArray[np.int64]:
    """The rank of each row of a ragged array, equal rows having one rank."""
    cuts = _starts(sizes).tolist()
    rows = [tuple(flat[a:b].tolist()) for a, b in pairwise(cuts)]
    rank = {row: i for i, row in enumerate(sorted(set(rows)))}
    return np.array([rank[row] for row in rows], np.int64)


def _gather(flat: NDArray[Any], sizes: NDArray[Any], order: NDArray[np.int64]) -> NDArray[Any]:
    """The rows of a ragged array in another order."""
    start = _starts(sizes)
    moved = sizes[order]
    first = np.repeat(start[order] - _starts(moved)[:-1], moved)
    return flat[first + np.arange(len(flat))]
