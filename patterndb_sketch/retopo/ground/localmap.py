"""Local parameterisation: (u, v) spread over the ground from a stroke or a point.

A discrete exponential map. Source: Schmidt 2013, "Stroke Parameterization", as Takayama et
al. 2013 and their released program use it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.ground.ground import Ground, GroundPoints
from patterndb_sketch.retopo.ground.heap import grown, pop, push

#: A triangle with an edge this many times as long in (u, v) as it is lies where two fronts met,
#: as on the back of a thin limb.
TORN = 2.5


#: The way along edges of triangles is at most about so many times as long as the straight one.
AROUND = 2.0


@dataclass(frozen=True, slots=True)
class MapExtent:
    """How far a map goes: along the surface's edges from its seeds, and in u and v.

    The factors of the two makers are those of the released program of Takayama et al. 2013.
    """

    distance: float
    u: tuple[float, float]
    v: tuple[float, float]

    @classmethod
    def spine(cls, b: float, length: float) -> MapExtent:
        """Around a stroke of this length, for a brush of half-width b."""
        return cls(1.8 * b, (-1.5 * b, 1.5 * b), (-0.5 * b, length + 0.5 * b))

    def widen(self, by: float) -> MapExtent:
        """This much further on all sides: so that triangles of such edges, which lie in it only in
        part, have all their corners in it."""
        (left, right), (low, high) = self.u, self.v
        # Along edges it is further than straight.
        return MapExtent(
            self.distance + AROUND * by, (left - by, right + by), (low - by, high + by)
        )

    @classmethod
    def completion(cls, b: float) -> MapExtent:
        """Around a point of a boundary, for suggestions of radius b."""
        return cls(3.8 * b, (-1.2 * b, 1.2 * b), (-0.3 * b, 2.2 * b))


@dataclass(frozen=True, slots=True, eq=False)
class LocalMap:
    """(u, v) of a part of the ground: v along the stroke, u to its right seen from outside.

    vertices:  (m,) int32, the ground's vertices that have (u, v), the nearest first.
    uv:        (m, 2) float64.
    distance:  (m,) float64 along edges from the seeds.
    triangles: (k,) int32 ascending, the ground's triangles with (u, v) at all three corners.
    corners:   (k, 3) int32, their corners as places in ``vertices``.
    """

    ground: Ground
    vertices: Int32Array
    uv: Points
    distance: NDArray[np.float64]
    triangles: Int32Array
    corners: Int32Array
    _grid: tuple[Points, Int32Array, Int32Array]

    def of(self, feet: GroundPoints) -> Points:
        """(n, 2) the (u, v) of points on the ground; nan outside of the map."""
        result = np.full((len(feet), 2), np.nan)
        if len(self.triangles) == 0:
            return result
        place = np.searchsorted(self.triangles, feet.triangles)
        place = np.minimum(place, len(self.triangles) - 1)
        within = self.triangles[place] == feet.triangles
        corner = self.uv[self.corners[place[within]]]
        result[within] = np.einsum("ne,nec->nc", feet.weights[within], corner)
        return result

    def of_points(self, points: ArrayLike, normals: ArrayLike) -> Points:
        """(n, 2) the (u, v) of (n, 3) points, with (n, 3) normals, on or near the ground.

        Each is taken to the nearest point that faces as it does; nan where that is outside of
        the map, and for points further from the map's box than half its diagonal, which cost
        nothing.
        """
        at, up = np.asarray(points, np.float64), np.asarray(normals, np.float64)
        result = np.full((len(at), 2), np.nan)
        if len(self.vertices) == 0:
            return result
        mapped = self.ground.vertices[self.vertices]
        low, high = mapped.min(axis=0), mapped.max(axis=0)
        room = 0.5 * float(np.linalg.norm(high - low))
        near = np.flatnonzero(((at >= low - room) & (at <= high + room)).all(axis=1))
        there = self.ground.nearest_facing(at[near], up[near])
        result[near] = self.of(there.feet)
        result[near[there.lost]] = np.nan
        return result

    def at(self, uv: ArrayLike) -> tuple[GroundPoints, NDArray[np.bool_]]:
        """Points of the ground with these (u, v), (n, 2), and (n,) whether there is one.

        Where the map lies over itself the one nearest to the seeds. Where there is none the
        foot is nan, its triangle -1.
        """
        wanted = np.ascontiguousarray(uv, np.float64)
        if wanted.ndim != 2 or wanted.shape[1] != 2:
            raise InvalidRetopoError(f"(u, v) must be (n, 2), got {wanted.shape}")
        place, weights = _find_containing(self.uv, self.corners, self.distance, *self._grid, wanted)
        found = place >= 0
        n = len(wanted)
        feet = GroundPoints(
            np.full((n, 3), np.nan), np.full((n, 3), np.nan), np.full(n, -1, np.int32), weights
        )
        on = self.ground.at(self.triangles[place[found]], weights[found])
        feet.points[found], feet.normals[found] = on.points, on.normals
        feet.triangles[found] = on.triangles
        return feet, found


def spread_map(
    ground: Ground, seeds: GroundPoints, tangents: ArrayLike, window: MapExtent
) -> LocalMap:
    """The map spread from a stroke's points (n >= 1), or from one point.

    tangents: (n, 3) directions of v, of any length above 0; only their parts along the surface
    count. v is 0 at the first seed and grows by the distance from seed to seed.
    Raises InvalidRetopoError for no seeds, and for a tangent without a part along the surface.

    Differs from the sources: triangles where two fronts met, torn in (u, v), have none.
    """
    along = np.ascontiguousarray(tangents, np.float64)
    if len(seeds) == 0 or along.shape != seeds.points.shape:
        raise InvalidRetopoError(
            f"a local map was asked for from {len(seeds)} points with tangents of the shape "
            f"{along.shape}; give one point or more, and (n, 3) tangents"
        )
    up = seeds.normals
    along = along - np.einsum("nc,nc->n", along, up)[:, None] * up
    size = np.linalg.norm(along, axis=1)
    bad = np.flatnonzero(~(size > 1e-9 * np.linalg.norm(np.asarray(tangents), axis=1)))
    if len(bad):
        raise InvalidRetopoError(
            f"tangent {bad[0]} of a local map has no part along the surface; give the direction "
            "of the stroke there"
        )
    right = np.cross(along / size[:, None], up)
    vertices, uv, axes, distance = _seed_vertices(ground, seeds, right)
    low = np.array([window.u[0], window.v[0]])
    high = np.array([window.u[1], window.v[1]])
    found, uv, distance = _spread_front(
        ground.vertices,
        ground.normals,
        ground.topology.star_start,
        ground.topology.star,
        vertices,
        uv,
        axes,
        distance,
        window.distance,
        low,
        high,
    )
    triangles, corners = _find_mapped(ground.triangles, ground.vertices, found, uv, TORN)
    return LocalMap(ground, found, uv, distance, triangles, corners, _file_triangles(uv, corners))


def _seed_vertices(
    ground: Ground, seeds: GroundPoints, right: Points
) -> tuple[Int32Array, Points, Points, NDArray[np.float64]]:
    """The vertices nearest to the seeds, with (u, v), u axes and distances: means over all the
    seeds of a vertex. right (n, 3): the seeds' own u axes."""
    n = len(seeds)
    corner = seeds.weights.argmax(axis=1)
    vertex = ground.triangles[seeds.triangles, corner]
    # Every seed hands on to its vertex what a vertex hands on to its neighbour.
    places = np.concatenate([seeds.points, ground.vertices[vertex]])
    normals = np.concatenate([seeds.normals, ground.normals[vertex]])
    axes = np.concatenate([right, right])
    uv = np.stack([np.zeros(n), arc_length(seeds.points)], axis=1)
    offset = np.linalg.norm(places[n:] - places[:n], axis=1)
    step = np.empty(5)
    turned = right.copy()
    for i in range(n):
        if offset[i] > 0.0 and _propose(places, normals, axes, i, n + i, step):
            uv[i] += step[:2]
            turned[i] = step[2:]
    chosen, which, count = np.unique(vertex, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    mean_uv, mean_axes = np.zeros((len(chosen), 2)), np.zeros((len(chosen), 3))
    np.add.at(mean_uv, which, uv)
    np.add.at(mean_axes, which, turned)
    distance = np.full(len(chosen), np.inf)
    np.minimum.at(distance, which, offset)
    return (
        chosen.astype(np.int32),
        mean_uv / count[:, None],
        units(mean_axes / count[:, None]),
        distance,
    )


#: A neighbour's proposal weighs its distance to this power. Source: the released program of
#: Takayama et al. 2013.
NEARNESS = -0.25

#: Normals whose dot product is nearly -1 have no least rotation from one to the other.
OPPOSITE = 1e-9


@kernel
def _propose(
    vertices: Points, normals: Points, axes: Points, p: Index, q: Index, out: NDArray[np.float64]
) -> bool:
    """What p hands on to q: out (5,) becomes the step in (u, v) and the u axis at q.

    False if it has nothing to say: q is straight above p, or they face opposite ways.
    """
    nx, ny, nz = normals[p, 0], normals[p, 1], normals[p, 2]
    ux, uy, uz = axes[p, 0], axes[p, 1], axes[p, 2]
    dx = vertices[q, 0] - vertices[p, 0]
    dy = vertices[q, 1] - vertices[p, 1]
    dz = vertices[q, 2] - vertices[p, 2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    up = dx * nx + dy * ny + dz * nz
    dx, dy, dz = dx - up * nx, dy - up * ny, dz - up * nz
    flat = math.sqrt(dx * dx + dy * dy + dz * dz)
    facing = nx * normals[q, 0] + ny * normals[q, 1] + nz * normals[q, 2]
    if flat <= OPPOSITE * length or 1.0 + facing <= OPPOSITE:
        return False
    vx, vy, vz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    out[0] = (dx * ux + dy * uy + dz * uz) * length / flat
    out[1] = (dx * vx + dy * vy + dz * vz) * length / flat
    turn = ux * normals[q, 0] + uy * normals[q, 1] + uz * normals[q, 2]
    turn /= 1.0 + facing
    out[2] = ux - turn * (nx + normals[q, 0])
    out[3] = uy - turn * (ny + normals[q, 1])
    out[4] = uz - turn * (nz + normals[q, 2])
    return True


@kernel
def _settle(axes: Points, normals: Points, q: Index) -> bool:
    """Put q's u axis into its tangent plane, at length 1; False if nothing is left of it."""
    up = 0.0
    for c in range(3):
        up += axes[q, c] * normals[q, c]
    size = 0.0
    for c in range(3):
        axes[q, c] -= up * normals[q, c]
        size += axes[q, c] ** 2
    if size <= OPPOSITE * OPPOSITE:
        return False
    for c in range(3):
        axes[q, c] /= math.sqrt(size)
    return True


@kernel
def _spread_front(
    vertices: Points,
    normals: Points,
    star_start: Int32Array,
    star: Int32Array,
    seeds: Int32Array,
    seed_uv: Points,
    seed_axes: Points,
    seed_distance: NDArray[np.float64],
    distance: float,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[Int32Array, Points, NDArray[np.float64]]:
    """(m,) vertices in order of their distance, their (u, v) (m, 2) and distances (m,).

    seeds (s,) distinct vertices with their (u, v), u axes (s, 3) and distances; beyond the
    distance, or the box from low (2,) to high (2,), nothing is handed on.
    """
    v = len(vertices)
    far = np.full(v, np.inf)
    frozen = np.zeros(v, np.bool_)
    seeded = np.zeros(v, np.bool_)
    uv = np.empty((v, 2))
    axes = np.empty((v, 3))
    found = np.empty(v, np.int32)
    keys = np.empty(1024)
    items = np.empty(1024, np.int32)
    step = np.empty(5)
    n = 0
    m = 0
    for s in range(len(seeds)):
        q = seeds[s]
        far[q] = seed_distance[s]
        seeded[q] = True
        uv[q] = seed_uv[s]
        axes[q] = seed_axes[s]
        if n == len(keys):
            keys, items = grown(keys, items)
        n = push(keys, items, n, far[q], q)
    while n:
        key, q = keys[0], items[0]
        n = pop(keys, items, n)
        if key > distance:
            break
        if frozen[q] or key > far[q]:
            continue
        if not seeded[q]:
            total = 0.0
            u, w = 0.0, 0.0
            axes[q] = 0.0
            for k in range(star_start[q], star_start[q + 1]):
                p = star[k]
                if not frozen[p] or not _propose(vertices, normals, axes, p, q, step):
                    continue
                size = 0.0
                for c in range(3):
                    size += (vertices[q, c] - vertices[p, c]) ** 2
                weight = size ** (0.5 * NEARNESS)
                total += weight
                u += weight * (uv[p, 0] + step[0])
                w += weight * (uv[p, 1] + step[1])
                for c in range(3):
                    axes[q, c] += weight * step[2 + c]
            if total == 0.0:
                far[q] = np.inf
                continue
            uv[q, 0] = u / total
            uv[q, 1] = w / total
        if uv[q, 0] < low[0] or uv[q, 0] > high[0] or uv[q, 1] < low[1] or uv[q, 1] > high[1]:
            continue
        if not _settle(axes, normals, q):
            continue
        frozen[q] = True
        found[m] = q
        m += 1
        for k in range(star_start[q], star_start[q + 1]):
            p = star[k]
            if frozen[p]:
                continue
            size = 0.0
            for c in range(3):
                size += (vertices[q, c] - vertices[p, c]) ** 2
            reached = key + math.sqrt(size)
            if reached < far[p] and reached <= distance:
                far[p] = reached
                if n == len(keys):
                    keys, items = grown(keys, items)
                n = push(keys, items, n, reached, p)
    return found[:m].copy(), uv[found[:m]], far[found[:m]]


@kernel
def _find_mapped(
    triangles: Int32Array, vertices: Points, found: Int32Array, uv: Points, torn: float
) -> tuple[Int32Array, Int32Array]:
    """(k,) the triangles all of whose corners were found (m,), ascending; (k, 3) those corners
    as places in ``found``.

    Left out is a triangle with an edge more than ``torn`` times as long in (u, v) (m, 2) as it is.
    """
    name = np.full(len(vertices), -1, np.int32)
    for i in range(len(found)):
        name[found[i]] = i
    which = np.empty(len(triangles), np.int32)
    k = 0
    for f in range(len(triangles)):
        if name[triangles[f, 0]] < 0 or name[triangles[f, 1]] < 0 or name[triangles[f, 2]] < 0:
            continue
        whole = True
        for e in range(3):
            i, j = triangles[f, e], triangles[f, (e + 1) % 3]
            size = 0.0
            for c in range(3):
                size += (vertices[j, c] - vertices[i, c]) ** 2
            flat = 0.0
            for c in range(2):
                flat += (uv[name[j], c] - uv[name[i], c]) ** 2
            whole &= flat <= torn * torn * size
        if whole:
            which[k] = f
            k += 1
    corners = np.empty((k, 3), np.int32)
    for i in range(k):
        for e in range(3):
            corners[i, e] = name[triangles[which[i], e]]
    return which[:k].copy(), corners


#: Barycentric weights this far below 0 still count: a point on an edge has one of its two
#: triangles.
SLACK = 1e-9


@kernel(inline="always")
def _cell(x: float, low: float, size: float, n: Index) -> int:
    return min(max(int((x - low) / size), 0), n - 1)


@kernel
def _file_triangles(uv: Points, corners: Int32Array) -> tuple[Points, Int32Array, Int32Array]:
    """A grid over the triangles (k, 3) of points uv (m, 2): its frame (3, 2), which is low
    corner, cell size and numbers of cells; and the triangles by cell: start, numbers."""
    k = len(corners)
    frame = np.zeros((3, 2))
    frame[1:] = 1.0
    if k:
        side = max(1, int(math.sqrt(k)))
        for c in range(2):
            low, high = np.inf, -np.inf
            for f in range(k):
                for e in range(3):
                    low = min(low, uv[corners[f, e], c])
                    high = max(high, uv[corners[f, e], c])
            frame[0, c] = low
            frame[1, c] = (high - low) / side if high > low else 1.0
            frame[2, c] = side if high > low else 1
    columns, rows = int(frame[2, 0]), int(frame[2, 1])
    box = np.empty((k, 4), np.int32)
    start = np.zeros(columns * rows + 1, np.int32)
    for f in range(k):
        for c in range(2):
            one, two, three = uv[corners[f, 0], c], uv[corners[f, 1], c], uv[corners[f, 2], c]
            n = int(frame[2, c])
            box[f, c] = _cell(min(one, two, three), frame[0, c], frame[1, c], n)
            box[f, 2 + c] = _cell(max(one, two, three), frame[0, c], frame[1, c], n)
        for i in range(box[f, 0], box[f, 2] + 1):
            for j in range(box[f, 1], box[f, 3] + 1):
                start[i * rows + j + 1] += 1
    for i in range(columns * rows):
        start[i + 1] += start[i]
    at = start[:-1].copy()
    numbers = np.empty(start[-1], np.int32)
    for f in range(k):
        for i in range(box[f, 0], box[f, 2] + 1):
            for j in range(box[f, 1], box[f, 3] + 1):
                numbers[at[i * rows + j]] = f
                at[i * rows + j] += 1
    return frame, start, numbers


@kernel
def _find_containing(
    uv: Points,
    corners: Int32Array,
    distance: NDArray[np.float64],
    frame: Points,
    start: Int32Array,
    numbers: Int32Array,
    wanted: Points,
) -> tuple[Int32Array, Points]:
    """(n,) the triangle that contains each (u, v) wanted (n, 2), -1 without; (n, 3) weights.

    Of several the one of the least distance (m,), interpolated there.
    """
    triangle = np.full(len(wanted), -1, np.int32)
    weights = np.zeros((len(wanted), 3))
    columns, rows = int(frame[2, 0]), int(frame[2, 1])
    for i in range(len(wanted)):
        x, y = wanted[i, 0], wanted[i, 1]
        if not (math.isfinite(x) and math.isfinite(y)):
            continue
        # A little outside is looked at too, as slack takes edges in.
        reach = (x - frame[0, 0]) / frame[1, 0], (y - frame[0, 1]) / frame[1, 1]
        if not (-1.0 < reach[0] < columns + 1 and -1.0 < reach[1] < rows + 1):
            continue
        cell = _cell(x, frame[0, 0], frame[1, 0], columns) * rows
        cell += _cell(y, frame[0, 1], frame[1, 1], rows)
        best = np.inf
        for k in range(start[cell], start[cell + 1]):
            f = numbers[k]
            a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
            ux, uy = uv[b, 0] - uv[a, 0], uv[b, 1] - uv[a, 1]
            vx, vy = uv[c, 0] - uv[a, 0], uv[c, 1] - uv[a, 1]
            area = ux * vy - uy * vx
            if area == 0.0:
                continue
            px, py = x - uv[a, 0], y - uv[a, 1]
            one = (px * vy - py * vx) / area
            two = (ux * py - uy * px) / area
            if one < -SLACK or two < -SLACK or one + two > 1.0 + SLACK:
                continue
            one = min(max(one, 0.0), 1.0)
            two = min(max(two, 0.0), 1.0 - one)
            far = (1.0 - one - two) * distance[a] + one * distance[b] + two * distance[c]
            if far < best:
                best = far
                triangle[i] = f
                weights[i, 0], weights[i, 1], weights[i, 2] = 1.0 - one - two, one, two
    return triangle, weights
