"""Where a flat picture puts a disk's boundary: a polygon with one bulging edge per side.

The outline is strictly convex, so that Tutte's theorem has its hypothesis and no quad on
a side is squeezed flat: sides are shallow arcs, not straight lines. Three corners and more
give a polygon inscribed in a circle; two a lens; one a teardrop; none a circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.disk import Disk

#: How far a side turns from end to end, in radians: enough to be strictly convex, too
#: little to be taken for a curve.
SIDE_TURN = math.radians(14.0)

#: The same for the two sides of a lens.
LENS_TURN = math.radians(105.0)

#: Sides are drawn as long as this power of their number of edges: 0 would draw a regular
#: polygon, 1 the true proportions, in which a side of one edge beside one of 20 is lost.
LENGTH_POWER = 0.5

#: No side is drawn longer than this part of all the others together (the triangle
#: inequality wants < 1; near 1 the polygon is a sliver).
LONGEST_SIDE = 0.7

#: Every cut takes two long sides and a short one three tenths of the way to their limit.
MOST_CUTS = 200


@dataclass(frozen=True, slots=True)
class Outline:
    """The boundary as complex-linear combinations of a few handles.

    handles: (k,) complex128 points: the N corners, then one control point per side, which
             is a quadratic Bezier arc; where N < 2 all boundary vertices.
    ends:    (P, 3) int32 the handles that a boundary vertex hangs on.
    weights: (P, 3) float64; vertex j lies at the sum of weights[j] * handles[ends[j]].
    """

    handles: NDArray[np.complex128]
    ends: NDArray[np.int32]
    weights: NDArray[np.float64]

    def points(self) -> NDArray[np.complex128]:
        """(P,) complex128 boundary vertices."""
        return (self.weights * self.handles[self.ends]).sum(axis=1)


def convex_outline(disk: Disk) -> Outline:
    """The strictly convex outline, counter-clockwise, side 0 at the bottom."""
    n = disk.n_sides
    if n < 2:
        points = _teardrop(disk) if n == 1 and disk.corner_counts()[0] == 1 else _circle(disk)
        count = np.arange(len(points), dtype=np.int32)
        weights = np.tile(np.array([1.0, 0.0, 0.0]), (len(points), 1))
        return Outline(points, np.stack([count] * 3, axis=1), weights)
    if n == 2:
        corners, turn = np.array([-1.0 + 0.0j, 1.0 + 0.0j]), LENS_TURN
    else:
        corners, turn = _inscribed(_drawn_lengths(disk.side_lengths())), SIDE_TURN
        corners *= np.exp(-1j * np.angle(corners[1] - corners[0]))
    chords = np.roll(corners, -1) - corners
    controls = corners + chords * (0.5 - 0.5j * math.tan(turn / 2.0))
    ends = np.empty((disk.perimeter, 3), np.int32)
    weights = np.empty((disk.perimeter, 3))
    for s, side in enumerate(disk.sides()):
        t = np.linspace(0.0, 1.0, len(side))[:-1]
        ends[side[:-1]] = s, n + s, (s + 1) % n
        weights[side[:-1]] = np.stack([(1.0 - t) ** 2, 2.0 * t * (1.0 - t), t**2], axis=1)
    return Outline(np.concatenate([corners, controls]), ends, weights)


def _drawn_lengths(lengths: NDArray[np.int32]) -> NDArray[np.float64]:
    drawn = lengths.astype(np.float64) ** LENGTH_POWER
    # Cutting one side short may leave another too long beside it: they give way in turn.
    for _ in range(MOST_CUTS):
        longest = int(drawn.argmax())
        limit = LONGEST_SIDE * (drawn.sum() - drawn[longest])
        if drawn[longest] <= limit * (1.0 + 1e-9):
            break
        drawn[longest] = limit
    return drawn


def _inscribed(lengths: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Corners of the polygon with these side lengths whose corners lie on the unit circle.

    LONGEST_SIDE < 1 sees to it that there is one; where its longest side lies between the
    centre and the others, the centre is outside the polygon.
    """

    def half_angles(radius: float) -> NDArray[np.float64]:
        return np.arcsin(np.minimum(lengths / (2.0 * radius), 1.0))

    longest = int(lengths.argmax())
    smallest = float(lengths[longest]) / 2.0
    outside = float(half_angles(smallest).sum()) < math.pi

    def excess(radius: float) -> float:
        half = half_angles(radius)
        if outside:
            return float(half[longest] - (half.sum() - half[longest]))
        return float(half.sum()) - math.pi

    # The excess falls with the radius. A circle must be wide for a longest side that is almost
    # as long as the others together.
    low, high = smallest, float(lengths.sum())
    while excess(high) > 0.0:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = (low + high) / 2.0
        if excess(middle) > 0.0:
            low = middle
        else:
            high = middle
    angles = 2.0 * half_angles(high)
    if outside:
        angles[longest] = 2.0 * math.pi - (angles.sum() - angles[longest])
    at = np.concatenate([[0.0], np.cumsum(angles)[:-1]])
    return np.exp(1j * at)


def _circle(disk: Disk) -> NDArray[np.complex128]:
    """(P,) points on a circle, its bottom edge level; a lone reflex corner is not bent."""
    p = disk.perimeter
    return np.exp(2j * math.pi * ((np.arange(p) - 0.5) / p - 0.25))


def _teardrop(disk: Disk) -> NDArray[np.complex128]:
    """(P,) points at equal distances along a drop with a right angle on top.

    One Bezier loop: its control polygon is convex, so the curve is.
    """
    t = np.linspace(0.0, 1.0, 2001)
    handle = np.exp(-0.75j * math.pi)
    curve = 3.0 * (1.0 - t) ** 2 * t * handle - 3.0 * (1.0 - t) * t**2 * np.conj(handle)
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(curve)))])
    at = np.arange(disk.perimeter) / disk.perimeter * length[-1]
    points = np.interp(at, length, curve.real) + 1j * np.interp(at, length, curve.imag)
    return np.roll(points, int(disk.corners[0]))
