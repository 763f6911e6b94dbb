"""Where polylines meet: kernels that find the places at which two of them come together.

Take a pair of curves, A and B, and all pairs of places (a on A, b on B) that are within the
tolerance of each other. The connected parts of this set are the meetings: one for each crossing,
touching end or common stretch. For one curve with itself, the part around a = b is none.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.joining.joints import BETTER, MOST_JOINS, chosen_places
from patterndb_sketch.surfacing.joining.nearest import nearest_of_edges, nearest_on_edge

#: Pairs of edges within the tolerance that are looked at: 40 bytes each.
MAX_CONTACTS = 5_000_000


@dataclass(frozen=True, slots=True)
class Joins:
    """Pairs of places on curves that are to be one node.

    curves: (m, 2) int64. lengths: (m, 2) float64, the arc lengths of the places along them.
    """

    curves: Int64Array = field(repr=False)
    lengths: Floats = field(repr=False)


def find_joins(points: Points, starts: Int64Array, along: Floats, tolerance: float) -> Joins:
    """Where curves meet each other and themselves.

    points: (n, 3), the points of all curves. starts: (c + 1,), where each begins in them.
    along: (n,) arc length from the beginning of its curve. A crossing joins at the closest
    pair of places, ends within the tolerance of each other at the ends, a common stretch at
    its two extremes. Raises InvalidNetworkError beyond MAX_CONTACTS.
    """
    edges = np.delete(np.arange(len(points) - 1), starts[1:-1] - 1)
    curve_of = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    low = np.minimum(points[edges], points[edges + 1]) - tolerance / 2
    high = np.maximum(points[edges], points[edges + 1]) + tolerance / 2
    # Swept along the axis on which the edges are spread furthest.
    axis = int(np.argmax(np.ptp(points, axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = np.roll(low, -axis, axis=1), np.roll(high, -axis, axis=1)
    pairs, places, distances = _contacts(
        points, edges[order], low[order], high[order], tolerance, MAX_CONTACTS
    )
    if len(pairs) > MAX_CONTACTS:
        raise InvalidNetworkError(
            f"at a tolerance of {tolerance:g}, more than {MAX_CONTACTS:,} pairs of edges touch; "
            "make it smaller, or give fewer points"
        )
    key = pairs[:, 0] * len(points) + pairs[:, 1]
    by_key = np.argsort(key)
    key, pairs, places, distances = key[by_key], pairs[by_key], places[by_key], distances[by_key]
    roots = _components(points, curve_of, key, pairs, tolerance)
    itself = np.zeros(len(key), bool)
    itself[roots[pairs[:, 0] == pairs[:, 1]]] = True
    kept = np.flatnonzero(~itself[roots])
    kept = kept[np.argsort(roots[kept], kind="stable")]
    bounds = np.r_[0, 1 + np.flatnonzero(np.diff(roots[kept])), len(kept)].astype(np.int64)
    lasts = along[starts[1:] - 1]
    curves, lengths = _joins(
        points,
        curve_of,
        along,
        lasts,
        pairs[kept],
        places[kept],
        distances[kept],
        bounds,
        tolerance,
    )
    return Joins(curves, lengths)


@kernel
def _contacts(
    points: Points, edges: Int64Array, low: Floats, high: Floats, tolerance: float, limit: int
) -> tuple[Int64Array, Floats, Floats]:
    """All pairs of edges (first <= second) within the tolerance, an edge with itself among them.

    edges: sorted by the first coordinate of their boxes' lower corners ``low``.
    """
    capacity = 4 * len(edges) + 16
    pairs = np.empty((capacity, 2), np.int64)
    places = np.empty((capacity, 2), np.float64)
    distances = np.empty(capacity, np.float64)
    n = 0
    for i in range(len(edges)):
        for k in range(i, len(edges)):
            if low[k, 0] > high[i, 0]:
                break
            if low[k, 1] > high[i, 1] or low[i, 1] > high[k, 1]:
                continue
            if low[k, 2] > high[i, 2] or low[i, 2] > high[k, 2]:
                continue
            first, second = min(edges[i], edges[k]), max(edges[i], edges[k])
            s, u, gap = nearest_of_edges(points, first, second, BETTER * tolerance)
            if gap > tolerance:
                continue
            if n == capacity:
                if n > limit:
                    return pairs, places, distances
                capacity *= 2
                pairs = np.concatenate((pairs, np.empty_like(pairs)))
                places = np.concatenate((places, np.empty_like(places)))
                distances = np.concatenate((distances, np.empty_like(distances)))
            pairs[n, 0], pairs[n, 1] = first, second
            places[n, 0], places[n, 1] = s, u
            distances[n] = gap
            n += 1
    return pairs[:n], places[:n], distances[:n]


@kernel
def _components(
    points: Points, curve_of: Int64Array, key: Int64Array, pairs: Int64Array, tolerance: float
) -> Int64Array:
    """For every contact, sorted by key, the root of its connected part.

    The pairs of places of two edges are a convex set; it continues in the next edge if the
    vertex between them is within the tolerance.
    """
    parent = np.arange(len(key))
    n_points = len(points)
    for contact in range(len(key)):
        for side in range(2):
            vertex = pairs[contact, side] + 1
            other = pairs[contact, 1 - side]
            if vertex + 1 >= n_points or curve_of[vertex + 1] != curve_of[vertex]:
                continue
            if nearest_on_edge(points, vertex, other)[1] > tolerance:
                continue
            first, second = min(vertex, other), max(vertex, other)
            wanted = first * n_points + second
            at = np.searchsorted(key, wanted)
            if at < len(key) and key[at] == wanted:
                a, b = _root(parent, contact), _root(parent, at)
                parent[max(a, b)] = min(a, b)
    for contact in range(len(key)):
        parent[contact] = _root(parent, contact)
    return parent


@kernel
def _root(parent: Int64Array, item: int) -> int:
    while parent[item] != item:
        parent[item] = parent[parent[item]]
        item = parent[item]
    return item


@kernel
def _joins(
    points: Points,
    curve_of: Int64Array,
    along: Floats,
    lasts: Floats,
    pairs: Int64Array,
    places: Floats,
    distances: Floats,
    bounds: Int64Array,
    tolerance: float,
) -> tuple[Int64Array, Floats]:
    """The joins of all meetings; meeting m has the contacts bounds[m] to bounds[m + 1]."""
    curves = np.empty((MOST_JOINS * (len(bounds) - 1), 2), np.int64)
    lengths = np.empty((MOST_JOINS * (len(bounds) - 1), 2), np.float64)
    n = 0
    for meeting in range(len(bounds) - 1):
        begin, end = bounds[meeting], bounds[meeting + 1]
        if begin == end:
            continue
        a, b, gap, vertex = _places(
            points, along, pairs[begin:end], places[begin:end], distances[begin:end], tolerance
        )
        of_a, of_b = curve_of[pairs[begin, 0]], curve_of[pairs[begin, 1]]
        chosen = chosen_places(
            a, b, gap, vertex, len(points), float(lasts[of_a]), float(lasts[of_b]), tolerance
        )
        for place in chosen:
            curves[n, 0], curves[n, 1] = of_a, of_b
            lengths[n, 0], lengths[n, 1] = a[place], b[place]
            n += 1
    return curves[:n], lengths[:n]


@kernel
def _places(
    points: Points,
    along: Floats,
    pairs: Int64Array,
    places: Floats,
    distances: Floats,
    tolerance: float,
) -> tuple[Floats, Floats, Floats, Int64Array]:
    """Pairs of places of a meeting that tell what it is like: the closest, and all vertices.

    Returns arc lengths on A and on B, the distance, and the vertex that it is taken at: its
    number on A, its number and that of all points on B, -1 for none.
    """
    a = np.empty(5 * len(pairs), np.float64)
    b = np.empty(5 * len(pairs), np.float64)
    gap = np.empty(5 * len(pairs), np.float64)
    vertex = np.empty(5 * len(pairs), np.int64)
    n = 0
    for contact in range(len(pairs)):
        first, second = pairs[contact, 0], pairs[contact, 1]
        a[n] = _length_at(along, first, places[contact, 0])
        b[n] = _length_at(along, second, places[contact, 1])
        gap[n] = distances[contact]
        vertex[n] = -1
        n += 1
        for end in range(2):
            share, distance = nearest_on_edge(points, first + end, second)
            if distance <= tolerance:
                a[n], b[n] = along[first + end], _length_at(along, second, share)
                gap[n], vertex[n] = distance, first + end
                n += 1
            share, distance = nearest_on_edge(points, second + end, first)
            if distance <= tolerance:
                a[n], b[n] = _length_at(along, first, share), along[second + end]
                gap[n], vertex[n] = distance, len(points) + second + end
                n += 1
    return a[:n], b[:n], gap[:n], vertex[:n]


@kernel
def _length_at(along: Floats, edge: int, share: float) -> float:
    if share == 1.0:
        return along[edge + 1]
    return along[edge] + share * (along[edge + 1] - along[edge])
