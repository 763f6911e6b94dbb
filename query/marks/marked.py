"""Marked patterns: patterns with the places where a boundary's corners fall.

A relaxed match of a pattern is a strict match of a marked pattern: its marks part its
boundary into N sides, and its strands take the part of polychords. See :mod:`query.marks.strands`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.label import split_word
from query.marks.patterntable import PatternTable


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
