"""The polygon of a rib in its plane: put together from runs, made simple, sampled with normals.

Polygons run so that the outside is on their right.
"""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.crossings import find_crossing, find_foot
from patterndb_sketch.features.ribs.walking import Drawn, Runs

#: The share of its last edge that a polygon loses where its two ends would meet.
SHORTER = 0.02


@kernel
def _at(points: Points, known: Drawn, s: Index, t: float, result: Points, n: Index) -> None:
    """Sets row n of the result to the place t of segment s, whose points are those given."""
    _, along, offsets, closed, _, _, _, _, _, _, _ = known
    low, high = offsets[s], offsets[s + 1] - 1
    if closed[s]:
        t -= float(math.floor(t / along[high]) * along[high])
    k = low + np.searchsorted(along[low : high + 1], t, side="right") - 1
    k = min(max(k, low), high - 1)
    size = along[k + 1] - along[k]
    share = min(max((t - along[k]) / size, 0.0), 1.0) if size > 0.0 else 0.0
    for c in range(2):
        d = points[k + 1, c] - points[k, c]
        result[n, c] = points[k + 1, c] if share == 1.0 else points[k, c] + share * d


@kernel
def collect_points(points: Points, known: Drawn, runs: Runs, last: bool) -> Points:
    """(k, 2) the points that runs pass, from within the first run, with those of the changes.

    points: those of the segments, in any units. last: with the end of the last run.
    """
    _, along, offsets, closed, _, _, _, _, _, _, _ = known
    segment, begin, end = runs
    room = 2 * len(segment)
    for r in range(len(segment)):
        s = segment[r]
        whole = along[offsets[s + 1] - 1]
        turns = int(abs(end[r] - begin[r]) / whole) + 2 if closed[s] else 1
        room += turns * (offsets[s + 1] - offsets[s])
    result = np.empty((room, 2))
    n = 0
    for r in range(len(segment)):
        s = segment[r]
        low, high = offsets[s], offsets[s + 1] - 1
        whole = along[high]
        if r > 0:
            _at(points, known, s, begin[r], result, n)
            n += 1
        least, most = min(begin[r], end[r]), max(begin[r], end[r])
        first = n
        turn = math.floor(least / whole) * whole if closed[s] else 0.0
        while turn <= most:
            for k in range(low, high if closed[s] else high + 1):
                # Runs that begin at a point both go on from there, and one has to take it.
                place = along[k] + turn
                if least < place < most or (r == 0 and place == begin[0]):
                    result[n] = points[k]
                    n += 1
            if not closed[s]:
                break
            turn += whole
        if end[r] < begin[r]:
            result[first:n] = result[first:n][::-1].copy()
        if last or r + 1 < len(segment):
            _at(points, known, s, end[r], result, n)
            n += 1
    return result[:n].copy()


@kernel
def thin_points(points: Points, reach: float) -> Points:
    """The points without those within reach of the one before."""
    result = points.copy()
    n = min(1, len(points))
    for k in range(1, len(points)):
        if math.hypot(points[k, 0] - result[n - 1, 0], points[k, 1] - result[n - 1, 1]) > reach:
            result[n] = points[k]
            n += 1
    return result[:n].copy()


@kernel
def find_nearest_place(points: Points) -> tuple[int, float, float]:
    """Of the polygon's place nearest to the origin: edge, share of it, distance."""
    best = np.inf
    result = (-1, 0.0, np.inf)
    for k in range(len(points) - 1):
        away, share = find_foot(points, k, 0.0, 0.0)
        if away < best:
            best = away
            result = (k, share, away)
    return result


@kernel
def _meeting(points: Points, e: Index, f: Index, reach: float) -> float:
    """The share of edge e where edge f crosses it or comes within reach; -1 if it does not."""
    for c in range(2):
        if max(points[e, c], points[e + 1, c]) + reach < min(points[f, c], points[f + 1, c]):
            return -1.0
        if min(points[e, c], points[e + 1, c]) - reach > max(points[f, c], points[f + 1, c]):
            return -1.0
    share = find_crossing(points, e, f)
    if share >= 0.0:
        return share
    for k in range(2):
        away, share = find_foot(points, e, points[f + k, 0], points[f + k, 1])
        if away <= reach:
            return share
        if find_foot(points, f, points[e + k, 0], points[e + k, 1])[0] <= reach:
            return float(k)
    return -1.0


