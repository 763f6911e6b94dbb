"""What is known around a hole: for every vertex of its loop, the numbers that tell its corners.

At a loop vertex with o quads outside, a fill with 4 - o quads there leaves a regular vertex.
Artists' loops pass irregular vertices too, so angles, lengths and neighbours are looked at as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel
from query.holes.loops import Hole

#: Loop vertices either side whose numbers count too.
REACH = 4

#: Numbers of one vertex, before those of its neighbours are put beside them; and those of the loop.
OWN, WHOLE = 15, 4

#: Numbers of the edge after a vertex, and of that before.
AFTER_AND_BEFORE = ((5, 6), (7, 8), (9, 10))

#: How many numbers :func:`measure_loop` gives a vertex.
N_FEATURES = OWN * (2 * REACH + 1) + WHOLE

#: Rings of faces around the loop that placing looks at.
RINGS = 2


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """The neighbourhood of a hole in numbers of its own: loop vertices 0..L-1 first.

    vertices:  (m,) int32 the mesh's vertices, the loop's first, each loop place apart even where
               the loop passes a vertex twice.
    points:    (m, 3) float64.
    corners, offsets: the faces near the loop, as of a PolygonMesh, turned as the fill's quads.
    outside:   (L,) int32 faces that meet at each loop vertex, outside.
    due:       (L,) int32 quads that would make the vertex regular, which may be none or less.
    asked:     (L,) int32 the same, from 1 to 4.
    normals:   (L, 3) unit normals of the faces outside. angle_outside: (L,) radians that they take.
    beyond:    (L, 3) unit normals of the faces across the loop's edges, 0 where there is none.
    scale:     the geometric mean of the edges of faces at the loop.
    area:      that of their areas.
    spokes:    (L,) mean log length of the edges that leave the loop outwards, nan where none does.
    far_valence: (L,) faces at their far ends, less 4.
    """

    vertices: Int32Array
    points: Floats
    corners: Int32Array
    offsets: NDArray[np.int64]
    outside: Int32Array
    due: Int32Array
    asked: Int32Array
    normals: Floats
    angle_outside: Floats
    beyond: Floats
    scale: float
    area: float
    spokes: Floats
    far_valence: Floats


def look_around(hole: Hole) -> Surroundings:
    """Collect the faces within RINGS rings of a hole, renumbered, loop vertices first."""
    t = hole.outside
    loop = hole.loop
    n = len(loop)
    fans = [walk_fan(hole, i) for i in range(n)]
    first = sorted({int(t.face[h]) for fan in fans for h in fan})
    faces = set(first)
    points = t.mesh.points
    at_vertex = _faces_at(hole, RINGS, faces)
    ring = faces | at_vertex
    number = {}
    place_of: dict[tuple[int, int], int] = {}
    for i, fan in enumerate(fans):
        for h in fan:
            place_of[(int(t.face[h]), int(t.tail[h]))] = i
    vertices = loop.tolist()
    corners: list[int] = []
    offsets = [0]
    ordered = first + sorted(ring - faces)
    for f in ordered:
        begin, end = int(t.start[f]), int(t.start[f + 1])
        h = begin
        for _ in range(end - begin):
            v = int(t.tail[h])
            at = place_of.get((f, v), -1)
            if at < 0:
                if v not in number:
                    number[v] = len(vertices)
                    vertices.append(v)
                at = number[v]
            corners.append(at)
            h = int(t.next[h])
        offsets.append(len(corners))
    index = np.array(vertices, np.int32)
    placed = points[index]
    corner_array = np.array(corners, np.int32)
    offset_array = np.array(offsets, np.int64)
    normals, angle = _measure_fans(placed, corner_array, offset_array, n)
    bare = (normals == 0.0).all(axis=1)
    if bare.any():
        # Nothing outside tells which way is up there: the loop itself does.
        normals[bare] = _loop_normal(hole.points)
    outside = np.array([len(fan) for fan in fans], np.int32)
    due = 4 - outside
    on_border = find_border_places(hole)
    if on_border.any():
        # On the mesh's own border four quads would not be regular: what was there is kept, and
        # where nothing was, a quad takes a right angle.
        there = np.bincount(_removed_corners(hole), minlength=len(points))[loop]
        wide = np.rint(_angles_inside(hole.points, normals) / (np.pi / 2)) - outside
        due = np.where(on_border, np.where(there > 0, there, np.maximum(wide, 1)), due)
    due = due.astype(np.int32)
    scale, area = _scales(placed, corner_array, offset_array, len(first), hole.points)
    spokes, far = _spokes(hole, fans)
    return Surroundings(
        index,
        placed,
        corner_array,
        offset_array,
        outside,
        due,
        np.clip(due, 1, 4).astype(np.int32),
        normals,
        angle,
        _find_normals_beyond(placed, corner_array, offset_array, n),
        scale,
        area,
        spokes,
        far,
    )


def list_faces_near(hole: Hole, rings: int) -> list[int]:
    """The faces outside a hole within so many rings of its loop."""
    at_loop = {int(hole.topology.face[h]) for i in range(len(hole)) for h in walk_fan(hole, i)}
    return sorted(_faces_at(hole, rings, at_loop))


def surround_with_nothing(points: Floats, due: Int32Array) -> Surroundings:
    """Describe a loop (L, 3) that no mesh surrounds, and whose quads at each vertex are given."""
    n = len(points)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    scale = float(np.exp(np.log(np.maximum(lengths, 1e-300)).mean()))
    nothing = np.zeros(0, np.int32)
    return Surroundings(
        np.arange(n, dtype=np.int32),
        points,
        nothing,
        np.zeros(1, np.int64),
        np.zeros(n, np.int32),
        due,
        np.clip(due, 1, 4).astype(np.int32),
        np.tile(_loop_normal(points), (n, 1)),
        np.zeros(n),
        np.zeros((n, 3)),
        scale,
        scale * scale,
        np.full(n, np.nan),
        np.zeros(n),
    )


def measure_loop(hole: Hole, around: Surroundings) -> Floats:
    """(L, N_FEATURES) float64: the numbers that tell how many quads each vertex will get."""
    own = _own_features(
        hole.points,
        around.normals,
        around.angle_outside,
        around.outside,
        around.asked,
        around.scale,
        around.spokes,
        around.far_valence,
    )
    n = len(own)
    at = (np.arange(n)[:, None] + np.arange(-REACH, REACH + 1)[None, :]) % n
    window = own[at].reshape(n, -1)
    turning = float((2 - around.asked).sum())
    by_angle = float((2.0 - own[:, 1] / (np.pi / 2)).sum())
    whole = np.array([np.log(n), turning - 4.0, by_angle - 4.0, float((around.asked != 2).mean())])
    return np.hstack([window, np.broadcast_to(whole, (n, WHOLE))])


def mirror_features(features: Floats) -> Floats:
    """(L, N_FEATURES) what :func:`measure_loop` gives of the mirror image, vertices in the same
    order."""
    n = len(features)
    window = features[:, : OWN * (2 * REACH + 1)].reshape(n, 2 * REACH + 1, OWN)
    swapped = list(range(OWN))
    for after, before in AFTER_AND_BEFORE:
        swapped[after], swapped[before] = before, after
    turned = window[:, ::-1][:, :, swapped].reshape(n, -1)
    return np.hstack([turned, features[:, OWN * (2 * REACH + 1) :]])


def find_border_places(hole: Hole) -> NDArray[np.bool_]:
    """(L,) bool, loop vertices that stay on the mesh's border once the hole is filled."""
    bare = hole.edges < 0
    return bare | np.roll(bare, 1)


