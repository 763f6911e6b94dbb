"""Polygons on an integer grid: exact turns, whether one crosses itself, and its ears.

On integers below GRID every predicate here is exact in 64 bits, so that no polygon, however
noisy, nearly touching or full of vertices in a row on one line, leads to an inverted triangle.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int64Array
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.network import InvalidNetworkError

#: Coordinates run from 0 to this. A turn is a difference of two products of two differences:
#: below 2**61, so it fits in 64 bits. One step is 1e-9 of the polygon's extent.
GRID = 1 << 30

#: Relative error of the sum in :func:`is_within_circle`, beneath which its sign says nothing
#: (Shewchuk 1997, "Adaptive precision floating-point arithmetic", its first filter).
CIRCLE_ERROR = (10.0 + 96.0 * 2.0**-53) * 2.0**-53

#: The most points inside one polygon: some seconds, and a mesh that is surely a slip.
MAX_INNER = 1_000_000

#: Lattice points this near to the boundary, in spacings, are left out: the rows of a lattice
#: are 0.87 apart, and the smoothing moves the outermost row to about that.
CLEARANCE = 0.6

#: Rounds of smoothing. The shapes hardly change after the fourth.
ROUNDS = 4


@kernel(inline="always")
def turn(at: Int64Array, a: Index, b: Index, c: Index) -> int:
    """Twice the signed area of the triangle of three points: above 0 counter-clockwise."""
    return (at[b, 0] - at[a, 0]) * (at[c, 1] - at[a, 1]) - (at[b, 1] - at[a, 1]) * (
        at[c, 0] - at[a, 0]
    )


@kernel
def doubled_area(at: Int64Array) -> float:
    """Twice the signed area of a closed polygon (m, 2)."""
    total = 0.0
    for i in range(1, len(at) - 1):
        total += float(turn(at, 0, i, i + 1))
    return total


@kernel
def _between(at: Int64Array, a: Index, b: Index, c: Index) -> bool:
    """Of three points on one line: does c lie on the segment from a to b, ends included?"""
    for d in range(2):
        if at[c, d] < min(at[a, d], at[b, d]) or at[c, d] > max(at[a, d], at[b, d]):
            return False
    return True


@kernel
def _meet(at: Int64Array, a: Index, b: Index, c: Index, d: Index) -> bool:
    """Do the segments a-b and c-d have a point in common?"""
    for axis in range(2):
        if max(at[a, axis], at[b, axis]) < min(at[c, axis], at[d, axis]):
            return False
        if max(at[c, axis], at[d, axis]) < min(at[a, axis], at[b, axis]):
            return False
    to_c, to_d = turn(at, a, b, c), turn(at, a, b, d)
    to_a, to_b = turn(at, c, d, a), turn(at, c, d, b)
    # By signs: a product of two turns would not fit.
    if ((to_c > 0 and to_d < 0) or (to_c < 0 and to_d > 0)) and (
        (to_a > 0 and to_b < 0) or (to_a < 0 and to_b > 0)
    ):
        return True
    return (
        (to_c == 0 and _between(at, a, b, c))
        or (to_d == 0 and _between(at, a, b, d))
        or (to_a == 0 and _between(at, c, d, a))
        or (to_b == 0 and _between(at, c, d, b))
    )


@kernel
def is_simple(at: Int64Array) -> bool:
    """Does the closed polygon (m, 2) run counter-clockwise without touching itself?

    Vertices in a row on one line are fine; two at one place and edges that fold back are not.
    """
    m = len(at)
    if doubled_area(at) <= 0.0:
        return False
    for i in range(m):
        a, b, c = i, (i + 1) % m, (i + 2) % m
        if at[a, 0] == at[b, 0] and at[a, 1] == at[b, 1]:
            return False
        if turn(at, a, b, c) == 0:
            along = (at[b, 0] - at[a, 0]) * (at[c, 0] - at[b, 0])
            along += (at[b, 1] - at[a, 1]) * (at[c, 1] - at[b, 1])
            if along < 0:
                return False
        for j in range(i + 2, m - 1 if i == 0 else m):
            if _meet(at, a, b, j, (j + 1) % m):
                return False
    return True


@kernel
def _is_ear(at: Int64Array, after: NDArray[np.int64], p: Index, v: Index, q: Index) -> bool:
    """Is the triangle of a vertex and its neighbours inside, with no other vertex on it?"""
    if turn(at, p, v, q) <= 0:
        return False
    low_x = min(at[p, 0], at[v, 0], at[q, 0])
    high_x = max(at[p, 0], at[v, 0], at[q, 0])
    low_y = min(at[p, 1], at[v, 1], at[q, 1])
    high_y = max(at[p, 1], at[v, 1], at[q, 1])
    k = after[q]
    while k != p:
        x, y = at[k, 0], at[k, 1]
        if (
            low_x <= x <= high_x
            and low_y <= y <= high_y
            and turn(at, p, v, k) >= 0
            and turn(at, v, q, k) >= 0
            and turn(at, q, p, k) >= 0
        ):
            return False
        k = after[k]
    return True


@kernel
def clip_ears(at: Int64Array, m: int, tail: Int64Array, twin: Int64Array) -> None:
    """Triangulate the simple counter-clockwise polygon of the first m points, in place.

    tail, twin: (3 (m - 2),) int64 or longer, filled here. Half-edge 3 t + e leaves vertex
    tail[3 t + e] of triangle t; twin is the half-edge on its other side, -1 on the boundary.

    Every simple polygon has an ear (Meisters 1975), and so has one with vertices in a row on
    one line: a leaf of any of its triangulations. Clipping one leaves such a polygon, because
    no vertex lies on the cut.
    """
    after = np.empty(m, np.int64)
    before = np.empty(m, np.int64)
    for i in range(m):
        after[i] = (i + 1) % m
        before[i] = (i - 1) % m
    # What lies beyond the edge from a vertex to the next: a triangle's half-edge, or nothing.
    beyond = np.full(m, -1, np.int64)
    v = 0
    for t in range(m - 2):
        while not _is_ear(at, after, before[v], v, after[v]):
            v = after[v]
        p, q = before[v], after[v]
        h = 3 * t
        tail[h], tail[h + 1], tail[h + 2] = p, v, q
        twin[h], twin[h + 1], twin[h + 2] = beyond[p], beyond[v], -1
        for k in (h, h + 1):
            if twin[k] >= 0:
                twin[twin[k]] = k
        after[p] = q
        before[q] = p
        beyond[p] = 3 * t + 2
        # Not the next one: ears in a row would make a fan of thin triangles.
        v = after[q]
    last = 3 * (m - 2) - 1
    if beyond[tail[last]] >= 0:
        g = beyond[tail[last]]
        twin[last] = g
        twin[g] = last


@kernel(inline="always")
def following(h: Index) -> int:
    """The half-edge after h in its triangle, counter-clockwise."""
    return h + 1 if h % 3 < 2 else h - 2


@kernel(inline="always")
def preceding(h: Index) -> int:
    """The half-edge before h in its triangle."""
    return h - 1 if h % 3 > 0 else h + 2


@kernel
def is_within_circle(at: Int64Array, a: Index, b: Index, c: Index, d: Index) -> bool:
    """Is d surely within the circle through a, b, c (counter-clockwise)?"""
    ax, ay = float(at[a, 0] - at[d, 0]), float(at[a, 1] - at[d, 1])
    bx, by = float(at[b, 0] - at[d, 0]), float(at[b, 1] - at[d, 1])
    cx, cy = float(at[c, 0] - at[d, 0]), float(at[c, 1] - at[d, 1])
    bc, cb = bx * cy, cx * by
    ca, ac = cx * ay, ax * cy
    ab, ba = ax * by, bx * ay
    a2, b2, c2 = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    total = a2 * (bc - cb) + b2 * (ca - ac) + c2 * (ab - ba)
    size = (abs(bc) + abs(cb)) * a2 + (abs(ca) + abs(ac)) * b2 + (abs(ab) + abs(ba)) * c2
    return total > CIRCLE_ERROR * size


@kernel
def flip_edge(tail: Int64Array, twin: Int64Array, h: Index) -> None:
    """Turn the inner edge of half-edge h within the quad of its two triangles."""
    g = twin[h]
    hp, gp = preceding(h), preceding(g)
    c, d = tail[hp], tail[gp]
    beyond_h, beyond_g = twin[gp], twin[hp]
    tail[h] = d
    tail[g] = c
    twin[h] = beyond_h
    twin[g] = beyond_g
    if beyond_h >= 0:
        twin[beyond_h] = h
    if beyond_g >= 0:
        twin[beyond_g] = g
    twin[hp] = gp
    twin[gp] = hp


@kernel
def make_delaunay(at: Int64Array, tail: Int64Array, twin: Int64Array, triangles: int) -> None:
    """Flip inner edges of the first triangles until each is locally Delaunay.

    An edge is flipped only where the test is certain. Then its quad is convex, and the flip
    lowers the surface over the paraboloid: it ends.
    """
    n = 3 * triangles
    waiting = np.ones(n, np.bool_)
    stack = np.empty(n, np.int64)
    for h in range(n):
        stack[h] = h
    top = n
    while top:
        top -= 1
        h = stack[top]
        waiting[h] = False
        g = twin[h]
        if g < 0:
            continue
        a, b, c = tail[h], tail[following(h)], tail[preceding(h)]
        if not is_within_circle(at, a, b, c, tail[preceding(g)]):
            continue
        flip_edge(tail, twin, h)
        for k in (h, following(h), g, following(g)):
            if not waiting[k]:
                waiting[k] = True
                stack[top] = k
                top += 1


@kernel
def find_triangle(
    at: Int64Array, tail: Int64Array, twin: Int64Array, triangles: int, p: Index, first: int
) -> int:
    """The triangle that holds point p, walking there from the first; -1 if none does."""
    t = first
    for _ in range(triangles):
        beyond = -2
        for e in range(3):
            h = 3 * t + e
            if turn(at, tail[h], tail[following(h)], p) < 0:
                beyond = twin[h]
                break
        if beyond == -2:
            return t
        if beyond < 0:
            break
        t = beyond // 3
    # The straight way there leaves a concave polygon.
    for t in range(triangles):
        h = 3 * t
        if (
            turn(at, tail[h], tail[h + 1], p) >= 0
            and turn(at, tail[h + 1], tail[h + 2], p) >= 0
            and turn(at, tail[h + 2], tail[h], p) >= 0
        ):
            return t
    return -1


@kernel
def insert_point(
    at: Int64Array,
    tail: Int64Array,
    twin: Int64Array,
    triangles: int,
    p: Index,
    t: int,
    stack: Int64Array,
) -> None:
    """Join point p, in triangle t and on no boundary edge, to a Delaunay triangulation.

    Uses the two triangles after the first ``triangles``. stack: room for as many half-edges as
    there are vertices, and three more.
    """
    h = 3 * t
    u = 3 * triangles
    v = u + 3
    a, b, c = tail[h], tail[h + 1], tail[h + 2]
    of_u, of_v = twin[h + 1], twin[h + 2]
    tail[h + 2] = p
    tail[u], tail[u + 1], tail[u + 2] = b, c, p
    tail[v], tail[v + 1], tail[v + 2] = c, a, p
    twin[u], twin[v] = of_u, of_v
    if of_u >= 0:
        twin[of_u] = u
    if of_v >= 0:
        twin[of_v] = v
    for one, other in ((h + 1, u + 2), (u + 1, v + 2), (v + 1, h + 2)):
        twin[one] = other
        twin[other] = one
    stack[0], stack[1], stack[2] = h, u, v
    top = 3
    while top:
        top -= 1
        k = stack[top]
        g = twin[k]
        if g < 0:
            continue
        a, b = tail[k], tail[following(k)]
        # A point on an edge leaves a triangle without area there: that edge has to go.
        if turn(at, a, b, p) > 0 and not is_within_circle(at, a, b, p, tail[preceding(g)]):
            continue
        flip_edge(tail, twin, k)
        stack[top] = k
        stack[top + 1] = following(g)
        top += 2


def triangulate_polygon(grid: Int64Array) -> tuple[Int64Array, Int64Array]:
    """(tail, twin) of the constrained Delaunay triangulation of a simple polygon (m, 2)."""
    n = 3 * (len(grid) - 2)
    tail, twin = np.empty(n, np.int64), np.empty(n, np.int64)
    clip_ears(grid, len(grid), tail, twin)
    make_delaunay(grid, tail, twin, len(grid) - 2)
    return tail, twin


def fill_polygon(
    grid: Int64Array, tail: Int64Array, twin: Int64Array, spacing: float
) -> tuple[Int64Array, Int64Array, Int64Array]:
    """A triangulated polygon with points inside, about ``spacing`` steps of the grid apart.

    grid: (m, 2) int64, simple, counter-clockwise. tail, twin: its triangulation, see
    :func:`triangulate_polygon`. Returns the points (m + k, 2), the polygon's first, and the
    constrained Delaunay triangulation of all of them. k is 0 where the polygon has no room.

    Raises InvalidNetworkError for more than MAX_INNER points.
    """
    wanted = doubled_area(grid) / (math.sqrt(3.0) * spacing * spacing)
    if wanted > MAX_INNER:
        raise InvalidNetworkError(
            f"the spacing would make {wanted:.3g} points inside one piece; the limit is "
            f"{MAX_INNER:,}, so make it longer"
        )
    inner = lay_lattice(grid, spacing)
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
def lay_lattice(grid: Int64Array, spacing: float) -> Int64Array:
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
        t = find_triangle(at, tail, twin, triangles, p, t)
        if t < 0:
            return p
        insert_point(at, tail, twin, triangles, p, t, stack)
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
