"""Prolong: cuts that take a reflex corner away.

A side that ends at a reflex corner is prolonged through it by a chord to an inner vertex
of another side. The corner becomes convex in the one part and flat in the other, the
chord's far end convex in both: the cut itself costs no irregular vertex.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.system.kernels import kernel
from query.boundary import MAX_PERIMETER, Boundary, CornerKind

#: Sides between a reflex corner and the far end of its chord, counted the shorter way round.
REACH = 8

#: Reflex corners from which cuts are tried; where there are more, the first ones.
MOST_REFLEX = 8

#: Lengths of a chord, and places along a side, that are tried one by one; where there are
#: more, they are tried in larger steps, and those that make two sides equal.
MOST_STEPS = 24


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


@kernel
def list_prolongations(
    lengths: Int64Array, counts: Int64Array, most_perimeter: int
) -> tuple[Int64Array, NDArray[np.float64]]:
    """(r, 5) int64 corner k, back, far, w, chord of cuts, and guesses of their irregular vertices.

    The chord ends w edges along side k + far; back: side k is prolonged, else side k - 1.
    """
    n = len(lengths)
    rows = np.empty((2 * MOST_REFLEX * n, 5), np.int64)
    guess = np.empty(len(rows))
    whole = lengths.sum()
    left = np.empty(n + 2, np.int64)
    left_counts = np.empty(n + 2, np.int64)
    right = np.empty(n + 2, np.int64)
    right_counts = np.empty(n + 2, np.int64)
    chords = np.empty(2 * MOST_STEPS + n + 4, np.int64)
    places = np.empty(2 * MOST_STEPS + n + 4, np.int64)
    found = 0
    reflex = 0
    for k in range(n):
        if counts[k] == 1:
            continue
        reflex += 1
        if reflex > MOST_REFLEX:
            break
        for back in range(2):
            # The part in which the corner is flat has to keep a second side, to be an outline.
            for far in range(1 if back else 0, n if back else n - 1):
                if min(far, n - 1 - far) > REACH:
                    continue
                best = np.inf
                side = lengths[(k + far) % n]
                inner = 0
                for i in range(far):
                    inner += lengths[(k + i) % n]
                n_places = _steps(1, side - 1, lengths, places)
                for at in range(n_places):
                    w = places[at]
                    arc = inner + w
                    longest = min(arc, whole - arc, most_perimeter - max(arc, whole - arc))
                    n_chords = _steps(2, longest, lengths, chords)
                    n_left, n_right = _cut(
                        lengths, counts, k, back, far, w, left, left_counts, right, right_counts
                    )
                    flat = 0 if back else n_right - 1
                    for c in range(n_chords):
                        e = chords[c]
                        if (arc + e) % 2:
                            continue
                        if back:
                            left[flat] += e
                            right[n_right - 1] = e
                        else:
                            right[flat] += e
                            left[n_left - 1] = e
                        value = guess_irregular(left, left_counts, n_left)
                        value += guess_irregular(right, right_counts, n_right)
                        # Among equals the shortest chord, and the longest of the parts' sides.
                        value += 1e-3 * e / (arc + e) - 1e-3 * min(w, side - w) / whole
                        if back:
                            left[flat] -= e
                        else:
                            right[flat] -= e
                        if value < best:
                            best = value
                            rows[found, 0] = k
                            rows[found, 1] = back
                            rows[found, 2] = far
                            rows[found, 3] = w
                            rows[found, 4] = e
                if best < np.inf:
                    guess[found] = best
                    found += 1
    return rows[:found].copy(), guess[:found].copy()


@kernel
def _steps(low: int, high: int, lengths: Int64Array, out: Int64Array) -> int:
    """Write the whole numbers low..high, or a selection of them; return how many."""
    step = max(1, (high - low) // MOST_STEPS)
    n = 0
    for value in range(low, high + 1, step):
        out[n] = value
        n += 1
    if step > 1:
        for length in lengths:
            if low <= length <= high and (length - low) % step:
                out[n] = length
                n += 1
    return n


@kernel
def _cut(
    lengths: Int64Array,
    counts: Int64Array,
    k: int,
    back: int,
    far: int,
    w: int,
    left: Int64Array,
    left_counts: Int64Array,
    right: Int64Array,
    right_counts: Int64Array,
) -> tuple[int, int]:
    """Write the sides and corners of both parts, the chord's own length left out."""
    n = len(lengths)
    for i in range(far):
        left[i] = lengths[(k + i) % n]
        left_counts[i] = counts[(k + i) % n]
    left[far] = w
    left_counts[far] = counts[(k + far) % n]
    left_counts[0] = 1
    n_left = far + 1
    right[0] = lengths[(k + far) % n] - w
    right_counts[0] = 1
    n_right = 1
    for i in range(far + 1, n):
        right[n_right] = lengths[(k + i) % n]
        right_counts[n_right] = counts[(k + i) % n]
        n_right += 1
    if back:
        right[n_right] = 0
        right_counts[n_right] = 1
        n_right += 1
    else:
        left[n_left] = 0
        left_counts[n_left] = 1
        n_left += 1
    return n_left, n_right


@kernel
def guess_irregular(lengths: Int64Array, counts: Int64Array, n: int) -> float:
    """Roughly how many irregular vertices the best fill of an outline has.

    Exact for convex outlines of 3 to 5 sides that have a fill with the fewest; else the mean
    of what the complete family of patterns with at most 4 needs.
    """
    total = 0
    longest = 0
    n_reflex = 0
    unit = 0
    pair = 0
    for i in range(n):
        total += lengths[i]
        longest = max(longest, lengths[i])
        pair = max(pair, lengths[i] + lengths[(i + 1) % n])
        n_reflex += counts[i] != 1
        unit += lengths[i] == 1
    if n < 2 or total < 4:
        return np.inf
    if n_reflex:
        value = abs(n - 2 * n_reflex - 4) + 1.5 * n_reflex
    elif n == 2:
        return 2.0
    elif n == 3:
        return 1.0 if 2 * longest < total and unit == 0 else 3.0
    elif n == 4:
        if lengths[0] == lengths[2] and lengths[1] == lengths[3]:
            return 0.0
        value = 2.0
    elif n == 5:
        if 2 * pair < total:
            return 1.0
        value = 2.0
    elif n == 6:
        value = 2.2
    elif n == 7:
        value = 2.4
    else:
        value = float(n - 5)
    if 2 * longest >= total:
        value += 1.5
    return value + 0.3 * unit
