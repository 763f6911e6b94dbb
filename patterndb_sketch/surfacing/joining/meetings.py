"""Where polylines meet: kernels that find the places at which two of them come together.

Take a pair of curves, A and B, and all pairs of places (a on A, b on B) that are within the
tolerance of each other: the lesser reach of the two curves. The connected parts of this set are the
meetings: one for each crossing, touching end or common stretch. For one curve with itself, the part
around a = b is none.

Points stand in one array (n, 3); edge i runs from point i to point i + 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.joining.polylines import PackedCurves
from patterndb_sketch.surfacing.network import InvalidNetworkError

#: Pairs of edges within the tolerance that are looked at: 40 bytes each.
MAX_CONTACTS = 5_000_000

#: A meeting longer than this many tolerances may be a common stretch: edges that cross at 30
#: degrees are within the tolerance of each other for 4 of them.
LONG = 4.0

#: A long meeting is a common stretch if the median distance within it exceeds the least by less
#: than this share of the tolerance. Crossing lines have 0.5, touching arcs 0.25.
FLAT = 0.1

#: ... or if the distance goes up and down by this share of the tolerance more than once.
WAVERING = 0.25

#: Where neither curve ends, curves may touch, or cross twice because they were drawn a little too
#: near: they run along each other if this share of the distances exceeds the least by less than
#: FLAT, or if they waver by this many tolerances.
MOST_FLAT = 0.75
MOST_WAVERING = 1.0

#: The end of a common stretch is looked for so many tolerances inwards of its last pair of places.
INWARDS = 4.0

#: A crossing within edges must be closer than their ends by this share of the tolerance:
#: otherwise the curves are cut at a point that they have.
BETTER = 1e-3

#: Most pairs of places that one meeting joins: the four pairs of ends, and both extremes.
MOST_JOINS = 6


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
    roots = _components(points, curve_of, key, pairs, reaches)
    itself = np.zeros(len(key), bool)
    itself[roots[_is_beside_itself(curves, pairs, reaches)]] = True
    kept = np.flatnonzero(~itself[roots])
    kept = kept[np.argsort(roots[kept], kind="stable")]
    bounds = np.r_[0, 1 + np.flatnonzero(np.diff(roots[kept])), len(kept)].astype(np.int64)
    return Joins(
        *_joins(
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
    pairs, places, distances = _contacts(
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


@kernel
def _contacts(
    points: Points,
    along: Floats,
    curve_of: Int64Array,
    edges: Int64Array,
    low: Floats,
    high: Floats,
    reaches: Floats,
    settled: NDArray[np.bool_],
    limit: int,
) -> tuple[Int64Array, Floats, Floats]:
    """Find all pairs of edges (first <= second) within reach, as :func:`find_contacts` does.

    edges: sorted by the first coordinate of their boxes' lower corners ``low``.
    """
    capacity = 4 * len(edges) + 16
    pairs = np.empty((capacity, 2), np.int64)
    places = np.empty((capacity, 2), np.float64)
    distances = np.empty(capacity, np.float64)
    n = 0
    for i in range(len(edges)):
        of_i = curve_of[edges[i]]
        for k in range(i, len(edges)):
            if low[k, 0] > high[i, 0]:
                break
            if low[k, 1] > high[i, 1] or low[i, 1] > high[k, 1]:
                continue
            if low[k, 2] > high[i, 2] or low[i, 2] > high[k, 2]:
                continue
            of_k = curve_of[edges[k]]
            tolerance = min(float(reaches[of_i]), float(reaches[of_k]))
            first, second = min(edges[i], edges[k]), max(edges[i], edges[k])
            if of_i == of_k and along[second + 1] - along[first] <= tolerance:
                continue
            if of_i != of_k and settled[of_i] and settled[of_k]:
                continue
            s, u, gap = find_nearest_of_edges(points, first, second, BETTER * tolerance)
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
    points: Points, curve_of: Int64Array, key: Int64Array, pairs: Int64Array, reaches: Floats
) -> Int64Array:
    """Find for every contact, sorted by key, the root of its connected part.

    The pairs of places of two edges are a convex set; it continues in the next edge if the
    vertex between them is within reach.
    """
    parent = np.arange(len(key))
    n_points = len(points)
    for contact in range(len(key)):
        of_first, of_second = curve_of[pairs[contact, 0]], curve_of[pairs[contact, 1]]
        tolerance = min(float(reaches[of_first]), float(reaches[of_second]))
        for side in range(2):
            vertex = pairs[contact, side] + 1
            other = pairs[contact, 1 - side]
            if vertex + 1 >= n_points or curve_of[vertex + 1] != curve_of[vertex]:
                continue
            if find_nearest_on_edge(points, vertex, other)[1] > tolerance:
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
    reaches: Floats,
    closed: NDArray[np.bool_],
) -> tuple[Int64Array, Floats, Floats, Int64Array]:
    """Choose the joins of all meetings; meeting m has the contacts bounds[m] to bounds[m + 1].

    Returns the curves (m, 2), the lengths (m, 2), the gaps (m,) and the meetings (m,).
    """
    most = MOST_JOINS * (len(bounds) - 1)
    curves, lengths = np.empty((most, 2), np.int64), np.empty((most, 2), np.float64)
    gaps, meetings = np.empty(most, np.float64), np.empty(most, np.int64)
    n = 0
    for meeting in range(len(bounds) - 1):
        begin, end = bounds[meeting], bounds[meeting + 1]
        if begin == end:
            continue
        of_a, of_b = curve_of[pairs[begin, 0]], curve_of[pairs[begin, 1]]
        tolerance = min(float(reaches[of_a]), float(reaches[of_b]))
        a, b, gap, vertex = _places(
            points, along, pairs[begin:end], places[begin:end], distances[begin:end], tolerance
        )
        chosen = choose_places(
            a,
            b,
            gap,
            vertex,
            len(points),
            float(lasts[of_a]),
            float(lasts[of_b]),
            tolerance,
            bool(closed[of_a] and closed[of_b]),
        )
        for place in chosen:
            curves[n, 0], curves[n, 1] = of_a, of_b
            lengths[n, 0], lengths[n, 1] = a[place], b[place]
            gaps[n], meetings[n] = gap[place], meeting
            n += 1
    return curves[:n], lengths[:n], gaps[:n], meetings[:n]


@kernel
def _places(
    points: Points,
    along: Floats,
    pairs: Int64Array,
    places: Floats,
    distances: Floats,
    tolerance: float,
) -> tuple[Floats, Floats, Floats, Int64Array]:
    """List pairs of places of a meeting that tell what it is like: the closest, and all vertices.

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
            share, distance = find_nearest_on_edge(points, first + end, second)
            if distance <= tolerance:
                a[n], b[n] = along[first + end], _length_at(along, second, share)
                gap[n], vertex[n] = distance, first + end
                n += 1
            share, distance = find_nearest_on_edge(points, second + end, first)
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


