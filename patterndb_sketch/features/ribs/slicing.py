"""Slices: the edges that a plane cuts out of a model's triangles near a point, and the segments
that they join to along the surface patches, then end to end."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Index, Int32Array, Int64Array
from patterndb.geometry.points import Bools, Points
from patterndb.geometry.tree import begin_walk, make_stack, make_walk, measure_backwards
from patterndb.system.kernels import kernel
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.model import Model

#: The key of an end that is none of a mesh edge's, but where the circle cuts the edge off. ``RIM``
#: in rust/features/src/ribs/slicing.rs is the same.
RIM = -1

#: Ends this close, as a share of the model's diagonal, are stitched, and points of a segment this
#: close are one. Coordinates in files have some seven digits.
STITCH = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """Cut edges in the frame of a plane.

    origin: (3,) the origin of the frame. axes: (3, 3) its x, its y and the plane's unit normal.
    ends:   (e, 2, 2) float64, the ends of the edges in the frame; all within the radius.
    keys:   (e, 2) int64, the mesh edge that each end lies on; ends of equal keys are one point,
            and equal bit for bit. RIM where the circle cuts an edge off.
    parts:  (e,) int32, the surface patch that the edge was cut from.
    """

    origin: Points
    axes: Points
    ends: Points
    keys: Int64Array
    parts: Int32Array

    def in_space(self, flat: Points) -> Points:
        """(n, 3) the points that have the coordinates (n, 2) in the frame."""
        return self.origin + flat @ self.axes[:2]


def slice_model(
    model: Model, origin: ArrayLike, normal: ArrayLike, radius: float | None = None
) -> Slice:
    """The edges in which a plane through ``origin`` (3,) across ``normal`` (3,) meets the model.

    radius: what lies farther from the origin is cut off, in units of the model; RADIUS of the
            diagonal unless told. The frame's axes depend on the normal alone.

    A vertex on the plane counts as being above it: every triangle has two cut edges or none,
    and cuts of closed meshes are closed. Source: feature curve recovery paper, section 4.3.1.
    Raises InvalidFeatureError for a normal without length and a radius that is not above 0.
    """
    place, axes = find_plane(origin, normal)
    reach = RADIUS * model.diagonal if radius is None else float(radius)
    if not (math.isfinite(reach) and reach > 0.0):
        raise InvalidFeatureError(f"the radius of a rib is {reach}; give a length above 0")
    ends, keys, parts = cut_edges(
        model.corners, model.triangles, model.components, *model.mesh.boxes, place, axes, reach
    )
    return Slice(place, axes, ends, keys, parts)


def find_plane(origin: ArrayLike, normal: ArrayLike) -> tuple[Points, Points]:
    """(3,) the origin and (3, 3) the axes of a plane: x, y and the unit normal, right-handed."""
    place = np.array(origin, np.float64)
    across = np.array(normal, np.float64)
    if place.shape != (3,) or across.shape != (3,):
        raise InvalidFeatureError("a plane has one origin (3,) and one normal (3,)")
    size = math.hypot(*across)
    if not (np.isfinite(place).all() and math.isfinite(size) and size > 0.0):
        raise InvalidFeatureError(
            f"the plane at {place.tolist()} across {across.tolist()} is none: numbers must be "
            "finite, and the normal must have a length"
        )
    axes = np.empty((3, 3))
    set_axes(across / size, axes)
    return place, axes


@kernel
def set_axes(normal: Points, axes: Points) -> None:
    """Sets axes (3, 3) from a unit normal (3,): x is across the coordinate axis farthest from
    the normal."""
    least = 0
    for c in range(1, 3):
        if abs(normal[c]) < abs(normal[least]):
            least = c
    one = (least + 1) % 3
    two = (least + 2) % 3
    size = math.sqrt(normal[one] ** 2 + normal[two] ** 2)
    axes[0, least] = 0.0
    axes[0, one] = normal[two] / size
    axes[0, two] = -normal[one] / size
    for c in range(3):
        axes[2, c] = normal[c]
    for c in range(3):
        d = (c + 1) % 3
        e = (c + 2) % 3
        axes[1, c] = axes[2, d] * axes[0, e] - axes[2, e] * axes[0, d]


@kernel
def _corner(
    corners: Points, f: Index, k: Index, origin: Points, axes: Points
) -> tuple[float, float, float]:
    """Corner k of triangle f in the frame: x, y, and the height over the plane."""
    p = corners[f, k, 0] - origin[0]
    q = corners[f, k, 1] - origin[1]
    r = corners[f, k, 2] - origin[2]
    return (
        p * axes[0, 0] + q * axes[0, 1] + r * axes[0, 2],
        p * axes[1, 0] + q * axes[1, 1] + r * axes[1, 2],
        p * axes[2, 0] + q * axes[2, 1] + r * axes[2, 2],
    )


@kernel
def _clip(ends: Points, keys: Int64Array, e: Index, radius: float) -> bool:
    """Cuts edge e off at the circle; False if nothing is left."""
    px, py = ends[e, 0, 0], ends[e, 0, 1]
    dx, dy = ends[e, 1, 0] - px, ends[e, 1, 1] - py
    size = radius * radius
    first = px * px + py * py > size
    last = (px + dx) ** 2 + (py + dy) ** 2 > size
    if not (first or last):
        return True
    a = dx * dx + dy * dy
    b = px * dx + py * dy
    inner = b * b - a * (px * px + py * py - size)
    if a == 0.0 or inner <= 0.0:
        return False
    root = math.sqrt(inner)
    low = (-b - root) / a
    high = (-b + root) / a
    if low >= 1.0 or high <= 0.0:
        return False
    if first:
        ends[e, 0, 0], ends[e, 0, 1] = px + low * dx, py + low * dy
        keys[e, 0] = -1
    if last:
        ends[e, 1, 0], ends[e, 1, 1] = px + high * dx, py + high * dy
        keys[e, 1] = -1
    return True


@kernel(forceinline=True)
def _is_apart(
    boxes: Points, b: Index, far: float, asked: tuple[Points, Points, float], bound: float
) -> bool:
    """Does box b surely not meet the disc?"""
    origin, axes, radius = asked
    across = 0.0
    half = 0.0
    away = 0.0
    for c in range(3):
        low = boxes[b, 0, c] - origin[c]
        high = boxes[b, 1, c] - origin[c]
        across += 0.5 * (low + high) * axes[2, c]
        half += 0.5 * (high - low) * abs(axes[2, c])
        d = max(low, 0.0, -high)
        away += d * d
    return abs(across) > half + 1e-9 * radius or away > radius * radius * (1.0 + 1e-9)




@kernel
def cut_edges(
    corners: Points,
    triangles: Int32Array,
    components: Int32Array,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origin: Points,
    axes: Points,
    radius: float,
) -> tuple[Points, Int64Array, Int32Array]:
    """Ends (e, 2, 2), keys (e, 2) and parts (e,) of a Slice, in the order of the tree."""
    room = 64
    ends = np.empty((room, 2, 2))
    keys = np.empty((room, 2), np.int64)
    parts = np.empty(room, np.int32)
    x = np.empty(3)
    y = np.empty(3)
    z = np.empty(3)
    stack, far = make_stack()
    n = 0
    begin_walk(stack)
    while True:
        leaf = _walk_disc(boxes, nodes, (origin, axes, radius), 0.0, stack, far)
        if leaf < 0:
            break
        for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
            f = order[k]
            for c in range(3):
                x[c], y[c], z[c] = _corner(corners, f, c, origin, axes)
            if (z[0] >= 0.0) == (z[1] >= 0.0) and (z[1] >= 0.0) == (z[2] >= 0.0):
                continue
            if n == room:
                ends = np.concatenate((ends, np.empty((room, 2, 2))))
                keys = np.concatenate((keys, np.empty((room, 2), np.int64)))
                parts = np.concatenate((parts, np.empty(room, np.int32)))
                room *= 2
            # A triangle's points ascend: both triangles at a mesh edge find the same numbers.
            at = 0
            for c in range(3):
                one = 0 if c < 2 else 1
                two = 1 if c == 0 else 2
                if (z[one] >= 0.0) == (z[two] >= 0.0):
                    continue
                s = z[one] / (z[one] - z[two])
                ends[n, at, 0] = x[one] + s * (x[two] - x[one])
                ends[n, at, 1] = y[one] + s * (y[two] - y[one])
                keys[n, at] = (np.int64(triangles[f, one]) << 32) | np.int64(triangles[f, two])
                at += 1
            parts[n] = components[f]
            if _clip(ends, keys, n, radius):
                n += 1
    return ends[:n].copy(), keys[:n].copy(), parts[:n].copy()


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
    return Segments(*join_edges(cut.ends, cut.keys, tolerance))


@kernel
def join_edges(
    ends: Points, keys: NDArray[np.int64], tolerance: float
) -> tuple[Points, Int32Array, Bools, Bools]:
    """Points, offsets, closed and rims of Segments from edges (e, 2, 2) with keys (e, 2)."""
    node, n_nodes = _nodes(keys)
    entered, strings, closed = chain_ends(_mates(node, n_nodes))
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
    return stitch_segments(points, offsets, closed, rims, tolerance)


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
def chain_ends(mate: Int32Array) -> tuple[Int32Array, Int32Array, Bools]:
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
def stitch_segments(
    points: Points, offsets: Int32Array, closed: Bools, rims: Bools, tolerance: float
) -> tuple[Points, Int32Array, Bools, Bools]:
    """The segments end to end where two free ends meet, thinned."""
    free = np.empty(2 * len(closed), np.bool_)
    for i in range(len(closed)):
        for side in range(2):
            free[2 * i + side] = not (closed[i] or rims[i, side])
    entered, strings, loops = chain_ends(_ends_within(points, offsets, free, tolerance))
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
        n = _thin(result, first, n, whole[s], tolerance)
        if n == first:
            continue
        ends[s, 0] = rims[begin >> 1, begin & 1]
        ends[s, 1] = rims[last >> 1, last & 1]
        s += 1
        starts[s] = n
    return result[:n].copy(), starts[: s + 1].copy(), whole[:s].copy(), ends[:s].copy()


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
def _thin(points: Points, first: Index, n: Index, loop: bool, reach: float) -> int:
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
