"""Remesh a surface evenly: triangles of one size and nearly one shape, for fields to be solved on.

After Botsch and Kobbelt 2004, "A Remeshing Approach to Multiresolution Modeling": long edges are
split, short ones collapsed, edges flipped towards six triangles a vertex, and vertices moved along
the surface, several times over. Borders stay where they are but for their division.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.faces import GroundParts

#: Rounds of splitting, collapsing, flipping and moving. Source: Botsch and Kobbelt 2004 take five.
ROUNDS = 6

#: Edges longer and shorter than these times the wanted length are split and collapsed. Source:
#: the same.
LONG, SHORT = 4.0 / 3.0, 4.0 / 5.0

#: Sweeps of halving at most: an edge of a thousand times the wanted length takes
#: some thirty.
MOST_HALVINGS = 60

#: A vertex moves by so many wanted lengths at most; from further off it stays for this round.
LONGEST_MOVE = 1.0

#: A part gets so many triangles at least, and so many rows of them around, by its area and the
#: diagonal of its box: on eyes and laces of a few edges' size a field has its singularities, too.
FEWEST, AROUND = 300, 8

#: Of more triangles than these, edges of such parts are no shorter than this part of the wanted
#: length: slivers would get millions of them.
MOST_SMALL, LEAST_SHARE = 1000, 0.15

#: Area of an equilateral triangle, in squared edges.
EQUILATERAL = np.sqrt(3.0) / 4.0

#: A border's vertex may go if its border turns there by less than this: the cosine of 10 degrees.
STRAIGHT = 0.985


def remesh_parts(ground: Ground, edge: float) -> tuple[Points, Int32Array]:
    """(v, 3) vertices and (t, 3) triangles as of :func:`remesh_evenly`, but finer on each part that
    is small or thin against the edge."""
    found = GroundParts.of(ground)
    areas = np.bincount(found.part, ground.surface.areas, found.parts)
    corner = ground.vertices[ground.triangles]
    low, high = np.full((found.parts, 3), np.inf), np.full((found.parts, 3), -np.inf)
    np.minimum.at(low, found.part, corner.min(axis=1))
    np.maximum.at(high, found.part, corner.max(axis=1))
    length = np.linalg.norm(high - low, axis=1)
    finest = np.minimum(np.sqrt(areas / (FEWEST * EQUILATERAL)), areas / (AROUND * length))
    floor = np.minimum(np.sqrt(areas / (MOST_SMALL * EQUILATERAL)), LEAST_SHARE * edge)
    finest = np.maximum(finest, floor)
    small = finest < edge
    if not small.any():
        return remesh_evenly(ground, edge)
    points, triangles, n = list[Points](), list[Int32Array](), 0
    large = ~small[found.part]
    pieces = [(large, edge)] if large.any() else []
    pieces += [(found.part == k, float(finest[k])) for k in np.flatnonzero(small).tolist()]
    for which, size in pieces:
        at, corners = remesh_evenly(Ground.of(ground.vertices, ground.triangles[which]), size)
        points.append(at)
        triangles.append(corners + n)
        n += len(at)
    return np.concatenate(points), np.concatenate(triangles).astype(np.int32)


def remesh_evenly(ground: Ground, edge: float) -> tuple[Points, Int32Array]:
    """(v, 3) vertices on a manifold ground, all turned alike, and (t, 3) triangles of this edge.

    The ground's handles and borders are kept: an edge whose collapse would close a tunnel stays,
    whatever its length.
    """
    points, triangles = ground.vertices.copy(), ground.triangles.copy()
    twin = ground.topology.across.copy()
    for _ in range(ROUNDS):
        points, triangles, twin = _split_long(points, triangles, twin, LONG * edge)
        alive = _collapse_short(points, triangles, twin, SHORT * edge, LONG * edge)
        points, triangles, twin = _compact(points, triangles, twin, alive)
        border = _mark_border(len(points), triangles, twin)
        for _ in range(2):
            _flip_to_valence(points, triangles, twin, border)
        moved, normals = _relax(points, triangles, border)
        inner = np.flatnonzero(~border)
        there = ground.nearest_facing(moved[inner], normals[inner]).points
        # What faces so may be far off, at the other end of a limb: a vertex that leaps there draws
        # triangles with it, which are divided, and leap in turn.
        far = np.linalg.norm(there - points[inner], axis=1) > LONGEST_MOVE * edge
        there[far] = points[inner[far]]
        points[inner] = there
    return points, triangles


def _compact(
    points: Points, triangles: Int32Array, twin: Int32Array, alive: NDArray[np.bool_]
) -> tuple[Points, Int32Array, Int32Array]:
    """Leave out what was collapsed."""
    kept = triangles[alive]
    used = np.unique(kept)
    name = np.full(len(points), -1, np.int32)
    name[used] = np.arange(len(used), dtype=np.int32)
    row = np.cumsum(alive, dtype=np.int32) - 1
    sides = twin.reshape(-1, 3)[alive].ravel()
    joined = sides >= 0
    sides[joined] = 3 * row[sides[joined] // 3] + sides[joined] % 3
    return np.ascontiguousarray(points[used]), np.ascontiguousarray(name[kept]), sides


@kernel
def _apart(points: Points, a: Index, b: Index) -> float:
    x, y, z = (
        points[a, 0] - points[b, 0],
        points[a, 1] - points[b, 1],
        points[a, 2] - points[b, 2],
    )
    return np.sqrt(x * x + y * y + z * z)


@kernel
def _after(h: Index) -> int:
    return h - 2 if h % 3 == 2 else h + 1


@kernel
def _before(h: Index) -> int:
    return h + 2 if h % 3 == 0 else h - 1


@kernel
def _join(twin: Int32Array, a: Index, b: Index) -> None:
    if a >= 0:
        twin[a] = b
    if b >= 0:
        twin[b] = a


@kernel
def _split_long(
    points: Points, triangles: Int32Array, twin: Int32Array, longest: float
) -> tuple[Points, Int32Array, Int32Array]:
    """Halve edges that are too long until none is."""
    nv, nf = len(points), len(triangles)
    at = np.empty((2 * nv + 64, 3))
    at[:nv] = points
    tri = np.empty((2 * nf + 64, 3), np.int32)
    tri[:nf] = triangles
    beside = np.empty(3 * len(tri), np.int32)
    beside[: 3 * nf] = twin
    for _ in range(MOST_HALVINGS):
        last = nf
        for f in range(last):
            # The longest side, as Rivara 1984: any other would make needles of needles.
            e, size = 0, -1.0
            for k in range(3):
                far = _apart(at, tri[f, k], tri[f, (k + 1) % 3])
                if far > size:
                    e, size = k, far
            if size <= longest:
                continue
            h = 3 * f + e
            a, b = tri[f, e], tri[f, (e + 1) % 3]
            if nv + 1 > len(at):
                more = np.empty((2 * len(at), 3))
                more[:nv] = at[:nv]
                at = more
            if nf + 2 > len(tri):
                more_tri = np.empty((2 * len(tri), 3), np.int32)
                more_tri[:nf] = tri[:nf]
                tri = more_tri
                more_beside = np.empty(3 * len(tri), np.int32)
                more_beside[: 3 * nf] = beside[: 3 * nf]
                beside = more_beside
            m = nv
            nv += 1
            for c in range(3):
                at[m, c] = 0.5 * (at[a, c] + at[b, c])
            g = beside[h]
            # (a, b, c) becomes (a, m, c) and (m, b, c).
            c = tri[f, (e + 2) % 3]
            after = beside[3 * f + (e + 1) % 3]
            new = nf
            nf += 1
            tri[f, (e + 1) % 3] = m
            tri[new, 0], tri[new, 1], tri[new, 2] = m, b, c
            _join(beside, 3 * new + 1, after)
            _join(beside, 3 * new + 2, 3 * f + (e + 1) % 3)
            if g < 0:
                beside[3 * new] = -1
                continue
            # (b, a, d) becomes (b, m, d) and (m, a, d).
            k, t = g // 3, g % 3
            d = tri[k, (t + 2) % 3]
            after = beside[3 * k + (t + 1) % 3]
            other = nf
            nf += 1
            tri[k, (t + 1) % 3] = m
            tri[other, 0], tri[other, 1], tri[other, 2] = m, a, d
            _join(beside, 3 * other + 1, after)
            _join(beside, 3 * other + 2, 3 * k + (t + 1) % 3)
            _join(beside, h, 3 * other)
            _join(beside, 3 * new, g)
        if nf == last:
            break
    return at[:nv].copy(), tri[:nf].copy(), beside[: 3 * nf].copy()


@kernel
def _mark_border(n: int, triangles: Int32Array, twin: Int32Array) -> NDArray[np.bool_]:
    found = np.zeros(n, np.bool_)
    for h in range(len(twin)):
        if twin[h] < 0:
            found[triangles[h // 3, h % 3]] = True
            found[_head(triangles, h)] = True
    return found


@kernel
def _ring(
    triangles: Int32Array, twin: Int32Array, first: Index, sides: Int32Array
) -> tuple[int, bool]:
    """The sides that leave a vertex, one of which is given, into ``sides``; how many, and is it
    whole? -1 for more than there is room for."""
    h = first
    n = 0
    while True:
        if n == len(sides):
            return -1, False
        sides[n] = h
        n += 1
        h = twin[_before(h)]
        if h == first:
            return n, True
        if h < 0:
            break
    # The other way round, up to the border.
    h = first
    while True:
        g = twin[h]
        if g < 0:
            return n, False
        h = _after(g)
        if n == len(sides):
            return -1, False
        sides[n] = h
        n += 1


@kernel
def _collapse_short(
    points: Points, triangles: Int32Array, twin: Int32Array, shortest: float, longest: float
) -> NDArray[np.bool_]:
    """Collapse edges that are too short; (t,) which triangles are left."""
    alive = np.ones(len(triangles), np.bool_)
    border = _mark_border(len(points), triangles, twin)
    one = np.empty(64, np.int32)
    two = np.empty(64, np.int32)
    around = np.empty(128, np.int32)
    for f in range(len(triangles)):
        for e in range(3):
            if not alive[f]:
                break
            h = 3 * f + e
            a, b = triangles[f, e], triangles[f, (e + 1) % 3]
            if _apart(points, a, b) >= shortest:
                continue
            g = twin[h]
            # Across the surface no two borders come together.
            if g >= 0 and border[a] and border[b]:
                continue
            na, whole_a = _ring(triangles, twin, h, one)
            nb, whole_b = _ring(triangles, twin, _after(h), two)
            if na < 0 or nb < 0 or na + nb > 60:
                continue
            # Of a tetrahedron, the least there is, two triangles would be left on each other.
            if whole_a and whole_b and na == 3 and nb == 3:
                continue
            # The two have exactly two neighbours in common: else a tunnel or a sheet would close.
            n = 0
            for k in range(na):
                around[n] = _head(triangles, one[k])
                n += 1
            if not whole_a:
                around[n] = _tail_before(triangles, one, na, twin)
                n += 1
            common = 0
            for k in range(nb):
                v = _head(triangles, two[k])
                for j in range(n):
                    if around[j] == v:
                        common += 1
            if not whole_b:
                v = _tail_before(triangles, two, nb, twin)
                for j in range(n):
                    if around[j] == v:
                        common += 1
            if common != (1 if g < 0 else 2):
                continue
            x = np.empty(3)
            for c in range(3):
                x[c] = 0.5 * (points[a, c] + points[b, c])
            if g < 0:
                # A vertex of a border goes only along it, and only where it is straight.
                p = _tail_before(triangles, one, na, twin)
                if not _is_straight(points, p, a, b):
                    continue
                x[:] = points[b]
            elif border[a]:
                x[:] = points[a]
            elif border[b]:
                x[:] = points[b]
            if not (
                _fits(points, triangles, one, na, a, b, x, longest)
                and _fits(points, triangles, two, nb, b, a, x, longest)
            ):
                continue
            # a goes into b.
            for k in range(na):
                triangles[one[k] // 3, one[k] % 3] = b
            points[b] = x
            border[b] = border[a] or border[b]
            left, right = twin[_after(h)], twin[_before(h)]
            _join(twin, left, right)
            alive[f] = False
            if g >= 0:
                left, right = twin[_after(g)], twin[_before(g)]
                _join(twin, left, right)
                alive[g // 3] = False
    return alive


@kernel
def _is_straight(points: Points, a: Index, b: Index, c: Index) -> bool:
    """Does a line from a over b to c run straight on at b?"""
    dot = 0.0
    for k in range(3):
        dot += (points[b, k] - points[a, k]) * (points[c, k] - points[b, k])
    return dot >= STRAIGHT * _apart(points, a, b) * _apart(points, b, c)


@kernel
def _head(triangles: Int32Array, h: Index) -> int:
    return int(triangles[h // 3, (h % 3 + 1) % 3])


@kernel
def _tail_before(triangles: Int32Array, sides: Int32Array, n: int, twin: Int32Array) -> int:
    """The neighbour along the border that no side of an open ring leads to."""
    for k in range(n):
        before = _before(sides[k])
        if twin[before] < 0:
            return triangles[before // 3, before % 3]
    return -1


@kernel
def _fits(
    points: Points,
    triangles: Int32Array,
    sides: Int32Array,
    n: int,
    old: Index,
    other: Index,
    x: Floats,
    longest: float,
) -> bool:
    """May a vertex go to x: no edge too long, no triangle turned over?"""
    was, now = np.empty(3), np.empty(3)
    for k in range(n):
        f, e = sides[k] // 3, sides[k] % 3
        p, q = triangles[f, (e + 1) % 3], triangles[f, (e + 2) % 3]
        if p == other or q == other:
            continue
        for v in (p, q):
            far = 0.0
            for c in range(3):
                far += (points[v, c] - x[c]) ** 2
            if far > longest * longest:
                return False
        _cross(points[old], points[p], points[q], was)
        _cross(x, points[p], points[q], now)
        dot, big, small = 0.0, 0.0, 0.0
        for c in range(3):
            dot += was[c] * now[c]
            big += was[c] * was[c]
            small += now[c] * now[c]
        # Within 60 degrees, and no needle.
        if dot <= 0.5 * np.sqrt(big * small) or small < 1e-4 * longest**4:
            return False
    return True


@kernel
def _cross(a: Floats, b: Floats, c: Floats, out: Floats) -> None:
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    out[0], out[1], out[2] = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@kernel
def _flip_to_valence(
    points: Points, triangles: Int32Array, twin: Int32Array, border: NDArray[np.bool_]
) -> None:
    """Flip edges where that brings valences nearer to 6, or 4 on the border."""
    valence = np.zeros(len(points), np.int32)
    for f in range(len(triangles)):
        for e in range(3):
            valence[triangles[f, e]] += 1
    for v in range(len(points)):
        valence[v] += 3 if border[v] else 0  # of 3 triangles, a border's vertex counts as 6
    ring = np.empty(64, np.int32)
    n1, n2, m1, m2 = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for h in range(len(twin)):
        g = twin[h]
        if g < 0 or g < h:
            continue
        f, e = h // 3, h % 3
        k, t = g // 3, g % 3
        a, b = triangles[f, e], triangles[f, (e + 1) % 3]
        c, d = triangles[f, (e + 2) % 3], triangles[k, (t + 2) % 3]
        if c == d:
            continue
        before = (
            abs(valence[a] - 6) + abs(valence[b] - 6) + abs(valence[c] - 6) + abs(valence[d] - 6)
        )
        after = (
            abs(valence[a] - 7) + abs(valence[b] - 7) + abs(valence[c] - 5) + abs(valence[d] - 5)
        )
        if after >= before or valence[a] <= 4 or valence[b] <= 4:
            continue
        n, whole = _ring(triangles, twin, _before(h), ring)
        if n < 0:
            continue
        there = not whole and _tail_before(triangles, ring, n, twin) == d
        for j in range(n):
            there = there or _head(triangles, ring[j]) == d
        if there:
            continue
        _cross(points[a], points[b], points[c], n1)
        _cross(points[b], points[a], points[d], n2)
        _cross(points[c], points[d], points[b], m1)
        _cross(points[d], points[c], points[a], m2)
        up = n1 + n2
        size = np.sqrt((up * up).sum())
        low = 0.5 * size
        if (m1 * up).sum() < low * np.sqrt((m1 * m1).sum()) or (m2 * up).sum() < low * np.sqrt(
            (m2 * m2).sum()
        ):
            continue
        if (m1 * m1).sum() < 1e-3 * size * size or (m2 * m2).sum() < 1e-3 * size * size:
            continue
        # (a, b, c) and (b, a, d) become (c, d, b) and (d, c, a).
        bc, ca = twin[_after(h)], twin[_before(h)]
        ad, db = twin[_after(g)], twin[_before(g)]
        triangles[f, 0], triangles[f, 1], triangles[f, 2] = c, d, b
        triangles[k, 0], triangles[k, 1], triangles[k, 2] = d, c, a
        _join(twin, 3 * f, 3 * k)
        _join(twin, 3 * f + 1, db)
        _join(twin, 3 * f + 2, bc)
        _join(twin, 3 * k + 1, ca)
        _join(twin, 3 * k + 2, ad)
        valence[a] -= 1
        valence[b] -= 1
        valence[c] += 1
        valence[d] += 1


@kernel
def _relax(
    points: Points, triangles: Int32Array, border: NDArray[np.bool_]
) -> tuple[Points, Points]:
    """Where vertices are wanted along the surface, between their triangles; and their normals."""
    n = len(points)
    middle = np.zeros((n, 3))
    weight = np.zeros(n)
    normals = np.zeros((n, 3))
    up = np.empty(3)
    for f in range(len(triangles)):
        a, b, c = triangles[f, 0], triangles[f, 1], triangles[f, 2]
        _cross(points[a], points[b], points[c], up)
        area = np.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2)
        for e in range(3):
            v = triangles[f, e]
            weight[v] += area
            for d in range(3):
                normals[v, d] += up[d]
                middle[v, d] += area * (points[a, d] + points[b, d] + points[c, d]) / 3.0
    for v in range(n):
        size = np.sqrt(normals[v, 0] ** 2 + normals[v, 1] ** 2 + normals[v, 2] ** 2)
        if size == 0.0 or weight[v] == 0.0 or border[v]:
            middle[v] = points[v]
            continue
        off = 0.0
        for d in range(3):
            normals[v, d] /= size
            middle[v, d] = middle[v, d] / weight[v] - points[v, d]
            off += middle[v, d] * normals[v, d]
        for d in range(3):
            middle[v, d] += points[v, d] - off * normals[v, d]
    return middle, normals
