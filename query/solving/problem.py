"""The width problem: how wide the polychords of patterns are to be so that they meet a boundary.

Widths are whole numbers of 1 and more; along every side they add up to its edges (Marcias et al.
2015, section 4). :func:`build_width_problem` states a boundary and strokes in the patterns' own
terms, once for each orientation; :class:`query.solving.widths.WidthSolver` solves it.

A stroke asks for a strand of quads that leaves side a at edge i and side b at edge j, give or take
the tolerance K. If polychord q carries it, q is a strand 1 wide between two parts of any width
>= 0: x_q = u + 1 + w. The strand cuts side a in two *pieces*, of i + d and L_a - i - 1 - d edges
with \\|d\\| <= K, and side b likewise. So strokes only cut sides: the rest is the same matching as
without them, with pieces in the place of sides, and classes of polychords that join pieces. A
tolerance is one more node, of slack 2 K, joined to the two pieces of its cut: what it gives to one
it does not give to the other. Several strokes may lie on one polychord, in any order; its two ends
see that order reversed. Every assignment of strokes to strands is tried.

Source: Marcias et al. 2015, section 4, "Edge-flow constraints". Differs from the paper: one system
of a matching instead of an integer program per polychord, every assignment of strokes to
polychords is tried, and each of several strokes has a strand of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary
from query.orientation import Orientation, list_orientations, list_sides_seen
from query.solving.systems import Int16Array
from query.stroke import Stroke

#: What an edge off a stroke's end counts: more than any sum of squares. Perimeters are at most
#: 2,000, so the squares add up to at most 1,000**2, each times a weight of at most MAX_WEIGHT.
OFF = 1 << 28

#: The weight of a square stays within 1..MAX_WEIGHT.
MAX_WEIGHT = 255

#: The weight of a square where all edges are equally long: fine enough to tell proportions.
EVEN_WEIGHT = 16

#: Columns of a stroke as a pattern sees it: side and edge of one end, and of the other.
STROKE_COLUMNS = 4


@dataclass(frozen=True, slots=True, eq=False)
class WidthProblem:
    """A boundary and strokes, once for each of o orientations of n sides.

    lengths: (o, n) int32 edges of every side in the pattern's order.
    weights: (o, n, n) int32, what the square of a width counts between two sides.
    strokes: (o, s, 4) int32 side, edge, side, edge of the strokes that end on the boundary, in
             the pattern's order.
    tolerance: K >= 0, edges that a strand's end may be off.
    """

    lengths: Int32Array
    weights: Int32Array
    strokes: Int32Array
    tolerance: int

    @classmethod
    def of_lengths(
        cls, lengths: Int32Array, strokes: Int32Array | None = None, tolerance: int = 0
    ) -> WidthProblem:
        """One orientation alone: lengths (n,) and strokes (s, 4), squares of equal weight."""
        n = len(lengths)
        if strokes is None:
            strokes = np.zeros((0, STROKE_COLUMNS), np.int32)
        return cls(lengths[None], np.ones((1, n, n), np.int32), strokes[None], tolerance)

    @property
    def has_strokes(self) -> bool:
        """Are there strokes that end on the boundary?"""
        return self.strokes.shape[1] > 0


def build_width_problem(
    boundary: Boundary, strokes: Sequence[Stroke] = (), tolerance: int = 0
) -> WidthProblem:
    """State a boundary and strokes in every orientation; see :mod:`query.orientation`."""
    n = max(boundary.n_sides, 1)
    sides = list_sides_seen(n)
    lengths = np.array(boundary.lengths, np.int32)
    weights = weigh_sides(boundary)
    return WidthProblem(
        lengths=np.ascontiguousarray(lengths[sides]),
        weights=np.ascontiguousarray(weights[sides[:, :, None], sides[:, None, :]]),
        strokes=np.stack([_orient_strokes(strokes, boundary, o) for o in list_orientations(n)]),
        # An end that may be off by a whole side may be anywhere.
        tolerance=min(tolerance, max(boundary.lengths)),
    )


def _orient_strokes(
    strokes: Sequence[Stroke], boundary: Boundary, orientation: Orientation
) -> Int32Array:
    """(s, 4) int32 side, edge, side, edge of the strokes in the pattern's own order.

    Loops are left out: no side sees them.
    """
    n = max(boundary.n_sides, 1)
    rows: list[list[int]] = []
    for stroke in strokes:
        if stroke.start is None or stroke.end is None:
            continue
        row: list[int] = []
        for side, edge in (stroke.start, stroke.end):
            if orientation.mirrored:
                row += [(orientation.rotation - side) % n, boundary.lengths[side] - 1 - edge]
            else:
                row += [(orientation.rotation + side) % n, edge]
        rows.append(row)
    return np.array(rows, np.int32).reshape(-1, STROKE_COLUMNS)


def weigh_sides(boundary: Boundary) -> Int32Array:
    """(n, n) int32: what the square of a width counts for strands between two sides.

    1 where the boundary has no points. Else in proportion to the sum of the squares of the
    sides' edge lengths: then the most even widths are those that take equal lengths of the
    boundary, not equal numbers of edges.
    """
    n = len(boundary.lengths)
    if boundary.points is None:
        return np.ones((n, n), np.int32)
    steps = np.linalg.norm(np.roll(boundary.points, -1, axis=0) - boundary.points, axis=1)
    starts = np.array(boundary.side_starts)
    squares = (np.add.reduceat(steps, starts[:-1]) / np.diff(starts)) ** 2
    sums = squares[:, None] + squares[None, :]
    weights = np.rint(EVEN_WEIGHT * sums / (2 * squares.mean()))
    return np.clip(weights, 1, MAX_WEIGHT).astype(np.int32)


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """The boundary labels of many patterns, as the width problem needs them.

    n_sides: at least 1.
    words:   int16, for every row its label as a word: for every side its length, then the
             strand that crosses each edge (:mod:`patterndb.core.label`).
    start:   (r + 1,) int64, where each word begins.
    """

    n_sides: int
    words: Int16Array
    start: NDArray[np.int64]

    @classmethod
    def of_pattern(cls, label: Sequence[Sequence[int]]) -> Labels:
        """One row, of a label: per side, the open polychord that crosses each edge."""
        word = np.array([x for side in label for x in (len(side), *side)], np.int16)
        return cls(len(label), word, np.array([0, len(word)], np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class BestWidths:
    """The best widths of some rows, best first: at most ``keep`` of each.

    row:    (f,) int64, index into the rows asked for, ascending.
    key:    (f,) int64 the weighted sum of the squared widths, and OFF for each edge by which
            strands miss the strokes.
    orientation: (f,) int32.
    widths: (f, w) int32, of the strands in label order, 0 beyond the last.
    """

    row: NDArray[np.int64]
    key: NDArray[np.int64]
    orientation: Int32Array
    widths: Int32Array
