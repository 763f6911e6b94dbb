"""Where polylines meet: the places at which two of them come together.

Take a pair of curves, A and B, and all pairs of places (a on A, b on B) that are within the
tolerance of each other: the lesser reach of the two curves. The connected parts of this set are the
meetings: one for each crossing, touching end or common stretch. For one curve with itself, the part
around a = b is none.

Points stand in one array (n, 3); edge i runs from point i to point i + 1.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb._native.surfacing.curvenetwork.meetings import components, contacts, joins
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import PackedCurves

#: Pairs of edges within the tolerance that are looked at: 40 bytes each.
MAX_CONTACTS = 5_000_000

#: A meeting longer than this many tolerances may be a common stretch: edges that cross at 30
#: degrees are within the tolerance of each other for 4 of them.
LONG = 4.0


@dataclass(frozen=True, slots=True)
class Joins:
    """Pairs of places on curves that are, or may be, one node.

    curves: (m, 2) int64. lengths: (m, 2) float64, the arc lengths of the places along them.
    gaps: (m,) how far apart they are. meetings: (m,) the number of the meeting that each is of.
    """

    curves: Int64Array = field(repr=False)
    lengths: Floats = field(repr=False)
    gaps: Floats = field(repr=False)
    meetings: Int64Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.gaps)

    def take(self, which: NDArray[np.bool_] | Int64Array) -> Joins:
        """Return some of the joins, by their numbers or by a mask."""
        return Joins(
            self.curves[which], self.lengths[which], self.gaps[which], self.meetings[which]
        )

    def append(self, other: Joins) -> Joins:
        """Return these joins and then others, whose meetings get numbers of their own."""
        shift = 1 + int(self.meetings.max(initial=-1))
        return Joins(
            np.concatenate([self.curves, other.curves]),
            np.concatenate([self.lengths, other.lengths]),
            np.concatenate([self.gaps, other.gaps]),
            np.concatenate([self.meetings, other.meetings + shift]),
        )


def find_joins(
    curves: PackedCurves, reaches: Floats, settled: NDArray[np.bool_] | None = None
) -> Joins:
    """Find where curves meet each other and themselves.

    reaches: (c,) for every curve; two meet within the lesser of theirs. settled: (c,) curves that
    are not compared with each other; by default all are compared. A crossing joins at the closest
    pair of places, ends within reach of each other at the ends, a common stretch at its two
    extremes. Raises InvalidNetworkError beyond MAX_CONTACTS.
    """
    points, along, curve_of = curves.points, curves.along, curves.curve_of
    pairs, places, distances = find_contacts(curves, reaches, settled=settled)
    key = pairs[:, 0] * len(points) + pairs[:, 1]
    by_key = np.argsort(key)
    key, pairs, places, distances = key[by_key], pairs[by_key], places[by_key], distances[by_key]
    roots = components(points, curve_of, key, pairs, reaches)
    itself = np.zeros(len(key), bool)
    itself[roots[_is_beside_itself(curves, pairs, reaches)]] = True
    kept = np.flatnonzero(~itself[roots])
    kept = kept[np.argsort(roots[kept], kind="stable")]
    bounds = np.r_[0, 1 + np.flatnonzero(np.diff(roots[kept])), len(kept)].astype(np.int64)
    return Joins(
        *joins(
            points,
            curve_of,
            along,
            curves.lasts,
            pairs[kept],
            places[kept],
            distances[kept],
            bounds,
            reaches,
            curves.closed,
        )
    )


def _is_beside_itself(
    curves: PackedCurves, pairs: Int64Array, reaches: Floats
) -> NDArray[np.bool_]:
    """(k,) which contacts go on to places that one curve has in common with itself.

    Pairs of edges of one curve that lie within the reach along it are not among the contacts.
    """
    first, second = pairs.T
    along = curves.along
    reach = reaches[curves.curve_of[first]]
    near = (along[second + 1] - along[first + 1] <= reach) | (along[second] - along[first] <= reach)
    own = curves.curve_of[first] == curves.curve_of[second]
    return own & ((first == second) | near)


def find_contacts(
    curves: PackedCurves,
    reaches: Floats,
    boxes: Floats | None = None,
    settled: NDArray[np.bool_] | None = None,
) -> tuple[Int64Array, Floats, Floats]:
    """Find the pairs of edges within reach of each other.

    reaches, settled: as :func:`find_joins` has them. boxes: (n,) by how much the box of every edge
    is enlarged, by the number of its first point; edges whose boxes do not touch then are left out.
    By default half the reach of its curve. Left out as well are pairs of edges of one curve that
    lie within its reach along the curve. Returns the edges (k, 2), first <= second, the nearest
    places on them (k, 2), 0 to 1, and how far these are apart (k,). Raises InvalidNetworkError
    beyond MAX_CONTACTS.
    """
    points, starts, curve_of = curves.points, curves.starts, curves.curve_of
    edges = np.delete(np.arange(len(points) - 1), starts[1:-1] - 1)
    reach = (reaches[curve_of[edges]] / 2 if boxes is None else boxes[edges])[:, None]
    low = np.minimum(points[edges], points[edges + 1]) - reach
    high = np.maximum(points[edges], points[edges + 1]) + reach
    # Swept along the axis on which the edges are spread furthest.
    axis = int(np.argmax(np.ptp(points, axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = np.roll(low, -axis, axis=1), np.roll(high, -axis, axis=1)
    pairs, places, distances = contacts(
        points,
        curves.along,
        curve_of,
        edges[order],
        low[order],
        high[order],
        reaches,
        np.zeros(len(reaches), np.bool_) if settled is None else settled,
        MAX_CONTACTS,
    )
    if len(pairs) > MAX_CONTACTS:
        raise InvalidNetworkError(
            f"at a tolerance of {reaches.max():g}, more than {MAX_CONTACTS:,} pairs of edges "
            "touch; give a smaller tolerance, or fewer points"
        )
    return pairs, places, distances
