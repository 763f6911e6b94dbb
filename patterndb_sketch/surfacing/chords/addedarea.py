"""What a chord costs in area: the least area of both its sides, beyond that of the whole loop."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.chords.flatness import determinant_of, moments_of
from patterndb_sketch.surfacing.chords.order import canonical_order
from patterndb_sketch.surfacing.errors import InvalidNetworkError

#: A chord may add this much area, as a share of the loop's least, for each unit of box that it
#: takes away. Chosen with the shapes of benchmarks/surfacing in view: 0.3 to 0.4 serve them alike,
#: below 0.294 their gable roof loses its ridge.
AREA_PRICE = 1.0 / 3.0

#: Less added area than this share of the loop's is none: the least area of a curved strip varies
#: by as much with where its vertices happen to lie.
NO_AREA = 0.005

#: Areas are measured on about so many vertices of a loop, and all ends of chords: time grows with
#: the cube of their number.
MEASURED = 64


def affordable(
    points: Points, chords: NDArray[np.int64], price: float = AREA_PRICE
) -> NDArray[np.bool_]:
    """(m,) which chords (m, 2), positions i < j in a loop (n, 3), are worth the area they add.

    A chord must make its sides flatter by what it adds: added <= NO_AREA + price * (box(loop) -
    box(one side) - box(other side)). A box is the product of the standard deviations along the
    principal axes, in units of the loop's mean one: 0 for a planar part, 1 for a loop spread as
    far in all directions. Raises InvalidNetworkError for a price below 0.

    Differs from the paper: it counts on short chords for a small area (Abbasinejad et al. 2013,
    section 3.2). That does not keep a chord from closing a bent strip off by a flat lid: two
    flat lids and a flat bottom cost it less than the strip.
    """
    if not price >= 0.0:
        raise InvalidNetworkError(f"the price of area is {price}; give a number from 0 on")
    if len(chords) == 0:
        return np.zeros(0, np.bool_)
    measured = _measured(points, chords)
    added = added_area(points[measured], np.searchsorted(measured, chords))
    own = points - points.mean(axis=0)
    spread = math.sqrt(float((own * own).sum()) / own.size)
    if spread == 0.0:
        return np.zeros(len(chords), np.bool_)
    flatter = _flatter(np.ascontiguousarray(own / spread), chords)
    return added <= NO_AREA + price * np.maximum(flatter, 0.0)


def added_area(points: Points, chords: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) by how much a cut along each chord (m, 2) raises the least area of a loop (n, 3).

    As a share of the loop's own least area; 0 where a triangulation of least area has the
    chord, and for a loop without area. Source: the recurrence of Barequet and Sharir 1995,
    around the loop instead of along it.
    """
    n = len(points)
    middle = points - points.mean(axis=0)
    least = _least_around(np.ascontiguousarray(middle.T))
    whole = least[0, n - 1]
    if whole <= 0.0:
        return np.zeros(len(chords))
    first, second = chords[:, 0], chords[:, 1]
    span = second - first
    return (least[first, span] + least[second, n - span]) / whole - 1.0


def _measured(points: Points, chords: NDArray[np.int64]) -> NDArray[np.int64]:
    """Ascending positions of the ends of chords and of evenly spread vertices between."""
    n = len(points)
    stride = -(-n // MEASURED)
    # In an order that does not depend on where the loop starts and which way it runs.
    return np.union1d(canonical_order(points)[::stride], chords)


@kernel
def _flatter(points: Points, chords: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) the box of the loop (n, 3) less those of both sides of each chord."""
    whole = math.sqrt(max(0.0, determinant_of(moments_of(points))))
    turned = np.concatenate((points, points))
    n = len(points)
    gained = np.empty(len(chords))
    for c in range(len(chords)):
        i, j = chords[c, 0], chords[c, 1]
        one = math.sqrt(max(0.0, determinant_of(moments_of(turned[i : j + 1]))))
        other = math.sqrt(max(0.0, determinant_of(moments_of(turned[j : i + n + 1]))))
        gained[c] = whole - one - other
    return gained


# Sums may be reordered, so that the inner loop runs in vector registers; infinities do occur.
@kernel(fastmath={"reassoc", "nnan", "nsz", "contract"})
def _least_around(at: Points) -> Points:
    """(n, n) [i, s]: twice the least area of the s + 1 vertices from i on, of a loop (3, n)."""
    n = at.shape[1]
    twice = np.empty((3, 2 * n))
    twice[:, :n] = at
    twice[:, n:] = at
    least = np.zeros((n, n))
    # The same by the vertex where a stretch ends: what the inner loop reads lies in a row.
    ending = np.zeros((n, n))
    for s in range(2, n):
        for i in range(n):
            j = i + s
            x = twice[0, j] - twice[0, i]
            y = twice[1, j] - twice[1, i]
            z = twice[2, j] - twice[2, i]
            row, column = least[i], ending[j % n]
            best = np.inf
            for k in range(1, s):
                u = twice[0, i + k] - twice[0, i]
                v = twice[1, i + k] - twice[1, i]
                w = twice[2, i + k] - twice[2, i]
                a, b, c = v * z - w * y, w * x - u * z, u * y - v * x
                best = min(best, row[k] + column[s - k] + math.sqrt(a * a + b * b + c * c))
            least[i, s] = best
            ending[j % n, s] = best
    return least