@kernel
def cut_loops(points: Points, closed: bool, reach: float) -> Points:
    """The polygon with its loops cut off where it crosses itself, or comes within reach.

    What hangs between the two passes of a crossing goes, unless it goes around something and the
    place nearest to the origin is there, and not at the crossing: then the two ends go, and a
    little more of the last, so that they stay apart. A closed polygon, its first point also its
    last, keeps the longer part.
    """
    points = points.copy()
    again = True
    while again:
        again = False
        n = len(points)
        for e in range(n - 1):
            for f in range(e + 2, n - 1):
                if closed and e == 0 and f == n - 2:
                    continue
                share = _meeting(points, e, f, reach)
                if share < 0.0:
                    continue
                meeting = points[e : e + 1] + share * (points[e + 1 : e + 2] - points[e : e + 1])
                loop = np.concatenate((meeting, points[e + 1 : f + 1], meeting))
                rest = np.concatenate((points[: e + 1], meeting, points[f + 1 :]))
                if closed:
                    points = loop if _length(loop) > _length(rest) else rest
                elif find_nearest_place(loop)[2] < find_nearest_place(rest)[
                    2
                ] - reach and not _is_spike(loop, reach):
                    k = len(loop) - 1
                    size = math.hypot(loop[k, 0] - loop[k - 1, 0], loop[k, 1] - loop[k - 1, 1])
                    back = min(max(4.0 * reach / size, SHORTER), 1.0) if size > 0.0 else 1.0
                    loop[k] += back * (loop[k - 1] - loop[k])
                    points = loop
                else:
                    points = rest
                points = thin_points(points, reach)
                if closed:
                    points[len(points) - 1] = points[0]
                again = True
                break
            if again:
                break
    return points


@kernel
def _is_spike(loop: Points, reach: float) -> bool:
    """Does a loop go out and back the same way?"""
    area = 0.0
    for k in range(len(loop) - 1):
        area += (loop[k, 0] - loop[0, 0]) * (loop[k + 1, 1] - loop[0, 1])
        area -= (loop[k, 1] - loop[0, 1]) * (loop[k + 1, 0] - loop[0, 0])
    return abs(area) <= 2.0 * reach * _length(loop)


@kernel
def _length(points: Points) -> float:
    total = 0.0
    for k in range(len(points) - 1):
        total += math.hypot(points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1])
    return total


@kernel
def compute_normals(points: Points, closed: bool) -> Points:
    """(k, 2) unit normals to the right: the mean of the two edges' normals, by their lengths.

    A rounded edge keeps the normals of the flat sides that it joins. Where a polygon turns right
    back, the normal of the edge before.
    """
    n = len(points)
    normals = np.zeros((n, 2))
    for k in range(n - 1):
        dx = points[k + 1, 0] - points[k, 0]
        dy = points[k + 1, 1] - points[k, 1]
        for v in (k, k + 1):
            normals[v, 0] += dy
            normals[v, 1] -= dx
    if closed:
        normals[0] += normals[n - 1]
        normals[n - 1] = normals[0]
    for v in range(n):
        size = math.hypot(normals[v, 0], normals[v, 1])
        k = max(v - 1, 0)
        dx, dy = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        edge = math.hypot(dx, dy)
        if size <= 1e-9 * edge:
            normals[v, 0], normals[v, 1], size = dy, -dx, edge
        normals[v] /= size
    return normals


@kernel
def sample_polygon(points: Points, closed: bool, count: int) -> tuple[Points, Points, int]:
    """Samples (count, 2) at equal arc length with unit normals (count, 2), and the number of the
    one nearest to the origin.

    A closed polygon is cut open opposite the origin. Normals are interpolated along edges
    between those of the vertices: feature curve recovery paper, section 4.3.3.
    """
    n = len(points)
    along = np.zeros(n)
    for k in range(1, n):
        along[k] = along[k - 1] + math.hypot(
            points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1]
        )
    whole = along[n - 1]
    normals = compute_normals(points, closed)
    begin = 0.0
    if closed:
        k, share, _ = find_nearest_place(points)
        begin = along[k] + share * (along[k + 1] - along[k]) + 0.5 * whole
    samples = np.empty((count, 2))
    directions = np.empty((count, 2))
    nearest = -1
    least = np.inf
    k = 0
    for i in range(count):
        t = begin + whole * i / (count - 1)
        if closed:
            t -= math.floor(t / whole) * whole
            if k > 0 and t < along[k]:
                k = 0
        while k < n - 2 and along[k + 1] < t:
            k += 1
        size = along[k + 1] - along[k]
        s = min(max((t - along[k]) / size, 0.0), 1.0) if size > 0.0 else 0.0
        for c in range(2):
            samples[i, c] = (1.0 - s) * points[k, c] + s * points[k + 1, c]
            directions[i, c] = (1.0 - s) * normals[k, c] + s * normals[k + 1, c]
        size = math.hypot(directions[i, 0], directions[i, 1])
        if size <= 1e-9:
            directions[i] = normals[k]
        else:
            directions[i] /= size
        away = math.hypot(samples[i, 0], samples[i, 1])
        if away < least:
            least = away
            nearest = i
    return samples, directions, nearest
