"""Fits: the widths and orientations with which one pattern meets a boundary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.pattern import Pattern
from query.boundary import Boundary
from query.chords import Chords
from query.expand import expand
from query.fill import Fill
from query.orientation import Orientation, distinct_orientations, symmetries_of_chords
from query.solve import Solutions, Solver


@dataclass(frozen=True, slots=True, order=True)
class Fit:
    """A way to meet a boundary; fits of one pattern sort best first.

    key:         sum of the squared widths, see :mod:`query.evenness`.
    widths:      of the open polychords, in label order.
    orientation: how the pattern lies in the boundary.
    """

    key: int
    widths: tuple[int, ...]
    orientation: Orientation

    def fill(self, pattern: Pattern) -> Fill:
        """Expand the pattern; its loops are 1 wide."""
        o = self.orientation
        return expand(pattern, self.widths, rotation=o.rotation, mirrored=o.mirrored)


def fits(
    pattern: Pattern, boundary: Boundary, limit: int | None, solve: Solver
) -> tuple[list[Fit], bool]:
    """The ``limit`` best strict fits (None: all), and whether there are more.

    The pattern's corners fall on the boundary's, kind for kind, in every orientation less
    those that its own symmetries make equal. One closed side (N = 0) has no first edge:
    fits that differ by a rotation of it are one, and the one listed has the smallest
    widths.
    """
    chords = Chords.from_label(pattern.label)
    closed = pattern.n_sides == 0
    # Equal widths up to rotation stand side by side among the best: that many cover the limit.
    ask = limit if limit is None or not closed else limit * pattern.rotations + 1
    solved: dict[bytes, Solutions] = {}
    found: list[Fit] = []
    more = False
    for orientation in distinct_orientations(pattern):
        lengths, corners = orientation.seen(boundary)
        if tuple(corners.tolist()) != pattern.corners:
            continue
        key = lengths.tobytes()
        if key not in solved:
            solved[key] = solve(chords, lengths, ask)
        more = more or solved[key].truncated
        widths = solved[key].widths
        if closed:
            widths = _one_of_each(widths, pattern)
        squares = (widths.astype(np.int64) ** 2).sum(axis=1).tolist()
        found += [
            Fit(s, tuple(w), orientation) for s, w in zip(squares, widths.tolist(), strict=True)
        ]
    found.sort()
    return found[:limit], more or (limit is not None and len(found) > limit)


def _one_of_each(widths: NDArray[np.int32], pattern: Pattern) -> NDArray[np.int32]:
    """The rows that no rotation of the closed side makes smaller."""
    smallest = np.ones(len(widths), np.bool_)
    for moved in symmetries_of_chords(pattern):
        turned = widths[:, moved]
        differ = turned != widths
        first = differ.argmax(axis=1)
        row = np.arange(len(widths))
        smallest &= ~differ.any(axis=1) | (widths[row, first] < turned[row, first])
    return widths[smallest]
