"""The neighbourhood of a hole: the mesh near its loop, renumbered, and the loop's own shape.

At a loop vertex with o quads outside, a fill with 4 - o quads there leaves a regular vertex.
Artists' loops pass irregular vertices too, so angles, lengths and neighbours are measured as well
(:mod:`query.holes.features`). A loop is also bound by the edges outside that join its vertices
(:class:`HoleRim`): an edge has two faces, and quads within that join the two again would make it
four.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.neighbourhood import (
    count_faces,
    find_normals_beyond,
    measure_fans,
)
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from query.holes.loops import Hole

#: Rings of faces around the loop that placing looks at.
RINGS = 2


@dataclass(frozen=True, slots=True, eq=False)
class Neighbourhood:
    """The neighbourhood of a hole in numbers of its own: loop vertices 0..L-1 first.

    vertices:  (m,) int32 the mesh's vertices, the loop's first, each loop place apart even where
               the loop passes a vertex twice.
    points:    (m, 3) float64.
    corners, offsets: the faces near the loop, as of a PolygonMesh, turned as the fill's quads.
    outside:   (L,) int32 faces that meet at each loop vertex, outside.
    regular_valence: (L,) int32 quads that would make the vertex regular, which may be none or
               less.
    clamped_valence: (L,) int32 the same, from 1 to 4.
    normals:   (L, 3) unit normals of the faces outside. angle_outside: (L,) radians that they take.
    beyond:    (L, 3) unit normals of the faces across the loop's edges, 0 where there is none.
    scale:     the geometric mean of the edges of faces at the loop.
    area:      that of their areas.
    spokes:    (L,) mean log length of the edges that leave the loop outwards, nan where none does.
    far_valence: (L,) faces at their far ends, less 4.
    fans:      at each loop vertex the half-edges of the mesh that leave it outside, one a face,
               from one loop edge to the other.
    """

    vertices: Int32Array
    points: Floats
    corners: Int32Array
    offsets: NDArray[np.int64]
    outside: Int32Array
    regular_valence: Int32Array
    clamped_valence: Int32Array
    normals: Floats
    angle_outside: Floats
    beyond: Floats
    scale: float
    area: float
    spokes: Floats
    far_valence: Floats
    fans: tuple[Sequence[int], ...]


def extract_neighbourhood(hole: Hole) -> Neighbourhood:
    """Collect the faces within RINGS rings of a hole, renumbered, loop vertices first."""
    t = hole.outside
    loop = hole.loop
    n = len(loop)
    fans = tuple(_walk_fan(hole, i) for i in range(n))
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
    normals, angle = measure_fans(placed, corner_array, offset_array, n)
    bare = (normals == 0.0).all(axis=1)
    if bare.any():
        # Nothing outside tells which way is up there: the loop itself does.
        normals[bare] = _loop_normal(hole.points)
    outside = np.array([len(fan) for fan in fans], np.int32)
    regular_valence = 4 - outside
    on_border = find_border_places(hole)
    if on_border.any():
        # On the mesh's own border four quads would not be regular: what was there is kept, and
        # where nothing was, a quad takes a right angle.
        there = np.bincount(_removed_corners(hole), minlength=len(points))[loop]
        wide = np.rint(_angles_inside(hole.points, normals) / (np.pi / 2)) - outside
        regular_valence = np.where(
            on_border, np.where(there > 0, there, np.maximum(wide, 1)), regular_valence
        )
    regular_valence = regular_valence.astype(np.int32)
    scale, area = _scales(placed, corner_array, offset_array, len(first), hole.points)
    spokes, far = _spokes(hole, fans)
    return Neighbourhood(
        index,
        placed,
        corner_array,
        offset_array,
        outside,
        regular_valence,
        np.clip(regular_valence, 1, 4).astype(np.int32),
        normals,
        angle,
        find_normals_beyond(placed, corner_array, offset_array, n),
        scale,
        area,
        spokes,
        far,
        fans,
    )


def list_faces_near(hole: Hole, rings: int) -> list[int]:
    """The faces outside a hole within so many rings of its loop."""
    at_loop = {int(hole.topology.face[h]) for i in range(len(hole)) for h in _walk_fan(hole, i)}
    return sorted(_faces_at(hole, rings, at_loop))


def make_bare_neighbourhood(points: Floats, regular_valence: Int32Array) -> Neighbourhood:
    """Describe a loop (L, 3) that no mesh surrounds, and whose quads at each vertex are given."""
    n = len(points)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    scale = float(np.exp(np.log(np.maximum(lengths, 1e-300)).mean()))
    nothing = np.zeros(0, np.int32)
    return Neighbourhood(
        np.arange(n, dtype=np.int32),
        points,
        nothing,
        np.zeros(1, np.int64),
        np.zeros(n, np.int32),
        regular_valence,
        np.clip(regular_valence, 1, 4).astype(np.int32),
        np.tile(_loop_normal(points), (n, 1)),
        np.zeros(n),
        np.zeros((n, 3)),
        scale,
        scale * scale,
        np.full(n, np.nan),
        np.zeros(n),
        ((),) * n,
    )


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


def _walk_fan(hole: Hole, i: int) -> list[int]:
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


def _spokes(hole: Hole, fans: tuple[Sequence[int], ...]) -> tuple[Floats, Floats]:
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


def _loop_normal(points: Floats) -> Floats:
    """(3,) the unit normal of a loop's area, by Newell; of z where it has none."""
    area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    return area / size if size > 0 else np.array([0.0, 0.0, 1.0])


