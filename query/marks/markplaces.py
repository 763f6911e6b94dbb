"""Where the corners of a boundary may fall on a pattern: every choice of marks within bounds.

A mark lies on a boundary vertex, or at a *slot* inside a boundary edge, where it parts the
polychord that crosses the edge into *strands*. The slots of a polychord are ordered across it; its
two ends see the same order, reversed. On one polychord with m marks, any sequence of slots is a
choice, each with a mark at the one end, the other, or both: no other partings matter.

Each choice of marks becomes one record; :mod:`query.marks.marked` makes a table of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array

#: Bits of an edge's slots in one number: more marks than that on one polychord are refused.
MOST_SLOTS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Partings:
    """All ways to set up to m marks into the slots of one polychord, fewest marks first.

    marks: (a,) int32 how many marks; parting 0 has none.
    slots: (a,) int32 how many slots; there is one strand more.
    near, far: (a,) int32 bit s is set where slot s has a mark at the polychord's first end,
        and at its other end; slots are counted across it as its first end sees them.
    """

    marks: Int32Array
    slots: Int32Array
    near: Int32Array
    far: Int32Array

    @classmethod
    def up_to(cls, most: int) -> Partings:
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
