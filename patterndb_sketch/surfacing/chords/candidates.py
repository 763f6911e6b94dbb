"""Candidate chords: from every end to the nearest corner and to the closest point across."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.network import InvalidNetworkError
from patterndb_sketch.surfacing.sampling import Loop

#: Two lengths, angles or coordinates count as equal below this share of their scale. A curve
#: sampled from its other end gives points that differ in the 16th digit; 1e-9 is far above
#: that, and far below what can be seen.
#: The same as in rust/surfacing/src/chords/candidates.rs.
SAME = 1e-9

#: A smooth stretch that turns by more than this gets an end inside, in radians: 45 degrees. The
#: paper bounds the turning without saying by what. The bend of an eighth of a circle rises 1/10
#: of its chord above it, little enough for one nearly flat piece.
TURNING_BOUND = math.radians(45)

#: A maximum of curvature counts where it exceeds the mean around it by this factor: a circle,
#: and the ripple of a polyline that was sampled again, has no maxima. Own choice.
PROMINENCE = 1.25

#: Sines of the most that a chord may lean out of the curve's normal plane where it starts: 40
#: degrees towards a corner, 30 towards the closest point (Abbasinejad et al. 2013, section 3.1).
TO_CORNER = math.sin(math.radians(40))
TO_CLOSEST = math.sin(math.radians(30))

#: A chord hugs the loop where the shorter way along the loop is no longer than this many times
#: the chord: it would cut off a sliver. Spec: 1.15; an arc of a circle reaches it at 104 degrees.
#: The same as in rust/surfacing/src/chords/candidates.rs.
HUGGING = 1.15

#: Points are near each other within two edges of the loop, or this share of the chord's length.
#: The same as in rust/surfacing/src/chords/candidates.rs.
NEAR_EDGES = 2.0
NEAR_SHARE = 0.25


@kernel
def measure_extent(points: NDArray[np.float64]) -> float:
    """The longest side of the box around points (n, 3)."""
    longest = 0.0
    for d in range(3):
        least, most = np.inf, -np.inf
        for i in range(len(points)):
            least = min(least, points[i, d])
            most = max(most, points[i, d])
        longest = max(longest, most - least)
    return longest


@kernel
def compare_points(a: NDArray[np.float64], b: NDArray[np.float64], tolerance: float) -> int:
    """-1 if point a comes before b, 1 if after, 0 if they are the same: by x, then y, then z."""
    for d in range(3):
        if abs(a[d] - b[d]) > tolerance:
            return -1 if a[d] < b[d] else 1
    return 0


@kernel
def order_canonically(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n,) positions of a loop's points (n, 3) in the canonical traversal.

    It begins at the vertex with the least x, then y, then z, and goes on to the side where, at
    the first step that differs, x, then y, then z is less. Coordinates within SAME of the
    loop's extent are equal.
    """
    n = len(points)
    tolerance = SAME * measure_extent(points)
    among = np.ones(n, np.bool_)
    for d in range(3):
        least = np.inf
        for i in range(n):
            if among[i] and points[i, d] < least:
                least = points[i, d]
        for i in range(n):
            if among[i] and points[i, d] > least + tolerance:
                among[i] = False
    start = 0
    while not among[start]:
        start += 1
    step = 1
    decided = False
    for s in range(1, n):
        if decided:
            break
        side = compare_points(points[(start + s) % n], points[(start - s) % n], tolerance)
        if side != 0:
            step = -side
            decided = True
    order = np.empty(n, np.int64)
    for s in range(n):
        order[s] = (start + s * step) % n
    return order