def _removed_corners(hole: Hole) -> NDArray[np.int64]:
    """The vertices of the faces that a fill replaces, once for each face."""
    t = hole.topology
    return t.tail[np.isin(t.face, hole.removed)].astype(np.int64)


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


@dataclass(frozen=True, slots=True, eq=False)
class HoleRim:
    """A loop, and which of its places are joined outside.

    loop:   (L,) int32 vertices. joined: (L, L) bool, does the mesh join two places that are not
            next to each other, or are they one vertex?
    bound:  is any pair joined? twice: does the loop run through a vertex twice?
    """

    loop: Int32Array
    joined: NDArray[np.bool_]
    bound: bool
    twice: bool

    @classmethod
    def of(cls, hole: Hole) -> HoleRim:
        """Of a hole; faces that are made anew join nothing."""
        topology, loop = hole.topology, hole.loop
        n = len(loop)
        kept = np.ones(topology.mesh.n_faces, np.bool_)
        kept[hole.removed] = False
        near = np.isin(topology.tail, loop) & np.isin(topology.head, loop) & kept[topology.face]
        names, name = np.unique(loop, return_inverse=True)
        one = np.searchsorted(names, topology.tail[near])
        two = np.searchsorted(names, topology.head[near])
        by_name = np.eye(len(names), dtype=np.bool_)
        by_name[one, two] = by_name[two, one] = True
        joined = by_name[name][:, name]
        place = np.arange(n)
        for step in (-1, 0, 1):
            joined[place, (place + step) % n] = False
        return cls(loop, joined, bool(joined.any()), len(names) < n)

    def admits(self, quads: Int32Array) -> bool:
        """May these quads (q, 4), loop vertices 0 to L - 1, inner ones after, be welded in?"""
        if not self.bound:
            return True
        n = len(self.loop)
        a, b = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
        within = (a < n) & (b < n)
        if self.joined[a[within], b[within]].any():
            return False
        if not self.twice:
            return True
        # Two edges of the fill may be one where their ends are one vertex.
        top = int(quads.max()) + 1
        name = np.arange(top)
        name[:n] = np.unique(self.loop, return_inverse=True)[1]
        name[n:] += n
        a, b = name[a], name[b]
        _, uses = np.unique(np.minimum(a, b) * (top + n) + np.maximum(a, b), return_counts=True)
        return bool(uses.max() <= 2)