def _angles_inside(loop: Floats, normals: Floats) -> Floats:
    """(L,) the angles of a loop, from 0 to 2 pi, seen along the normals (L, 3) at its vertices."""
    after = np.roll(loop, -1, axis=0) - loop
    before = np.roll(loop, 1, axis=0) - loop
    after -= normals * (after * normals).sum(axis=1, keepdims=True)
    before -= normals * (before * normals).sum(axis=1, keepdims=True)
    sine = (np.cross(after, before) * normals).sum(axis=1)
    return np.arctan2(sine, (after * before).sum(axis=1)) % (2 * np.pi)


def walk_fan(hole: Hole, i: int) -> list[int]:
    """Half-edges outside that leave loop vertex i, one a face, from one loop edge to the other."""
    t = hole.outside
    # edges[i] runs from loop vertex i + 1 to i; edges[i - 1] from i to i - 1.
    h = int(hole.edges[i - 1])
    fan: list[int] = []
    if h >= 0:
        # The face on the outer side of the edge before; on, away from the hole.
        while h >= 0 and h not in fan:
            fan.append(h)
            h = int(t.twin[t.previous[h]])
        return fan
    h = int(hole.edges[i])
    while h >= 0:
        leaving = int(t.next[h])
        if leaving in fan:
            break
        fan.append(leaving)
        h = int(t.twin[leaving])
    return fan


