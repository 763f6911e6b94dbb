"""The marked pattern that fills a boundary with the fewest irregular vertices.

A look-up over a whole table, fast enough to be called for every part of a construction; the
pattern is not expanded. :class:`MarkedIndex` holds the rows that can come first,
:func:`find_best_marked` looks through them: ``find_best_row`` finds the first row
that fits, ``spread_strand_widths`` how wide its strands are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.relaxed.bestmarked import colours, find_best_row, spread_strand_widths
from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary
from query.cancellation import NEVER, CancelFlag
from query.errors import InvalidQueryError
from query.orientation import Orientation
from query.relaxed.corner_placement import MarkedClass, load_marked_family
from query.solving.systems import Int16Array

#: Irregular vertices on the boundary that a query allows unless told otherwise. With this
#: many the table of the complete family loses nothing.
BOUNDARY_CAP = 3

#: The orientations of a table's systems are told apart in one 64-bit number.
MOST_SIDES = 31


@dataclass(frozen=True, slots=True, eq=False)
class MarkedIndex:
    """The rows of a table that can come first, one of each kind.

    Rows of one system with the same counts, interior irregular vertices and unmarked corners
    answer the same boundaries: only the first of them is kept, u in all.

    marked:     the table.
    row:        (u,) int32 row of the table, ordered by interior irregular vertices.
    start:      (v + 2,) int64; the rows with i irregular vertices are start[i]..start[i + 1].
    unmarked:   (u,) int32 corners without a mark.
    signature:  (u,) int32.
    counts:     (u, N) uint8 quads at the marks, in signature order.
    convex, reflex: (u,) int32 how many of them are 1, and 3.
    class_start: (s + 1,) int64; class_i, class_j, class_n: int32, the classes of strands of
                each signature, joined to the sides i <= j.
    component, colour: (s, N) int16 of the two-colouring of each graph.
    """

    marked: MarkedClass
    row: Int32Array
    start: NDArray[np.int64]
    unmarked: Int32Array
    signature: Int32Array
    counts: NDArray[np.uint8]
    convex: Int32Array
    reflex: Int32Array
    class_start: NDArray[np.int64]
    class_i: Int32Array
    class_j: Int32Array
    class_n: Int32Array
    component: Int16Array
    colour: Int16Array

    @property
    def base(self) -> Int32Array:
        """(s, N) int32 the least length of every side of each signature."""
        return self.marked.lengths

    @classmethod
    def of(cls, marked: MarkedClass, rows: NDArray[np.bool_] | None = None) -> MarkedIndex:
        """rows: (r,) bool, the rows of the table that may be used (default: all).

        Patterns that need a wide polychord to be a mesh (see ``PatternTable.mesh``) are left
        out. Raises InvalidQueryError for more than MOST_SIDES sides.
        """
        n = marked.n_sides
        if n > MOST_SIDES:
            raise InvalidQueryError(f"{n} sides are too many to look up; at most {MOST_SIDES}")
        usable = marked.patterns.mesh[marked.pattern]
        kept = np.flatnonzero(usable if rows is None else usable & rows)
        inside = marked.n_irregular[kept]
        counts = marked.counts_in_signature_order()[kept]
        kinds = np.column_stack([inside, marked.n_unmarked[kept], marked.signature[kept], counts])
        _, first = np.unique(kinds, axis=0, return_index=True)
        first = first[np.lexsort((first, inside[first]))]
        kept, inside, counts = kept[first], inside[first], counts[first]
        upper = np.triu(marked.joins)
        owner, class_i, class_j = np.nonzero(upper)
        class_start = np.searchsorted(owner, np.arange(len(upper) + 1)).astype(np.int64)
        ends = class_i.astype(np.int32), class_j.astype(np.int32)
        component, colour = colours(class_start, *ends, n)
        return cls(
            marked=marked,
            row=kept.astype(np.int32),
            start=np.searchsorted(inside, np.arange(inside.max(initial=0) + 2)).astype(np.int64),
            unmarked=marked.n_unmarked[kept],
            signature=marked.signature[kept],
            counts=counts,
            convex=(counts == 1).sum(axis=1).astype(np.int32),
            reflex=(counts == 3).sum(axis=1).astype(np.int32),
            class_start=class_start,
            class_i=ends[0],
            class_j=ends[1],
            class_n=upper[owner, class_i, class_j].astype(np.int32),
            component=component,
            colour=colour,
        )


#: The indexes in use, by number of sides, and whether they are of a closed side.
LOADED: dict[tuple[int, bool], MarkedIndex] = {}


def load_family_index(
    n_sides: int, *, free: bool = False, cancelled: CancelFlag = NEVER
) -> MarkedIndex:
    """The index of :func:`query.relaxed.corner_placement.load_marked_family`."""
    key = (n_sides, free)
    if key not in LOADED:
        LOADED[key] = MarkedIndex.of(load_marked_family(n_sides, free=free, cancelled=cancelled))
    return LOADED[key]


@dataclass(frozen=True, slots=True)
class BestMarked:
    """What a marked pattern makes of a boundary.

    row:         of the table.
    orientation: side i of the boundary is the marked pattern's side rotation + i, or,
                 mirrored, its side rotation - i read backwards.
    strand_widths: width of each strand; those that join the same two sides as even as can be.
    n_irregular: irregular vertices in all.
    n_irregular_boundary: those on the boundary.
    """

    row: int
    orientation: Orientation
    strand_widths: tuple[int, ...]
    n_irregular: int
    n_irregular_boundary: int


def find_best_marked(
    index: MarkedIndex,
    boundary: Boundary,
    *,
    cap: int = BOUNDARY_CAP,
    most: int | None = None,
) -> BestMarked | None:
    """The fill of a boundary with the fewest irregular vertices that the table has.

    Among equals the one with the fewest on the boundary, then the first row. cap: at most so
    many irregular vertices on the boundary; most: so many in all (None: any number). A closed
    side is for a free table, all else for the others. Raises InvalidQueryError for a boundary
    that is not of the table's number of sides.
    """
    marked = index.marked
    closed = boundary.n_sides == 0
    if len(boundary.lengths) != marked.n_sides or closed != marked.free:
        raise InvalidQueryError(
            f"a boundary of {boundary.n_sides} sides in a table for "
            f"{0 if marked.free else marked.n_sides}; use the table of its own number"
        )
    counts = np.array((2,) if closed else boundary.corner_counts, np.int32)
    lengths = np.array(boundary.lengths, np.int32)
    at, o, total, on_boundary, slack = find_best_row(index, lengths, counts, cap, most)
    if at < 0:
        return None
    row = int(index.row[at])
    signature = index.signature[at]
    classes = slice(index.class_start[signature], index.class_start[signature + 1])
    widths = spread_strand_widths(
        (
            marked.label[marked.label_start[row] : marked.label_start[row + 1]],
            int(marked.rotation[row]),
            bool(marked.reflected[row]),
            marked.n_sides,
        ),
        (index.class_i[classes], index.class_j[classes], index.class_n[classes]),
        slack,
    )
    return BestMarked(
        row=row,
        orientation=_of_row(marked, row, o),
        strand_widths=tuple(widths.tolist()),
        n_irregular=total,
        n_irregular_boundary=on_boundary,
    )


def _of_row(marked: MarkedClass, row: int, o: int) -> Orientation:
    """The orientation of a row whose signature lies in orientation number ``o``."""
    n = marked.n_sides
    mirrored, rotation = o >= n, o % n
    turn = int(marked.rotation[row])
    if marked.reflected[row]:
        return Orientation(not mirrored, (turn - rotation) % n)
    return Orientation(mirrored, (turn + rotation) % n)