@kernel
def measure_turning(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) turning angle in radians at every vertex of a closed polyline (n, 3)."""
    n = len(points)
    turning = np.empty(n)
    for i in range(n):
        before = points[i] - points[i - 1]
        after = points[(i + 1) % n] - points[i]
        x = before[1] * after[2] - before[2] * after[1]
        y = before[2] * after[0] - before[0] * after[2]
        z = before[0] * after[1] - before[1] * after[0]
        along = before[0] * after[0] + before[1] * after[1] + before[2] * after[2]
        turning[i] = math.atan2(math.sqrt(x * x + y * y + z * z), along)
    return turning


def find_endpoints(loop: Loop, turning_bound: float = TURNING_BOUND) -> NDArray[np.int64]:
    """(e,) positions in the loop, ascending, from which chords start.

    All corners; then, wherever the loop turns between two ends by more than ``turning_bound``
    (radians, above 0), a local maximum of curvature if there is one, else samples that part the
    turning evenly. Strictly between neighbouring ends the loop turns by no more than the bound.
    The answer does not depend on where the loop starts and which way it runs.

    Raises InvalidNetworkError for a bound that is not above 0 and finite.
    Source: Abbasinejad et al. 2013, section 3.1. Differs from the paper: it walks along the
    cycle and places samples as it goes, which would depend on start and sense; here the
    turning between two ends is parted evenly.
    """
    if not (math.isfinite(turning_bound) and turning_bound > 0):
        raise InvalidNetworkError(
            f"the turning bound is {turning_bound}; give an angle in radians above 0"
        )
    points, corners = np.ascontiguousarray(loop.points), np.ascontiguousarray(loop.corners)
    return np.flatnonzero(_endpoints(points, corners, float(turning_bound)))


@kernel
def _endpoints(
    points: NDArray[np.float64], corners: NDArray[np.bool_], bound: float
) -> NDArray[np.bool_]:
    n = len(points)
    order = order_canonically(points)
    points = points[order]
    turning = measure_turning(points)
    tolerance = SAME * measure_extent(points)
    is_end = corners[order]
    if not is_end.any():
        is_end[_first_largest(points, turning, tolerance)] = True
    stack = np.empty((n + 1, 2), np.int64)
    ends = np.flatnonzero(is_end)
    for i in range(len(ends)):
        stack[i, 0] = ends[i]
        stack[i, 1] = ends[i + 1] if i + 1 < len(ends) else ends[0] + n
    height = len(ends)
    while height:
        height -= 1
        a, b = stack[height, 0], stack[height, 1]
        total = 0.0
        for v in range(a + 1, b):
            total += turning[v % n]
        if total <= bound * (1.0 + SAME):
            continue
        top = _maximum(points, turning, a, b, bound / 2.0, tolerance)
        if top >= 0:
            is_end[top % n] = True
            stack[height, 0], stack[height, 1] = a, top
            stack[height + 1, 0], stack[height + 1, 1] = top, b
            height += 2
        else:
            parts = math.ceil(total / bound - SAME)
            _part(points, turning, a, b, total, parts, tolerance, is_end)
    ends = np.zeros(n, np.bool_)
    for i in range(n):
        ends[order[i]] = is_end[i]
    return ends


@kernel
def _first_largest(
    points: NDArray[np.float64], values: NDArray[np.float64], tolerance: float
) -> int:
    """Where the largest value is; of those equal within SAME, at the point that comes first."""
    best = 0
    for i in range(1, len(values)):
        if values[i] > values[best] + SAME or (
            values[i] >= values[best] - SAME
            and compare_points(points[i], points[best], tolerance) < 0
        ):
            best = i
    return best


@kernel
def _smoothed(turning: NDArray[np.float64], v: int, a: int, b: int) -> float:
    """The turning at v and its neighbours with weights 1, 2, 1; ends a and b are left out."""
    n = len(turning)
    total, weight = 2.0 * turning[v % n], 2.0
    if v - 1 > a:
        total += turning[(v - 1) % n]
        weight += 1.0
    if v + 1 < b:
        total += turning[(v + 1) % n]
        weight += 1.0
    return total / weight


@kernel
def _maximum(
    points: NDArray[np.float64],
    turning: NDArray[np.float64],
    a: int,
    b: int,
    reach: float,
    tolerance: float,
) -> int:
    """The vertex between a and b that is the highest maximum of curvature, or -1.

    A maximum is highest, and prominent, among the vertices from which the loop turns by no
    more than ``reach`` on the way to it. The first and last vertex of a stretch are none: there
    curvature may just be falling off from the end.
    """
    n = len(turning)
    smooth = np.empty(b - a)
    for v in range(a + 1, b):
        smooth[v - a] = _smoothed(turning, v, a, b)
    found, height = -1, 0.0
    for v in range(a + 2, b - 1):
        here = smooth[v - a]
        if found >= 0 and (
            here < height - SAME
            or (
                here <= height + SAME
                and compare_points(points[v % n], points[found % n], tolerance) > 0
            )
        ):
            continue
        total, count, highest = here, 1, True
        for sense in (-1, 1):
            u, turned = v + sense, 0.0
            while a < u < b and highest and turned <= reach:
                total += smooth[u - a]
                count += 1
                highest = smooth[u - a] <= here + SAME
                turned += turning[u % n]
                u += sense
        if highest and here > PROMINENCE * total / count:
            found, height = v, here
    return found


@kernel
def _part(
    points: NDArray[np.float64],
    turning: NDArray[np.float64],
    a: int,
    b: int,
    total: float,
    parts: int,
    tolerance: float,
    is_end: NDArray[np.bool_],
) -> None:
    """Mark the vertices between a and b where 1, 2, .. of ``parts`` of the turning are reached.

    Where one is reached just between two vertices, the one that comes first is marked: of two
    curves side by side, walked in opposite senses, those are opposite each other.
    """
    n = len(turning)
    turned, part = 0.0, 1
    for v in range(a + 1, b):
        turned += turning[v % n]
        while part < parts and turned >= part * total / parts - SAME:
            chosen = v
            between = turned <= part * total / parts + SAME and v + 1 < b
            if between and compare_points(points[(v + 1) % n], points[v % n], tolerance) < 0:
                chosen = v + 1
            is_end[chosen % n] = True
            part += 1


@dataclass(frozen=True, slots=True)
class Candidates:
    """The chords that a search may choose from.

    chords:      (c, 2) int64 positions i < j in the loop, ascending, no two alike.
    ends:        (e,) int64 positions of the ends that were given, ascending.
    n_made:      how many of the chords' ends are none of those: closest points of their own.
    n_unmatched: how many of the given ends no chord has.
    """

    chords: NDArray[np.int64] = field(repr=False)
    ends: NDArray[np.int64] = field(repr=False)
    n_made: int
    n_unmatched: int


def find_candidates(loop: Loop, ends: NDArray[np.int64]) -> Candidates:
    """Chords from the ends (e,), positions in the loop, nearly perpendicular to it there.

    Each end has up to two: one to the nearest corner within 40 degrees of the normal plane, one
    to the closest point within 30. The latter ends at another end near the closest point, if one
    qualifies. If the corner is near the closest point, only the chord to the corner is kept.
    At a corner, the curve's tangent is the incoming or the outgoing edge's or half between. No
    chord joins neighbours or hugs the loop (HUGGING). The answer does not depend on where the
    loop starts and which way it runs.

    Source: Abbasinejad et al. 2013, section 3.1. Differs from the paper: it asks in one sentence
    to drop the chord of an end without a corner, and promises in another at least one chord for
    every end; here the chord to the closest point stays, an end may have none, and
    ``n_unmatched`` counts those. The paper's "close together" is NEAR_EDGES and NEAR_SHARE here.
    """
    given = np.unique(np.asarray(ends, np.int64))
    points, corners = np.ascontiguousarray(loop.points), np.ascontiguousarray(loop.corners)
    pairs = np.sort(_candidates(points, corners, given), axis=1)
    n = len(points)
    chords = np.stack(np.divmod(np.unique(pairs[:, 0] * n + pairs[:, 1]), n), axis=1)
    used = np.unique(chords)
    matched = int(np.isin(given, used, assume_unique=True).sum())
    return Candidates(chords, given, len(used) - matched, len(given) - matched)


@kernel
def _distance(points: NDArray[np.float64], a: int, b: int) -> float:
    x = points[a, 0] - points[b, 0]
    y = points[a, 1] - points[b, 1]
    z = points[a, 2] - points[b, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def _tangents(
    points: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit tangents (3, n, 3): of the edge before, the edge after, and half between; and (n,)
    the lengths of the edges after the vertices."""
    n = len(points)
    tangents = np.zeros((3, n, 3))
    lengths = np.empty(n)
    for i in range(n):
        following = (i + 1) % n
        lengths[i] = _distance(points, i, following)
        if lengths[i] > 0.0:
            for d in range(3):
                tangents[1, i, d] = (points[following, d] - points[i, d]) / lengths[i]
                tangents[0, following, d] = tangents[1, i, d]
    for i in range(n):
        size = 0.0
        for d in range(3):
            tangents[2, i, d] = tangents[0, i, d] + tangents[1, i, d]
            size += tangents[2, i, d] ** 2
        size = math.sqrt(size)
        for d in range(3):
            # Where the loop turns back on itself, nothing is half between.
            tangents[2, i, d] = tangents[2, i, d] / size if size > SAME else 0.0
    return tangents, lengths