def _faces_at(hole: Hole, rings: int, first: set[int]) -> set[int]:
    """Faces within ``rings`` rings of those given, joined by edges."""
    t = hole.outside
    found = set(first)
    front = set(first)
    for _ in range(rings - 1):
        front = {
            int(t.face[g])
            for f in front
            for h in range(int(t.start[f]), int(t.start[f + 1]))
            if (g := int(t.twin[h])) >= 0
        } - found
        found |= front
    return found


def _spokes(hole: Hole, fans: list[list[int]]) -> tuple[Floats, Floats]:
    """(L,) mean log length of the edges that leave the loop outwards; (L,) the faces, less 4, at
    their far ends; 0 where there are none."""
    t = hole.outside
    points = t.mesh.points
    spokes = np.zeros(len(fans))
    far = np.zeros(len(fans))
    for i, fan in enumerate(fans):
        inner = fan[:-1] if len(fan) else []
        lengths: list[float] = []
        valences: list[float] = []
        for h in inner:
            g = int(t.previous[h])
            a, b = int(t.head[g]), int(t.tail[g])
            lengths.append(float(np.linalg.norm(points[a] - points[b])))
            valences.append(count_faces(t.twin, t.next, g) - 4.0)
        if lengths:
            spokes[i] = float(np.log(np.maximum(np.mean(lengths), 1e-300)))
            far[i] = float(np.mean(valences))
        else:
            spokes[i] = np.nan
    return spokes, far


@kernel
def count_faces(twin: Int32Array, following: Int32Array, h: int) -> int:
    """Faces around the tail of a half-edge, 4 where the border is met."""
    count = 0
    g = h
    while count < 64:
        count += 1
        g = twin[g]
        if g < 0:
            return 4
        g = following[g]
        if g == h:
            return count
    return count


def _loop_normal(points: Floats) -> Floats:
    """(3,) the unit normal of a loop's area, by Newell; of z where it has none."""
    area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    return area / size if size > 0 else np.array([0.0, 0.0, 1.0])


def _removed_corners(hole: Hole) -> NDArray[np.int64]:
    """The vertices of the faces that a fill replaces, once for each face."""
    t = hole.topology
    return t.tail[np.isin(t.face, hole.removed)].astype(np.int64)


@kernel
def _measure_fans(
    points: Floats, corners: Int32Array, offsets: NDArray[np.int64], n_loop: int
) -> tuple[Floats, Floats]:
    """(L, 3) unit normals of the faces outside at each loop vertex, weighted by angle, 0 where
    there are none; (L,) radians that they take."""
    normals = np.zeros((n_loop, 3))
    angles = np.zeros(n_loop)
    for f in range(len(offsets) - 1):
        first, last = offsets[f], offsets[f + 1]
        k = last - first
        for e in range(k):
            v = corners[first + e]
            if v >= n_loop:
                continue
            a = points[corners[first + (e + 1) % k]] - points[v]
            b = points[corners[first + (e - 1) % k]] - points[v]
            c = np.cross(a, b)
            s = norm_of(c)
            t = np.arctan2(s, (a * b).sum())
            angles[v] += t
            if s > 0:
                normals[v] += c / s * t
    for v in range(n_loop):
        s = norm_of(normals[v])
        if s > 0:
            normals[v] /= s
    return normals, angles


