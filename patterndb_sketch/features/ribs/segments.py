"""Segments: cut edges joined along the surface patches, then end to end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.slicing import RIM, Slice

#: Ends this close, as a share of the model's diagonal, are stitched, and points of a segment this
#: close are one. Coordinates in files have some seven digits.
STITCH = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Polylines in the plane of a slice, none of a single point.

    points:  (p, 2) float64. offsets: (s + 1,) int32: segment i has the points
             ``offsets[i]:offsets[i + 1]``; a closed one ends with its first point.
    closed:  (s,) bool. rims: (s, 2) bool, is the first, the last point on the circle?
    """

    points: Points
    offsets: Int32Array
    closed: Bools
    rims: Bools

    def __len__(self) -> int:
        return len(self.closed)

    def __getitem__(self, i: int) -> Points:
        """(k, 2) the points of segment i."""
        return self.points[self.offsets[i] : self.offsets[i + 1]]


def segments_of(cut: Slice, tolerance: float) -> Segments:
    """The segments of a slice.

    Cut edges join where they cut the same mesh edge, so long as no third one does; then ends
    join that lie within ``tolerance`` of each other, so long as no third one does.
    Source: feature curve recovery paper, section 4.3.2.
    """
    return Segments(*joined(cut.ends, cut.keys, tolerance))


@kernel
def _nodes(keys: NDArray[np.int64]) -> tuple[Int32Array, int]:
    """(2 e,) the node of each end, and how many there are; ends on the circle have their own."""
    flat = keys.reshape(-1)
    order = np.argsort(flat, kind="mergesort")
    node = np.empty(len(flat), np.int32)
    n = -1
    for i in range(len(order)):
        k = order[i]
        if i == 0 or flat[k] == RIM or flat[k] != flat[order[i - 1]]:
            n += 1
        node[k] = n
    return node, n + 1


@kernel
def _mates(node: Int32Array, n: int) -> Int32Array:
    """(2 e,) the end at the same node, where a node has just two; else -1."""
    degree = np.zeros(n, np.int32)
    last = np.full(n, -1, np.int32)
    mate = np.full(len(node), -1, np.int32)
    for k in range(len(node)):
        degree[node[k]] += 1
        if last[node[k]] >= 0:
            mate[k] = last[node[k]]
            mate[mate[k]] = k
        last[node[k]] = k
    for k in range(len(node)):
        if degree[node[k]] != 2:
            mate[k] = -1
    return mate


@kernel
def strung(mate: Int32Array) -> tuple[Int32Array, Int32Array, Bools]:
    """Pieces with two ends each, 2 i and 2 i + 1, strung up where ends are mates.

    The ends (m,) where pieces are entered, in turn; offsets (s + 1,) of the strings; and which
    (s,) are closed. Open strings come first.
    """
    m = len(mate) // 2
    entered = np.empty(m, np.int32)
    offsets = np.empty(m + 1, np.int32)
    closed = np.zeros(m, np.bool_)
    used = np.zeros(m, np.bool_)
    n = 0
    s = 0
    offsets[0] = 0
    for loops in range(2):
        for k in range(2 * m):
            if used[k >> 1] or (loops == 0 and mate[k] >= 0):
                continue
            at = k
            while at >= 0 and not used[at >> 1]:
                used[at >> 1] = True
                entered[n] = at
                n += 1
                at = mate[at ^ 1]
            closed[s] = loops == 1
            s += 1
            offsets[s] = n
    return entered, offsets[: s + 1].copy(), closed[:s].copy()