@kernel
def _leaning(
    points: NDArray[np.float64], tangents: NDArray[np.float64], corner: bool, e: int, p: int
) -> float:
    """The sine of the angle between the chord from e to p and the normal plane at e."""
    length = _distance(points, e, p)
    least = 1.0
    for kind in range(3) if corner else range(2, 3):
        along = 0.0
        size = 0.0
        for d in range(3):
            along += (points[p, d] - points[e, d]) * tangents[kind, e, d]
            size += abs(tangents[kind, e, d])
        if size > 0.0:
            least = min(least, abs(along) / length)
    return least


@kernel
def _cuts(points: NDArray[np.float64], along: NDArray[np.float64], e: int, p: int) -> bool:
    """Does the chord from e to p cut off more than a sliver, and join no neighbours?"""
    n = len(points)
    apart = abs(e - p)
    if apart < 2 or apart > n - 2:
        return False
    way = abs(along[p] - along[e])
    way = min(way, along[n] - way)
    length = _distance(points, e, p)
    return length > SAME * along[n] and way > HUGGING * length * (1.0 + SAME)


@kernel
def _near(points: NDArray[np.float64], a: int, b: int, length: float, edge: float) -> bool:
    """Is a near b, which is at the end of a chord of this length?"""
    return _distance(points, a, b) <= max(NEAR_EDGES * edge, NEAR_SHARE * length) * (1.0 + SAME)


