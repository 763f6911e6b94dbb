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
