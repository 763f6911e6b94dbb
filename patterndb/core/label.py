"""Boundary labels and signatures: which sides a pattern's polychords join, and in what order.

The *label* of a pattern numbers its boundary edges, in order from corner 0, so that two
edges have one number exactly if one polychord joins them; numbers appear in order 0, 1,
2, ... It is written as a word: for every side its length, then its numbers. The
*signature* is the smallest word over all rotations (by sides) and both reflections.

Source: Marcias et al. 2015, section 4 ("Edge-flow constraints", Figure 9).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel


@kernel
def _side_length(side_start: Int32Array, side: int, n_sides: int, perimeter: int) -> int:
    """The edges of a side, of several: from its first to the first of the next."""
    if side + 1 < n_sides:
        return side_start[side + 1] - side_start[side]
    return side_start[0] + perimeter - side_start[side]


@kernel
def label_word(
    chord: Int32Array,
    side_start: Int32Array,
    n_sides: int,
    perimeter: int,
    rotation: int,
    reflected: bool,
    word: NDArray[np.int32],
    names: Int32Array,
) -> int:
    """Write the label as seen from side ``rotation``, and return its length.

    chord: (perimeter,) polychord of each boundary edge, in counter-clockwise order;
    side_start: (n_sides,) first edge of each side, ascending. Where there is no corner,
    n_sides is 1, the whole boundary is one side and ``rotation`` counts edges.
    reflected: read clockwise, beginning with side ``rotation`` from its far end.
    word: (>= n_sides + perimeter,) int32; names: (> chord.max(),) int32 scratch.
    """
    names[:] = -1
    fresh = 0
    at = 0
    for k in range(n_sides):
        if n_sides == 1:
            length = perimeter
            first = side_start[0] + rotation
        else:
            s = (rotation - k) % n_sides if reflected else (rotation + k) % n_sides
            first = side_start[s]
            length = _side_length(side_start, s, n_sides, perimeter)
        word[at] = length
        at += 1
        for i in range(length):
            j = first + (length - 1 - i if reflected else i)
            c = chord[j if j < perimeter else j - perimeter]
            if names[c] < 0:
                names[c] = fresh
                fresh += 1
            word[at] = names[c]
            at += 1
    return at


@kernel
def canonical_word(
    chord: Int32Array,
    side_start: Int32Array,
    n_sides: int,
    n_corners: int,
    perimeter: int,
    best: NDArray[np.int32],
    word: NDArray[np.int32],
    names: Int32Array,
) -> tuple[int, int, bool, int]:
    """Write the signature into ``best``; return (its length, rotation, reflected, symmetries).

    rotation and reflected say from where the label reads as the signature; symmetries
    counts the rotations and reflections that leave the word as it is.
    """
    n_rotations = perimeter if n_corners == 0 else n_sides
    # A word begins with the length of its first side, so the smallest with a shortest one.
    shortest = perimeter
    if n_sides > 1:
        for s in range(n_sides):
            shortest = min(shortest, _side_length(side_start, s, n_sides, perimeter))
    found_rotation = -1
    found_reflected = False
    symmetries = 0
    length = 0
    for reflected in (False, True):
        for rotation in range(n_rotations):
            if n_sides > 1 and _side_length(side_start, rotation, n_sides, perimeter) > shortest:
                continue
            length = label_word(
                chord, side_start, n_sides, perimeter, rotation, reflected, word, names
            )
            order = -1 if found_rotation < 0 else 0
            if order == 0:
                for i in range(length):
                    if word[i] != best[i]:
                        order = -1 if word[i] < best[i] else 1
                        break
            if order < 0:
                for i in range(length):
                    best[i] = word[i]
                found_rotation = rotation
                found_reflected = reflected
                symmetries = 1
            elif order == 0:
                symmetries += 1
    return length, found_rotation, found_reflected, symmetries


def split_word(word: NDArray[np.integer], n_sides: int) -> list[list[int]]:
    """The word's labels, side by side."""
    sides: list[list[int]] = []
    at = 0
    for _ in range(max(n_sides, 1)):
        length = int(word[at])
        sides.append([int(x) for x in word[at + 1 : at + 1 + length]])
        at += 1 + length
    return sides


def join_matrices(
    n_sides: int, pairs: NDArray[np.integer], owner: NDArray[np.integer], n: int
) -> NDArray[np.int32]:
    """(n, N, N) int32 n_ij of n labels: how many polychords join sides i and j.

    pairs: (c, 2) sides joined by each polychord; owner: (c,) whose label it belongs to.
    A polychord with both ends on side i counts once in n_ii (and twice in the length).
    """
    width = max(n_sides, 1)
    i, j = pairs[:, 0].astype(np.int64), pairs[:, 1].astype(np.int64)
    across = i != j
    cells = np.concatenate(
        [(owner * width + i) * width + j, ((owner * width + j) * width + i)[across]]
    )
    counts = np.bincount(cells, minlength=n * width * width)
    return counts.astype(np.int32).reshape(n, width, width)