@kernel
def choose_places(
    a: Floats,
    b: Floats,
    gap: Floats,
    vertex: Int64Array,
    n_points: int,
    last_a: float,
    last_b: float,
    tolerance: float,
    closed: bool,
) -> Int64Array:
    """Choose which pairs of places of a meeting are joined: one for a crossing, two for a stretch.

    a, b: their arc lengths on the curves A and B. gap: how far apart they are. vertex: where
    they are taken, see :func:`_places`. last_a, last_b: the lengths of the curves. closed: both
    are closed.
    """
    # The closest pair of each two ends; the pairs of ends are 0 to 3.
    ends = np.full(4, -1)
    for place in range(len(a)):
        if (a[place] == 0 or a[place] == last_a) and (b[place] == 0 or b[place] == last_b):
            pair = 2 * int(a[place] != 0) + int(b[place] != 0)
            if ends[pair] < 0 or gap[place] < gap[ends[pair]]:
                ends[pair] = place
    ends = ends[ends >= 0]
    long = max(a.max() - a.min(), b.max() - b.min()) > LONG * tolerance
    inner = True
    if not closed:
        for place in range(len(a)):
            if a[place] == 0 or a[place] == last_a or b[place] == 0 or b[place] == last_b:
                inner = False
    alongside = long and _runs_alongside(gap, vertex, n_points, tolerance, inner)
    if len(ends) < 2 and not alongside:
        if len(ends):
            return ends
        best = 0
        for place in range(len(a)):
            if (gap[place], a[place], b[place]) < (gap[best], a[best], b[best]):
                best = place
        return np.array([best])
    # A common stretch: B runs along A in the same sense, or against it.
    covariance = ((a - a.mean()) * (b - b.mean())).sum()
    run = a + b if covariance >= 0 else a - b
    first = _extreme(run, gap, a, b, last_a, last_b, tolerance)
    second = _extreme(-run, gap, a, b, last_a, last_b, tolerance)
    return np.concatenate((ends, np.array([first, second])))


@kernel
def _extreme(
    run: Floats,
    gap: Floats,
    a: Floats,
    b: Floats,
    last_a: float,
    last_b: float,
    tolerance: float,
) -> int:
    """Find where a common stretch begins: at an end of A or B if one is there, else nearby."""
    least = run.min()
    best = -1
    best_key = (2, 0.0, 0.0)
    for place in range(len(run)):
        if run[place] > least + INWARDS * tolerance:
            continue
        at_end = a[place] == 0 or a[place] == last_a or b[place] == 0 or b[place] == last_b
        # Distances that differ by rounding count as one: then the outermost is taken.
        step = math.floor(gap[place] / (BETTER * tolerance)) if tolerance > 0 else 0.0
        key = (0 if at_end else 1, step, run[place])
        if best < 0 or key < best_key:
            best, best_key = place, key
    return best