@kernel
def _candidates(
    given_points: NDArray[np.float64], given_corners: NDArray[np.bool_], ends: NDArray[np.int64]
) -> NDArray[np.int64]:
    n = len(given_points)
    order = order_canonically(given_points)
    points = given_points[order]
    corners = given_corners[order]
    tangents, lengths = _tangents(points)
    along = np.zeros(n + 1)
    for i in range(n):
        along[i + 1] = along[i] + lengths[i]
    tolerance = SAME * along[n]
    edge = along[n] / n
    is_end = np.zeros(n, np.bool_)
    for e in ends:
        is_end[e] = True
    is_end = is_end[order]
    from_ends = np.flatnonzero(is_end)
    joined = np.zeros((len(from_ends), 2), np.int64)
    chords = np.empty((2 * len(from_ends), 2), np.int64)
    n_chords = 0
    # The chords to corners, and where the closest points are.
    reach = np.empty(len(from_ends))
    for row in range(len(from_ends)):
        e = from_ends[row]
        corner, closest = -1, -1
        to_corner, to_closest = np.inf, np.inf
        for p in range(n):
            length = _distance(points, e, p)
            farther_corner = not corners[p] or length >= to_corner - tolerance
            if (farther_corner and length >= to_closest - tolerance) or not _cuts(
                points, along, e, p
            ):
                continue
            leaning = _leaning(points, tangents, bool(corners[e]), e, p)
            if not farther_corner and leaning <= TO_CORNER + SAME:
                corner, to_corner = p, length
            if length < to_closest - tolerance and leaning <= TO_CLOSEST + SAME:
                closest, to_closest = p, length
        if corner >= 0:
            chords[n_chords, 0], chords[n_chords, 1] = order[e], order[corner]
            n_chords += 1
            if closest >= 0 and _near(points, corner, closest, to_closest, edge):
                closest = -1
        joined[row, 0], joined[row, 1] = e, closest
        reach[row] = to_closest if closest >= 0 else np.inf
    # The chords to closest points, shortest first: an end that one makes serves the others.
    for row in _ascending(reach, tolerance):
        e, closest = joined[row, 0], joined[row, 1]
        if closest < 0:
            continue
        chosen, to_chosen = closest, np.inf
        if not is_end[closest]:
            for q in range(n):
                if not is_end[q] or not _near(points, q, closest, float(reach[row]), edge):
                    continue
                length = _distance(points, e, q)
                if (
                    length < to_chosen - tolerance
                    and _cuts(points, along, e, q)
                    and _leaning(points, tangents, bool(corners[e]), e, q) <= TO_CLOSEST + SAME
                ):
                    chosen, to_chosen = q, length
            is_end[chosen] = True
        chords[n_chords, 0], chords[n_chords, 1] = order[e], order[chosen]
        n_chords += 1
    return chords[:n_chords]


@kernel
def _ascending(values: NDArray[np.float64], tolerance: float) -> NDArray[np.int64]:
    """The order of the values, where those equal within the tolerance keep theirs."""
    rows = np.arange(len(values))
    for i in range(1, len(rows)):
        row, at = rows[i], i
        while at > 0 and values[rows[at - 1]] > values[row] + tolerance:
            rows[at] = rows[at - 1]
            at -= 1
        rows[at] = row
    return rows