@kernel
def _find_normals_beyond(
    points: Floats, corners: Int32Array, offsets: NDArray[np.int64], n_loop: int
) -> Floats:
    """(L, 3) unit normals of the faces across the loop's edges, 0 where there is none."""
    beyond = np.zeros((n_loop, 3))
    for f in range(len(offsets) - 1):
        first, last = offsets[f], offsets[f + 1]
        k = last - first
        for e in range(k):
            v, w = corners[first + (e + 1) % k], corners[first + e]
            if v >= n_loop or w != (v + 1) % n_loop:
                continue
            normal = np.zeros(3)
            for c in range(1, k - 1):
                normal += np.cross(
                    points[corners[first + c]] - points[corners[first]],
                    points[corners[first + c + 1]] - points[corners[first]],
                )
            s = norm_of(normal)
            if s > 0:
                beyond[v] = normal / s
    return beyond


@kernel
def norm_of(v: Floats) -> float:
    """The length of a vector (3,)."""
    return np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


def _scales(
    points: Floats, corners: Int32Array, offsets: NDArray[np.int64], n_first: int, loop: Floats
) -> tuple[float, float]:
    """Geometric means of edge lengths and areas of the first faces; of the loop where there are
    none."""
    lengths = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    areas: list[float] = []
    if n_first:
        last = int(offsets[n_first])
        face = np.repeat(np.arange(n_first), np.diff(offsets[: n_first + 1]))
        at = np.arange(last)
        following = np.where(at == offsets[face + 1] - 1, offsets[face], at + 1)
        a, b = points[corners[:last]], points[corners[following]]
        lengths = np.linalg.norm(b - a, axis=1)
        centre = points[corners[offsets[:n_first]]][face]
        cross = np.zeros((n_first, 3))
        np.add.at(cross, face, np.cross(a - centre, b - centre))
        areas = (np.linalg.norm(cross, axis=1) / 2).tolist()
    tiny = 1e-12 * max(float(lengths.max(initial=0.0)), 1e-300)
    scale = float(np.exp(np.log(np.maximum(lengths, tiny)).mean()))
    area = float(np.exp(np.log(np.maximum(areas, tiny**2)).mean())) if areas else scale**2
    return scale, area


@kernel
def _own_features(
    loop: Floats,
    normals: Floats,
    angle_outside: Floats,
    outside: Int32Array,
    asked: Int32Array,
    scale: float,
    spokes: Floats,
    far: Floats,
) -> Floats:
    """(L, OWN) of each vertex alone, and of the edges beside it."""
    n = len(loop)
    rows = np.zeros((n, OWN))
    for i in range(n):
        a = loop[(i + 1) % n] - loop[i]
        b = loop[(i - 1) % n] - loop[i]
        la, lb = norm_of(a), norm_of(b)
        normal = normals[i]
        # The angle inside, in the tangent plane, from the edge after to the edge before.
        u = a - normal * (a * normal).sum()
        w = b - normal * (b * normal).sum()
        c = np.cross(u, w)
        angle = np.arctan2((c * normal).sum(), (u * w).sum())
        if angle < 0:
            angle += 2 * np.pi
        s = np.cross(a, b)
        straight = np.arctan2(norm_of(s), (a * b).sum())
        after, before = normals[(i + 1) % n], normals[(i - 1) % n]
        rows[i, 0] = asked[i]
        rows[i, 1] = angle
        rows[i, 2] = 2 * np.pi - angle_outside[i]
        rows[i, 3] = outside[i]
        rows[i, 4] = straight
        rows[i, 5] = np.log(max(la, 1e-12 * scale) / scale)
        rows[i, 6] = np.log(max(lb, 1e-12 * scale) / scale)
        rows[i, 7] = (normal * after).sum()
        rows[i, 8] = (normal * before).sum()
        rows[i, 9] = (a * normal).sum() / max(la, 1e-12 * scale)
        rows[i, 10] = (b * normal).sum() / max(lb, 1e-12 * scale)
        rows[i, 11] = 0.0 if np.isnan(spokes[i]) else spokes[i] - np.log(scale)
        rows[i, 12] = far[i]
        rows[i, 13] = angle_outside[i] / max(outside[i], 1)
        # How far the loop is across here: the nearest vertex that is no neighbour of this one.
        near = np.inf
        for j in range(n):
            gap = min((i - j) % n, (j - i) % n)
            if gap > 2:
                near = min(near, norm_of(loop[j] - loop[i]))
        rows[i, 14] = np.log(min(near, 100.0 * scale) / scale) if near < np.inf else 0.0
    return rows