@kernel
def _runs_alongside(
    gap: Floats, vertex: Int64Array, n_points: int, tolerance: float, inner: bool
) -> bool:
    """Does the distance stay flat or waver, rather than fall to one place and rise again?

    inner: neither curve ends there.
    """
    profile = _profile(gap[vertex >= n_points], vertex[vertex >= n_points])
    on_a = (vertex >= 0) & (vertex < n_points)
    of_a = _profile(gap[on_a], vertex[on_a])
    if len(of_a) >= len(profile):
        profile = of_a
    if len(profile) == 0:
        return False
    least = gap.min()
    there_and_back = profile[0] + profile[-1] - 2 * profile.min()
    wavering = np.abs(np.diff(profile)).sum() - there_and_back
    usual = np.quantile(profile, MOST_FLAT if inner else 0.5)
    most = MOST_WAVERING if inner else WAVERING
    return usual - least < FLAT * tolerance or wavering > most * tolerance


@kernel
def _profile(gap: Floats, vertex: Int64Array) -> Floats:
    """Take the least distance at every vertex, in the order along the curve."""
    order = np.argsort(vertex)
    profile = np.empty(len(order), np.float64)
    n = 0
    for i in range(len(order)):
        if i > 0 and vertex[order[i]] == vertex[order[i - 1]]:
            profile[n - 1] = min(profile[n - 1], gap[order[i]])
        else:
            profile[n] = gap[order[i]]
            n += 1
    return profile[:n]


@kernel
def find_nearest_on_edge(points: Points, vertex: int, edge: int) -> tuple[float, float]:
    """Find the place on an edge, 0 to 1, nearest to a vertex, and the distance."""
    along = 0.0
    square = 0.0
    for d in range(3):
        step = points[edge + 1, d] - points[edge, d]
        along += step * (points[vertex, d] - points[edge, d])
        square += step * step
    share = 0.0
    if square > 0:
        share = min(1.0, max(0.0, along / square))
    gap = 0.0
    for d in range(3):
        at = points[edge, d] + share * (points[edge + 1, d] - points[edge, d])
        if share == 1.0:
            at = points[edge + 1, d]
        gap += (points[vertex, d] - at) ** 2
    return share, math.sqrt(gap)


@kernel
def measure_distance_to_edge(points: Points, edge: int, place: Points) -> float:
    """Measure how far a place (3,) is from an edge."""
    along = 0.0
    square = 0.0
    for d in range(3):
        step = points[edge + 1, d] - points[edge, d]
        along += step * (place[d] - points[edge, d])
        square += step * step
    share = min(1.0, max(0.0, along / square)) if square > 0.0 else 0.0
    gap = 0.0
    for d in range(3):
        at = points[edge, d] + share * (points[edge + 1, d] - points[edge, d])
        gap += (place[d] - at) ** 2
    return math.sqrt(gap)


@kernel
def find_nearest_of_edges(
    points: Points, first: int, second: int, margin: float
) -> tuple[float, float, float]:
    """Find the places on two edges, 0 to 1, nearest to each other, and the distance.

    Ends are taken unless places within both edges are closer by more than the margin.
    """
    share, best = find_nearest_on_edge(points, first, second)
    s, u = 0.0, share
    share, gap = find_nearest_on_edge(points, first + 1, second)
    if gap < best:
        s, u, best = 1.0, share, gap
    share, gap = find_nearest_on_edge(points, second, first)
    if gap < best:
        s, u, best = share, 0.0, gap
    share, gap = find_nearest_on_edge(points, second + 1, first)
    if gap < best:
        s, u, best = share, 1.0, gap
    a = b = c = d = e = 0.0
    for k in range(3):
        along_first = points[first + 1, k] - points[first, k]
        along_second = points[second + 1, k] - points[second, k]
        between = points[first, k] - points[second, k]
        a += along_first * along_first
        b += along_first * along_second
        c += along_second * along_second
        d += along_first * between
        e += along_second * between
    determinant = a * c - b * b
    # Nearly parallel lines come nearest somewhere far off, or anywhere.
    if determinant > 1e-14 * a * c:
        inner_s = (b * e - c * d) / determinant
        inner_u = (a * e - b * d) / determinant
        if 0 < inner_s < 1 and 0 < inner_u < 1:
            gap = 0.0
            for k in range(3):
                on_first = points[first, k] + inner_s * (points[first + 1, k] - points[first, k])
                on_second = points[second, k] + inner_u * (
                    points[second + 1, k] - points[second, k]
                )
                gap += (on_first - on_second) ** 2
            gap = math.sqrt(gap)
            if gap < best - margin:
                s, u, best = inner_s, inner_u, gap
    return s, u, best


@kernel
def measure_deviation(points: Points, other: Points) -> float:
    """Measure how far a point of one polyline (k, 3) lies at most from another one (m, 3)."""
    greatest = 0.0
    both = np.concatenate((points, other))
    for i in range(len(points)):
        nearest = np.inf
        for edge in range(len(points), len(both) - 1):
            nearest = min(nearest, find_nearest_on_edge(both, i, edge)[1])
        greatest = max(greatest, nearest)
    return greatest
