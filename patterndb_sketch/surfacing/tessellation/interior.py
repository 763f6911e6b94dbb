"""Meshing the inside of a polygon in the plane: a hexagonal lattice, joined and evened out."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.tessellation.delaunay import (
    following,
    insert,
    make_delaunay,
    preceding,
    triangle_at,
)
from patterndb_sketch.surfacing.tessellation.polygon import clip_ears, doubled_area, turn

#: The most points inside one polygon: some seconds, and a mesh that is surely a slip.
MAX_INNER = 1_000_000

#: Lattice points this near to the boundary, in spacings, are left out: the rows of a lattice
#: are 0.87 apart, and the smoothing moves the outermost row to about that.
CLEARANCE = 0.6

#: Rounds of smoothing. The shapes hardly change after the fourth.
ROUNDS = 4


def triangulated(grid: Int64Array) -> tuple[Int64Array, Int64Array]:
    """(tail, twin) of the constrained Delaunay triangulation of a simple polygon (m, 2)."""
    n = 3 * (len(grid) - 2)
    tail, twin = np.empty(n, np.int64), np.empty(n, np.int64)
    clip_ears(grid, len(grid), tail, twin)
    make_delaunay(grid, tail, twin, len(grid) - 2)
    return tail, twin


def filled(
    grid: Int64Array, tail: Int64Array, twin: Int64Array, spacing: float
) -> tuple[Int64Array, Int64Array, Int64Array]:
    """A triangulated polygon with points inside, about ``spacing`` steps of the grid apart.

    grid: (m, 2) int64, simple, counter-clockwise. tail, twin: its triangulation, see
    :func:`triangulated`. Returns the points (m + k, 2), the polygon's first, and the constrained
    Delaunay triangulation of all of them. k is 0 where the polygon has no room.

    Raises InvalidNetworkError for more than MAX_INNER points.
    """
    wanted = doubled_area(grid) / (math.sqrt(3.0) * spacing * spacing)
    if wanted > MAX_INNER:
        raise InvalidNetworkError(
            f"the spacing would make {wanted:.3g} points inside one piece; the limit is "
            f"{MAX_INNER:,}, so make it longer"
        )
    inner = lattice(grid, spacing)
    if not len(inner):
        return grid, tail, twin
    at = np.concatenate([grid, inner])
    room = np.empty((2, 3 * (len(grid) - 2 + 2 * len(inner))), np.int64)
    room[0, : len(tail)], room[1, : len(twin)] = tail, twin
    joined = _join(at, len(grid), room[0], room[1])
    assert joined == len(at), "a point within the polygon is in none of its triangles"
    _smooth(at, len(grid), room[0], room[1])
    return at, room[0], room[1]


@kernel
def lattice(grid: Int64Array, spacing: float) -> Int64Array:
    """(k, 2) points of a hexagonal lattice inside a simple polygon, clear of its boundary.

    Rows are along the first axis, one of them through the middle of the polygon's box.
    """
    m = len(grid)
    rise = spacing * math.sqrt(3.0) / 2.0
    middle_x = (grid[:, 0].min() + grid[:, 0].max()) / 2.0
    middle_y = (grid[:, 1].min() + grid[:, 1].max()) / 2.0
    half = int((grid[:, 1].max() - middle_y) / rise)
    clear = CLEARANCE * spacing
    found = np.empty((64, 2), np.int64)
    count = 0
    crossings = np.empty(m)
    near = np.empty(m, np.int64)
    for row in range(-half, half + 1):
        y = middle_y + row * rise
        n = 0
        n_near = 0
        for i in range(m):
            j = (i + 1) % m
            yi, yj = float(grid[i, 1]), float(grid[j, 1])
            if min(yi, yj) < y + clear and max(yi, yj) > y - clear:
                near[n_near] = i
                n_near += 1
            # Half-open, so that a vertex in the row counts once.
            if (yi <= y) != (yj <= y):
                crossings[n] = grid[i, 0] + (y - yi) / (yj - yi) * (grid[j, 0] - grid[i, 0])
                n += 1
        spans = np.sort(crossings[:n])
        shift = middle_x + (0.5 * spacing if row % 2 else 0.0)
        for s in range(0, n, 2):
            first = math.ceil((spans[s] - shift) / spacing)
            last = math.floor((spans[s + 1] - shift) / spacing)
            for step in range(first, last + 1):
                x = shift + step * spacing
                if not _is_clear(grid, near[:n_near], x, y, clear):
                    continue
                if count == len(found):
                    more = np.empty((2 * count, 2), np.int64)
                    more[:count] = found
                    found = more
                found[count, 0] = round(x)
                found[count, 1] = round(y)
                count += 1
    return found[:count].copy()


@kernel
def _is_clear(grid: Int64Array, edges: Int64Array, x: float, y: float, clear: float) -> bool:
    """Is a point at least this far from these edges of a polygon, edge i beginning at vertex i?"""
    for k in range(len(edges)):
        i = edges[k]
        j = (i + 1) % len(grid)
        ax, ay = float(grid[i, 0]), float(grid[i, 1])
        ux, uy = grid[j, 0] - ax, grid[j, 1] - ay
        along = ((x - ax) * ux + (y - ay) * uy) / (ux * ux + uy * uy)
        along = min(max(along, 0.0), 1.0)
        dx, dy = x - ax - along * ux, y - ay - along * uy
        if dx * dx + dy * dy < clear * clear:
            return False
    return True


@kernel
def _join(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> int:
    """Insert the points from m on, one by one; how many points are joined in the end."""
    triangles = m - 2
    stack = np.empty(len(at) + 3, np.int64)
    t = 0
    for p in range(m, len(at)):
        t = triangle_at(at, tail, twin, triangles, p, t)
        if t < 0:
            return p
        insert(at, tail, twin, triangles, p, t, stack)
        triangles += 2
    return len(at)


@kernel
def _smooth(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> None:
    """Move the points from m on towards even triangles, in place, and flip to Delaunay again.

    Each goes to the mean of its triangles' middles by their areas (Chen 2004, "Mesh smoothing
    schemes based on optimal Delaunay triangulations"), unless that would turn one of them over.
    """
    leaving = np.empty(len(at), np.int64)
    for _ in range(ROUNDS):
        for h in range(len(tail)):
            leaving[tail[h]] = h
        for p in range(m, len(at)):
            total, x, y = 0.0, 0.0, 0.0
            h = leaving[p]
            while True:
                a, b = tail[following(h)], tail[preceding(h)]
                area = float(turn(at, p, a, b))
                total += area
                x += area * (at[a, 0] + at[b, 0] - 2 * at[p, 0]) / 3.0
                y += area * (at[a, 1] + at[b, 1] - 2 * at[p, 1]) / 3.0
                h = twin[preceding(h)]
                if h == leaving[p]:
                    break
            was_x, was_y = at[p, 0], at[p, 1]
            at[p, 0] += round(x / total)
            at[p, 1] += round(y / total)
            while True:
                if turn(at, p, tail[following(h)], tail[preceding(h)]) <= 0:
                    at[p, 0], at[p, 1] = was_x, was_y
                    break
                h = twin[preceding(h)]
                if h == leaving[p]:
                    break
        make_delaunay(at, tail, twin, len(tail) // 3)
