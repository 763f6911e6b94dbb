"""The rotations and mirror images in which a pattern can meet a boundary.

In the orientation (rotation, mirrored) side i of the boundary is the pattern's side
rotation + i, or, mirrored, its side rotation - i read backwards, both modulo N. Corner i
is where side i begins, so it is the pattern's corner rotation + i, or rotation + 1 - i.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from query.boundary import Boundary


@dataclass(frozen=True, slots=True, order=True)
class Orientation:
    """How a pattern lies in a boundary; unmirrored ones sort first."""

    mirrored: bool
    rotation: int

    def seen(self, boundary: Boundary) -> tuple[Int32Array, Int32Array]:
        """The boundary in the pattern's own order.

        Returns ((max(N, 1),) int32 lengths, (N,) int32 quads at the corners), such that
        entry s is what the pattern's side s and corner s have to meet.
        """
        lengths = np.array(boundary.lengths, np.int32)
        counts = np.array(boundary.corner_counts, np.int32)
        n = boundary.n_sides
        if n == 0:
            return lengths, counts
        s = np.arange(n)
        if self.mirrored:
            return lengths[(self.rotation - s) % n], counts[(self.rotation + 1 - s) % n]
        return lengths[(s - self.rotation) % n], counts[(s - self.rotation) % n]


@cache
def list_orientations(n_sides: int) -> tuple[Orientation, ...]:
    """All 2N orientations. One closed side has no first edge: only the two mirror images."""
    return tuple(Orientation(m, r) for m in (False, True) for r in range(max(n_sides, 1)))


@cache
def list_sides_seen(n_sides: int) -> NDArray[np.int64]:
    """(o, N) the boundary's side that the pattern's side s meets, in every orientation."""
    s = np.arange(n_sides)
    return np.array(
        [
            (o.rotation - s if o.mirrored else s - o.rotation) % n_sides
            for o in list_orientations(n_sides)
        ]
    )


@cache
def list_corners_seen(n_sides: int) -> NDArray[np.int64]:
    """(o, N) the boundary's corner that the pattern's corner s meets, in every orientation."""
    s = np.arange(n_sides)
    return np.array(
        [
            (o.rotation + 1 - s if o.mirrored else s - o.rotation) % n_sides
            for o in list_orientations(n_sides)
        ]
    )


def list_distinct_orientations(pattern: Pattern) -> list[Orientation]:
    """The orientations less those that the pattern's own symmetries make equal.

    ``pattern.rotations`` of the N rotations map the pattern onto itself, so only the first
    N / rotations differ; its mirror image differs only where it is chiral.
    """
    turns = max(pattern.n_sides // pattern.rotations, 1)
    return [
        o
        for o in list_orientations(pattern.n_sides)
        if o.rotation < turns and (pattern.chiral or not o.mirrored)
    ]


def list_chord_symmetries(pattern: Pattern) -> NDArray[np.int64]:
    """(rotations, n_chords) int64: where each rotation of a closed side takes the polychords.

    Row g holds, for every polychord in label order, the polychord it is taken to. Only
    where N = 0: widths that differ by such a rotation are one fill of the closed side.
    """
    (label,) = pattern.label
    edges = np.array(label)
    step = len(edges) // pattern.rotations
    rows = np.empty((pattern.rotations, pattern.n_chords), np.int64)
    for g in range(pattern.rotations):
        rows[g, edges] = np.roll(edges, -g * step)
    return rows
