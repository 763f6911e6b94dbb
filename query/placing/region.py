"""The part of a surface that a boundary encloses, and a flat map of it.

Projecting on the whole surface would let a fill of half a head fall through to its back:
placing looks at the triangles inside the boundary only. They are found by flooding from the
boundary's left side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from patterndb._native.query.placing.region import flood_left
from patterndb.core.halfedge import Int32Array, edge_keys
from patterndb.errors import InvalidBoundaryError
from patterndb.geometry.adjacency import list_sides
from patterndb.geometry.points import Points, units
from patterndb.geometry.quadshape import NO_AREA
from patterndb.geometry.surface import Surface, SurfacePoints

#: Shares of a surface's diagonal: a boundary that is to lie on it has its nearest vertex no further
#: off than FAR, and its farthest no further than FARTHEST. Boundaries drawn coarsely are off by
#: some hundredths.
FAR = 0.1
FARTHEST = 1.0

#: Samples along a boundary edge, at first; pairs too far apart are halved again.
SAMPLES = 8

#: Times that two samples on triangles that do not touch are halved before the boundary is
#: taken to leave the surface there.
HALVINGS = 12

#: A region whose triangles all face the boundary's own plane by this cosine, or more, is as
#: good as flat: the membrane over the boundary projects onto it.
FACING = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """What a boundary encloses on a surface.

    surface: the triangles inside the boundary, and those that it crosses.
    share:   their part of the whole surface's area; 1 where the boundary does not separate
             the surface, so that all of it was taken.
    around:  (t,) float64, for triangles of ``surface`` that the boundary crosses: where around
             it, in boundary edges from vertex 0; NaN for the others.
    separates: does the boundary separate the surface?
    chosen:  (w,) bool, which triangles of the whole surface these are.
    """

    surface: Surface
    share: float
    around: NDArray[np.float64]
    separates: bool
    chosen: NDArray[np.bool_]

    @property
    def is_disk(self) -> bool:
        """Are its triangles one disk? Not so where the boundary comes nearer to itself than the
        surface's triangles are large."""
        return self.separates and _rim(self.surface) is not None


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """The triangles that a boundary crosses.

    around: (t,) where around it each is crossed, in edges from vertex 0; NaN for the others.
    points, lefts: (s, 3) places along it, and directions to its left there.
    """

    around: NDArray[np.float64]
    points: Points
    lefts: Points


def enclose_region(surface: Surface, points: Points) -> Region:
    """The region to the left of a closed polygon (P, 3) that lies on the surface.

    Left is as seen from outside, where triangles are counter-clockwise. Where the polygon's
    straight edges come nearer to another part of the surface, such as the lining of a thin wall,
    than to the one that they run along, they are taken to it by the way that it faces, or
    replaced by short paths along it.

    Raises InvalidBoundaryError for a boundary that is nowhere near the surface, or in another unit.
    """
    why = surface.explain_distance(points, "surface", FAR, FARTHEST)
    if why is not None:
        raise InvalidBoundaryError(f"the boundary does not lie on the surface: {why}")
    for crossing in _list_crossings(surface, points):
        around = crossing.around
        inside, separates = flood_left(
            surface.pairs, ~np.isnan(around), *_list_votes(surface, crossing)
        )
        if separates:
            share = float(surface.areas[inside].sum() / surface.areas.sum())
            return Region(surface.part(inside), share, around[inside], True, inside)
    # One piece on both sides: the boundary goes round a handle, or off the surface.
    n = len(surface.triangles)
    return Region(surface, 1.0, np.full(n, np.nan), False, np.ones(n, np.bool_))


def _list_votes(surface: Surface, crossing: Crossing) -> tuple[Int32Array, NDArray[np.int8]]:
    """(m,) triangles beside ones that a boundary crosses, and (m,) whether each is to its left, 1,
    or its right, -1, where it is nearest."""
    barrier = ~np.isnan(crossing.around)
    mixed = surface.pairs[barrier[surface.pairs].sum(axis=1) == 1]
    voters = np.where(barrier[mixed[:, 0]], mixed[:, 1], mixed[:, 0])
    if not len(voters):
        return voters, np.empty(0, np.int8)
    middles = surface.vertices[surface.triangles[voters]].mean(axis=1)
    # Imported here because placing in space loads this module, and needs no tree.
    from scipy.spatial import KDTree

    near = np.asarray(KDTree(crossing.points).query(middles)[1])
    side = np.einsum("nc,nc->n", middles - crossing.points[near], crossing.lefts[near])
    return voters, np.sign(side).astype(np.int8)