@kernel
def _ends_within(points: Points, offsets: Int32Array, free: Bools, reach: float) -> Int32Array:
    """(2 s,) the one other free end within reach; -1 with none, and with several."""
    m = len(free)
    mate = np.full(m, -1, np.int32)
    count = np.zeros(m, np.int32)
    for i in range(m):
        if not free[i]:
            continue
        p = points[offsets[i >> 1]] if i % 2 == 0 else points[offsets[(i >> 1) + 1] - 1]
        for j in range(i):
            if not free[j]:
                continue
            q = points[offsets[j >> 1]] if j % 2 == 0 else points[offsets[(j >> 1) + 1] - 1]
            if (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 <= reach * reach:
                mate[i] = j
                mate[j] = i
                count[i] += 1
                count[j] += 1
    for i in range(m):
        if mate[i] >= 0 and (count[i] > 1 or count[mate[i]] > 1):
            mate[i] = -1
    return mate


@kernel
def _thinned(points: Points, first: Index, n: Index, loop: bool, reach: float) -> int:
    """Drops points within reach of the one before from the segment ``first:n``, never its ends;
    the new n, ``first`` if too little is left."""
    x, y = points[n - 1, 0], points[n - 1, 1]
    at = first
    for k in range(first + 1, n):
        dx = points[k, 0] - points[at, 0]
        dy = points[k, 1] - points[at, 1]
        if dx * dx + dy * dy > reach * reach:
            at += 1
            points[at, 0], points[at, 1] = points[k, 0], points[k, 1]
    if at - first < (3 if loop else 1):
        return first
    points[at, 0], points[at, 1] = x, y
    return at + 1


@kernel
def joined(
    ends: Points, keys: NDArray[np.int64], tolerance: float
) -> tuple[Points, Int32Array, Bools, Bools]:
    """Points, offsets, closed and rims of Segments from edges (e, 2, 2) with keys (e, 2)."""
    node, n_nodes = _nodes(keys)
    entered, strings, closed = strung(_mates(node, n_nodes))
    points = np.empty((len(ends) + len(closed), 2))
    offsets = np.empty(len(strings), np.int32)
    rims = np.zeros((len(closed), 2), np.bool_)
    offsets[0] = 0
    n = 0
    for i in range(len(closed)):
        last = 0
        for k in range(strings[i], strings[i + 1]):
            last = entered[k] ^ 1
            points[n] = ends[entered[k] >> 1, entered[k] & 1]
            n += 1
        points[n] = ends[last >> 1, last & 1]
        n += 1
        offsets[i + 1] = n
        first = entered[strings[i]]
        rims[i, 0] = keys[first >> 1, first & 1] == RIM
        rims[i, 1] = keys[last >> 1, last & 1] == RIM
    return stitched(points, offsets, closed, rims, tolerance)


@kernel
def stitched(
    points: Points, offsets: Int32Array, closed: Bools, rims: Bools, tolerance: float
) -> tuple[Points, Int32Array, Bools, Bools]:
    """The segments end to end where two free ends meet, thinned."""
    free = np.empty(2 * len(closed), np.bool_)
    for i in range(len(closed)):
        for side in range(2):
            free[2 * i + side] = not (closed[i] or rims[i, side])
    entered, strings, loops = strung(_ends_within(points, offsets, free, tolerance))
    result = np.empty((len(points) + len(loops), 2))
    starts = np.empty(len(strings), np.int32)
    whole = np.empty(len(loops), np.bool_)
    ends = np.zeros((len(loops), 2), np.bool_)
    starts[0] = 0
    n = 0
    s = 0
    for i in range(len(loops)):
        first = n
        last = 0
        for k in range(strings[i], strings[i + 1]):
            at = entered[k]
            last = at ^ 1
            low = offsets[at >> 1]
            high = offsets[(at >> 1) + 1]
            for j in range(high - low):
                result[n] = points[low + j] if at % 2 == 0 else points[high - 1 - j]
                n += 1
        if loops[i]:
            result[n] = result[first]
            n += 1
        begin = entered[strings[i]]
        whole[s] = loops[i] or closed[begin >> 1]
        n = _thinned(result, first, n, whole[s], tolerance)
        if n == first:
            continue
        ends[s, 0] = rims[begin >> 1, begin & 1]
        ends[s, 1] = rims[last >> 1, last & 1]
        s += 1
        starts[s] = n
    return result[:n].copy(), starts[: s + 1].copy(), whole[:s].copy(), ends[:s].copy()
