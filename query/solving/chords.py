"""The open polychords of a pattern as a linear system: which sides each of them joins.

For every side s the widths of the polychords that end on it add up to the edges asked
for; a polychord with both ends on s counts twice (Marcias et al. 2015, section 4). The
polychords of one pattern that join the same two sides form a *class*: only the sum of
their widths matters to the sides. With slack = edges asked for - base length, the sums
solve an uncapacitated b-matching on the sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array


@dataclass(frozen=True, slots=True)
class Chords:
    """Open polychords in label order, and their classes in order of (i, j).

    n_sides: number of sides, at least 1 (one closed side is a side like any other).
    edges:   (2 n,) int32, the polychord that crosses each edge when all widths are 1, side by
             side.
    side_start: (n_sides + 1,) int32, where each side begins in ``edges``.
    sides:   (n, 2) int32, the two sides i <= j that each polychord joins.
    class_i, class_j: (m,) int32, the sides that each class joins.
    class_n: (m,) int32 >= 1, how many polychords the class has.
    class_of: (n,) int32, the class of each polychord.
    """

    n_sides: int
    edges: Int32Array
    side_start: Int32Array
    sides: Int32Array
    class_i: Int32Array
    class_j: Int32Array
    class_n: Int32Array
    class_of: Int32Array

    @classmethod
    def from_label(cls, label: Sequence[Sequence[int]]) -> Chords:
        """From a boundary label: per side, the polychord that crosses each edge."""
        edges = np.array([chord for side in label for chord in side], np.int32)
        start = np.cumsum([0, *map(len, label)]).astype(np.int32)
        side_of = np.repeat(np.arange(len(label), dtype=np.int32), np.diff(start))
        # The two edges of each polychord stand together once sorted by polychord.
        pairs = side_of[np.argsort(edges, kind="stable")].reshape(-1, 2)
        n_sides = len(label)
        key, class_of, count = np.unique(
            pairs[:, 0] * n_sides + pairs[:, 1], return_inverse=True, return_counts=True
        )
        return cls(
            n_sides,
            edges,
            start,
            pairs,
            (key // n_sides).astype(np.int32),
            (key % n_sides).astype(np.int32),
            count.astype(np.int32),
            class_of.ravel().astype(np.int32),
        )

    @classmethod
    def from_sides(cls, n_sides: int, sides: ArrayLike) -> Chords:
        """From the two sides, in either order, of every polychord; (n, 2).

        Along every side they come in the order given: right where only sums matter.
        """
        label: list[list[int]] = [[] for _ in range(n_sides)]
        for chord, pair in enumerate(np.asarray(sides, np.int32).reshape(-1, 2).tolist()):
            for side in pair:
                label[side].append(chord)
        return cls.from_label(label)

    @property
    def n(self) -> int:
        """How many open polychords there are."""
        return len(self.sides)

    def base_lengths(self) -> Int32Array:
        """(n_sides,) int32 edges of every side when all widths are 1."""
        return np.bincount(self.sides.ravel(), minlength=self.n_sides).astype(np.int32)

    def side_lengths(self, widths: ArrayLike) -> NDArray[np.int64]:
        """(n_sides,) int64 edges of every side with the given widths (n,)."""
        ends = np.repeat(np.asarray(widths, np.int64), 2)
        lengths = np.zeros(self.n_sides, np.int64)
        np.add.at(lengths, self.sides.ravel(), ends)
        return lengths