def measure_left(points: Points, normals: Points, at: Points, up: Points) -> float:
    """How far a point (3,) is to the left of the nearest segment of a closed polygon (n, 3), of
    those whose normals agree with its own; below 0 to the right, and if none do."""
    ends, ups = np.roll(points, -1, axis=0), np.roll(normals, -1, axis=0)
    agreeing = np.flatnonzero((normals + ups) @ up > 0.0)
    if len(agreeing) == 0:
        return -np.inf
    along = ends - points
    size = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((at - points) * along).sum(axis=1) / size, 0.0, 1.0)
    nearest = points + share[:, None] * along
    distance = np.linalg.norm(at - nearest, axis=1)
    k = agreeing[distance[agreeing].argmin()]
    lefts = units(np.cross(normals + ups, along))
    left = lefts[k]
    if share[k] in (0.0, 1.0):
        # At a vertex: left of both its segments together, whichever way the polygon turns there.
        left = left + lefts[(k + (1 if share[k] else -1)) % len(points)]
    return float((at - nearest[k]) @ units(left[None])[0])


#: What is no further from a boundary than this part of the surface's diagonal is on it.
ON_BOUNDARY = 1e-6


def find_void(
    region: Region, surface: Surface, border: Int32Array, points: Points
) -> Points | None:
    """A place (3,) on a border of the surface that lies within a region, as that of a hole in the
    surface does; None if there is none.

    surface: the whole. border: (b,) its sides 3 f + e that no other triangle has. points: (P, 3)
    the boundary. A border that the boundary runs along, or touches, is not within.
    """
    if not region.chosen[border // 3].any():
        return None
    tail = surface.triangles.ravel()[border]
    head = np.roll(surface.triangles, -1, axis=1).ravel()[border]
    loop = _pieces(np.stack([tail, head], axis=1), len(surface.vertices))[tail]
    on = ON_BOUNDARY * surface.diagonal
    around = np.full(len(surface.triangles), np.nan)
    around[region.chosen] = region.around
    for name in np.unique(loop[region.chosen[border // 3]]):
        own = loop == name
        corners = surface.vertices[tail[own]]
        # Two sides are a slit of which nothing is open; a row that does not close is a fin's.
        if len(corners) < 3 or not np.array_equal(np.sort(tail[own]), np.sort(head[own])):
            continue
        if not region.chosen[border[own] // 3].all():
            continue
        if _measure_apart(points, corners, surface.vertices[head[own]]).min() <= on:
            continue
        away = _measure_apart(corners, points, np.roll(points, -1, axis=0))
        farthest = int(away.argmax())
        crossed = not np.isnan(around[border[own][farthest] // 3])
        if away[farthest] <= on or (crossed and not _is_left(surface, points, corners[farthest])):
            continue
        return corners[farthest]
    return None


def _measure_apart(points: Points, start: Points, end: Points) -> NDArray[np.float64]:
    """(n,) the distance of each of (n, 3) points from the nearest segment, (k, 3) to (k, 3)."""
    least = np.full(len(points), np.inf)
    for a, b in zip(start, end, strict=True):
        along = b - a
        size = max(float(along @ along), np.finfo(np.float64).tiny)
        share = np.clip((points - a) @ along / size, 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(points - a - share[:, None] * along, axis=1))
    return least


def _is_left(surface: Surface, points: Points, at: Points) -> bool:
    """Is a point (3,) of the surface to the left of a boundary (P, 3)?"""
    normals, up = surface.nearest(points).normals, surface.nearest(at[None]).normals[0]
    return measure_left(points, normals, at, up) > 0.0


def is_curved(region: Region, points: Points) -> bool:
    """Does the region turn away from the plane of its boundary (P, 3)?"""
    spokes = points - points.mean(axis=0)
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    if size <= NO_AREA * float((spokes**2).sum()):
        return True
    normals = region.surface.normals[region.surface.triangles.ravel()]
    return float((normals @ (area / size)).min()) < FACING


def map_on_disk(region: Region, disk: Points, perimeter: int) -> SurfacePoints | None:
    """Where a fill's vertices fall if fill and region are laid on one disk.

    disk: (v, 2) the fill's vertices in the unit circle, those of the boundary, P = perimeter,
    at the angles 2 pi i / P. The region is laid on the circle by where the boundary crosses
    its rim, and inside by mean value coordinates (Floater 2003), a convex combination that
    folds nowhere. None where the region is no disk.
    """
    rim = _rim(region.surface)
    if rim is None:
        return None
    angle = _angles(region, rim, perimeter)
    if angle is None:
        return None
    flat = _floater(region.surface, rim, angle)
    plane = Surface.from_arrays(np.c_[flat, np.zeros(len(flat))], region.surface.triangles)
    if len(plane.triangles) != len(region.surface.triangles):
        return None
    there = plane.nearest(np.c_[disk, np.zeros(len(disk))])
    return region.surface.at(there.triangles, there.weights)


def _list_crossings(surface: Surface, points: Points) -> Iterator[Crossing]:
    """The triangles that a boundary may be taken to cross, the likeliest first; none where it
    leaves the surface."""
    found = _cross_below(surface, points)
    if found is not None:
        yield found
    paths = _find_paths(surface, points)
    if paths is None:
        return
    found = _cross_below(surface, points, np.stack([path.normals[0] for path in paths]))
    if found is not None:
        yield found
    yield _cross_along(surface, points, paths)


def _cross_below(
    surface: Surface, points: Points, normals: Points | None = None
) -> Crossing | None:
    """Crossed are the triangles nearest to the boundary, of those that face as the surface does at
    its vertices, normals (P, 3), if these are given; None if they do not touch one another."""
    n = len(points)

    def find_feet(place: NDArray[np.float64]) -> SurfacePoints:
        at = _around(points, place)
        if normals is None:
            return surface.nearest(at)
        # Over a sharp rim none may face so.
        return surface.nearest_facing(at, units(_around(normals, place)))

    place = np.arange(n * SAMPLES) / SAMPLES
    feet = find_feet(place)
    for _ in range(HALVINGS):
        a, b = feet.triangles, np.roll(feet.triangles, -1)
        apart = np.flatnonzero(~_touch(surface.triangles, a, b))
        if len(apart) == 0:
            break
        ends = np.roll(place, -1)[apart]
        ends[ends <= place[apart]] += n
        place = np.sort(np.r_[place, (place[apart] + ends) / 2.0])
        feet = find_feet(place % n)
    else:
        return None
    around = np.full(len(surface.triangles), np.nan)
    around[feet.triangles] = place
    along = _around(points, (place + 0.25) % n) - _around(points, (place - 0.25) % n)
    # Two triangles of the way that touch in a vertex alone: the fan round it closes the gap.
    one, two = (surface.triangles[f] for f in (feet.triangles, np.roll(feet.triangles, -1)))
    common = (one[:, :, None] == two[:, None, :]).any(axis=2)
    lone = np.flatnonzero(common.sum(axis=1) == 1)
    nearest_sample = np.full(len(surface.vertices), -1, np.int64)
    nearest_sample[one[lone][common[lone]]] = lone
    sample = nearest_sample[surface.triangles].max(axis=1)
    fan = np.isnan(around) & (sample >= 0)
    around[fan] = place[sample[fan]]
    return Crossing(around, feet.points, np.cross(feet.normals, along))


#: A path from middle to middle of triangles goes to and fro: up to this many times the length of
#: the boundary's edge, and the size of the triangles at its ends, it is no detour.
STRAIGHT = 2.0

#: ... and a longer one than this many times is none: the ends are on two parts of the surface.
LONGEST = 4.0


def _find_paths(surface: Surface, points: Points) -> list[SurfacePoints] | None:
    """Short paths along the surface between the vertices (P, 3) of a boundary, by triangles.

    A vertex is taken to be on the nearest triangle, or on the nearest of those that face the other
    way where the paths to its neighbours would be detours. None if there is no way around.
    """
    n = len(points)
    near = surface.nearest(points)
    back = surface.nearest_facing(points, -near.normals)
    there = back.fallback == 0
    feet = np.stack([near.triangles, back.triangles])
    apart = np.stack(
        [
            np.linalg.norm(near.points - points, axis=1),
            np.where(there, np.linalg.norm(back.points - points, axis=1), np.inf),
        ]
    )
    graph, reach = _link_triangles(surface)
    ways: list[dict[tuple[int, int], tuple[float, Int32Array]]] = []
    for i in range(n):
        j = (i + 1) % n
        ends = feet[:, [i, j]]
        edge, size = float(np.linalg.norm(points[j] - points[i])), 2.0 * float(reach[ends].max())
        length, before = dijkstra(
            graph,
            directed=False,
            indices=ends[:, 0],
            limit=LONGEST * edge + size,
            return_predecessors=True,
        )
        length = np.maximum(length[:, ends[:, 1]] - STRAIGHT * edge - size, 0.0)
        ways.append(
            {
                (a, b): (float(length[a, b]), _walk_back(before[a], ends[b, 1]))
                for a, b in np.argwhere(np.isfinite(length)).tolist()
            }
        )
    chosen = _choose_feet(ways, apart)
    if chosen is None:
        return None
    return [
        surface.at(path, np.full((len(path), 3), 1.0 / 3.0))
        for path in (ways[i][chosen[i], chosen[(i + 1) % n]][1] for i in range(n))
    ]


def _cross_along(surface: Surface, points: Points, paths: list[SurfacePoints]) -> Crossing:
    """Crossed are the triangles along paths between the vertices."""
    around = np.full(len(surface.triangles), np.nan)
    at: list[Points] = []
    lefts: list[Points] = []
    for i, path in enumerate(paths):
        share = (np.arange(len(path.triangles)) + 0.5) / len(path.triangles)
        edge = points[(i + 1) % len(points)] - points[i]
        around[path.triangles] = i + share
        at.append(points[i] + share[:, None] * edge)
        lefts.append(np.asarray(np.cross(path.normals, edge), np.float64))
    return Crossing(around, np.concatenate(at), np.concatenate(lefts))


def _link_triangles(surface: Surface) -> tuple[csr_array, NDArray[np.float64]]:
    """A graph of triangles that share an edge, by the way from middle to middle over that of the
    edge; and (t,) how far the corners of each are from its middle."""
    middles = surface.vertices[surface.triangles].mean(axis=1)
    one, two = surface.pairs.T
    corner = surface.triangles
    shared = (corner[one][:, :, None] == corner[two][:, None, :]).any(axis=2)
    ends = np.where(shared[:, :, None], surface.vertices[corner[one]], 0.0).sum(axis=1)
    edge = ends / np.maximum(shared.sum(axis=1), 1)[:, None]
    length = np.linalg.norm(middles[one] - edge, axis=1) + np.linalg.norm(
        middles[two] - edge, axis=1
    )
    graph = csr_array((length, (one, two)), shape=(len(corner), len(corner)))
    reach = np.linalg.norm(surface.vertices[corner] - middles[:, None], axis=2).max(axis=1)
    return graph, reach


def _walk_back(before: Int32Array, last: int) -> Int32Array:
    """The triangles of a shortest path, in order, from those before each."""
    path = [last]
    while (last := int(before[last])) >= 0:
        path.append(last)
    return np.array(path[::-1], np.int32)


def _choose_feet(
    ways: list[dict[tuple[int, int], tuple[float, Int32Array]]], apart: NDArray[np.float64]
) -> list[int] | None:
    """Of every vertex of a closed polygon which of its two feet is meant: the least sum of
    detours between them, and of distances (2, n) from them; None if no choice has paths all
    around."""
    n = len(ways)
    best: tuple[float, list[int]] | None = None
    for first in (0, 1):
        cost = {first: (float(apart[first, 0]), [first])}
        for i in range(n):
            reached: dict[int, tuple[float, list[int]]] = {}
            for (a, b), (length, _) in ways[i].items():
                if a not in cost or (i == n - 1 and b != first):
                    continue
                off = float(apart[b, i + 1]) if i < n - 1 else 0.0
                total = cost[a][0] + length + off
                if np.isfinite(total) and (b not in reached or total < reached[b][0]):
                    reached[b] = total, [*cost[a][1], b]
            cost = reached
        if first in cost and (best is None or cost[first][0] < best[0]):
            best = cost[first][0], cost[first][1][:n]
    return None if best is None else best[1]


def _around(points: Points, place: NDArray[np.float64]) -> Points:
    """(n, 3) points of the closed polygon (P, 3) at places in edges from its first vertex."""
    first = np.floor(place).astype(np.int64) % len(points)
    t = (place % 1.0)[:, None]
    return points[first] * (1.0 - t) + points[(first + 1) % len(points)] * t


def _touch(triangles: Int32Array, a: Int32Array, b: Int32Array) -> NDArray[np.bool_]:
    """(n,) do the triangles a and b (n,) have a vertex in common?"""
    return (triangles[a][:, :, None] == triangles[b][:, None, :]).any(axis=(1, 2))


def _pieces(edges: Int32Array, n: int) -> NDArray[np.int32]:
    links = coo_array((np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), shape=(n, n))
    return connected_components(links, directed=False)[1]


def _rim(surface: Surface) -> Int32Array | None:
    """(r,) the half-edges 3 f + e along the rim of a disk, in order; None if it is no disk."""
    triangles = surface.triangles
    key = edge_keys(*list_sides(triangles))
    values, inverse, uses = np.unique(key, return_inverse=True, return_counts=True)
    corners = len(np.unique(triangles))
    if corners - len(values) + len(triangles) != 1 or uses.max() > 2:
        return None
    if _pieces(surface.pairs, len(triangles)).any():
        return None
    border = np.flatnonzero(uses[inverse.ravel()] == 1)
    tail = triangles.ravel()
    head = np.roll(triangles, -1, axis=1).ravel()
    leaves = {int(tail[h]): int(h) for h in border}
    if len(leaves) != len(border) or len(border) == 0:
        return None
    loop = [int(border[0])]
    while (h := leaves.get(int(head[loop[-1]]), -1)) != loop[0]:
        if h < 0 or len(loop) > len(border):
            return None
        loop.append(h)
    return np.array(loop, np.int32) if len(loop) == len(border) else None


def _angles(region: Region, rim: Int32Array, perimeter: int) -> NDArray[np.float64] | None:
    """(r,) angle on the circle of every rim vertex, growing; None if the rim goes astray."""
    around = region.around[rim // 3]
    if np.isnan(around).any():
        return None
    # A rim vertex lies between two rim edges; each is where its triangle is crossed.
    turn = np.exp(2j * math.pi * around / perimeter)
    middle = np.angle(turn + np.roll(turn, 1))
    steps = np.angle(np.exp(1j * np.diff(np.r_[middle, middle[0]])))
    if abs(steps.sum() - 2.0 * math.pi) > 1e-6:
        return None
    angle = middle[0] + np.r_[0.0, np.cumsum(steps)[:-1]]
    # Steps back are small: crossed triangles in a row may be met out of turn.
    angle = np.minimum(np.maximum.accumulate(angle), angle[0] + 2.0 * math.pi)
    spread = np.arange(len(rim)) / len(rim) * 2.0 * math.pi
    # Strictly growing, so that no triangle of the map is without area.
    return angle + 1e-3 * (spread - (angle - angle[0]))


def _floater(surface: Surface, rim: Int32Array, angle: NDArray[np.float64]) -> Points:
    """(v, 2) the region's vertices in the unit circle, by mean value coordinates."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    t = surface.triangles
    corner = surface.vertices[t]
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(corner, 1, axis=1) - corner
    length = np.linalg.norm(leaving, axis=2)
    back = np.linalg.norm(entering, axis=2)
    sine = np.linalg.norm(np.cross(leaving, entering), axis=2)
    cosine = (leaving * entering).sum(axis=2)
    # tan(angle / 2) = sine / (product + cosine).
    half = sine / np.maximum(length * back + cosine, 1e-12 * length * back)
    i = np.concatenate([t.ravel(), t.ravel()])
    j = np.concatenate([np.roll(t, -1, axis=1).ravel(), np.roll(t, 1, axis=1).ravel()])
    w = np.concatenate([(half / length).ravel(), (half / back).ravel()])
    flat = np.zeros((len(surface.vertices), 2))
    on_rim = t.ravel()[rim]
    flat[on_rim] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner = np.setdiff1d(np.unique(t), on_rim)
    if len(inner) == 0:
        return flat
    name = np.full(len(surface.vertices), -1, np.int64)
    name[inner] = np.arange(len(inner))
    mine = name[i] >= 0
    i, j, w = i[mine], j[mine], w[mine]
    total = np.bincount(name[i], weights=w, minlength=len(inner))
    w = w / total[name[i]]
    free = name[j] >= 0
    right = np.zeros((len(inner), 2))
    np.add.at(right, name[i[~free]], w[~free, None] * flat[j[~free]])
    own = np.arange(len(inner))
    matrix = csc_array(
        (
            np.r_[np.ones(len(inner)), -w[free]],
            (np.r_[own, name[i[free]]], np.r_[own, name[j[free]]]),
        ),
        shape=(len(inner), len(inner)),
    )
    flat[inner] = splu(matrix).solve(right)
    return flat
