"""Reflex cuts: chords that take a reflex corner away.

A side that ends at a reflex corner is prolonged through it by a chord to an inner vertex
of another side. The corner becomes convex in the one part and flat in the other, the
chord's far end convex in both: the cut itself costs no irregular vertex.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from patterndb._native.query.construct.reflex_cuts import list_prolongations
from patterndb.core.halfedge import Int64Array
from query.boundary import MAX_PERIMETER, Boundary, CornerKind


class Prolongation(NamedTuple):
    """A chord of ``length`` edges from vertex ``start`` of the outline, a reflex corner, to
    vertex ``end``; left and right are the outlines of its sides, the left one's beginning
    ``turn`` vertices on. guess: irregular vertices of both, roughly."""

    guess: float
    start: int
    end: int
    length: int
    turn: int
    left: Boundary
    right: Boundary


def find_prolongations(boundary: Boundary, most: int) -> list[Prolongation]:
    """The cuts that promise fewest irregular vertices, at most ``most``, best first.

    Of the cuts between one corner and one side, prolonging the same side, only the best.
    """
    lengths = np.array(boundary.lengths, np.int64)
    counts = np.array(boundary.corner_counts, np.int64)
    rows, guess = list_prolongations(lengths, counts, MAX_PERIMETER)
    order = np.argsort(guess, kind="stable")[:most]
    return [_prolongation(boundary, rows[r], float(guess[r])) for r in order]


def _prolongation(boundary: Boundary, row: Int64Array, guess: float) -> Prolongation:
    k, back, far, w, length = row.tolist()
    lengths = boundary.lengths[k:] + boundary.lengths[:k]
    corners = boundary.corners[k:] + boundary.corners[:k]
    inner = sum(lengths[:far])
    start = boundary.side_starts[k]
    one: CornerKind = "convex"
    left_sides, right_sides = [*lengths[:far], w], [lengths[far] - w, *lengths[far + 1 :]]
    left_corners, right_corners = list(corners[1 : far + 1]), list(corners[far + 1 :])
    if back:
        # Side k continues into the chord: the left outline begins at the chord's far end.
        left_sides[0] += length
        left = Boundary(left_sides, [one, *left_corners])
        right = Boundary([*right_sides, length], [one, *right_corners, one])
    else:
        left = Boundary([*left_sides, length], [one, *left_corners, one])
        right_sides[-1] += length
        right = Boundary(right_sides, [one, *right_corners])
    end = (start + inner + w) % boundary.perimeter
    return Prolongation(guess, start, end, length, inner + w if back else 0, left, right)
