"""Cut holes into artists' meshes, as an artist selects faces to make anew; what was there is kept.

Used by scripts/train_holes.py and benchmarks/holes.py.
"""

from __future__ import annotations

import random
import zlib
from dataclasses import dataclass

import numpy as np

from ingest.formats import read_mesh
from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from query.holes.loops import Hole, hole_of_faces
from query.holes.topology import MeshTopology
from query.recognition import hash_quads

#: Quads of a hole; below, there is nothing to choose, above, an artist would not select at once.
LEAST_QUADS, MOST_QUADS = 6, 120

#: Everyday holes, by how they are chosen; "star" is the faces around a vertex.
EVERYDAY = ("face", "strip", "star", "block", "grown", "grown")


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """A hole and the artist's own fill of it.

    quads: (q, 4) int32, loop vertices 0..L-1, inner ones after. inner: (k,) mesh vertices.
    counts: (L,) quads at each loop vertex. valences: (L,) quads outside and inside together.
    irregular: vertices, on the loop and inside, whose number of quads is not 4.
    key: different for any other fill of the loop. kind: one of EVERYDAY, or "irregular".
    """

    mesh: str
    hole: Hole
    quads: Int32Array
    inner: Int32Array
    counts: Int32Array
    valences: Int32Array
    irregular: int
    key: bytes
    kind: str

    @property
    def inside(self) -> int:
        """How many irregular vertices lie inside."""
        n = len(self.counts)
        return int((np.bincount(self.quads.ravel(), minlength=n)[n:] != 4).sum())


def read_topology(path: str) -> MeshTopology:
    """Read a mesh file and join its faces."""
    return MeshTopology.of(read_mesh(path))


def cut_holes(
    name: str, topology: MeshTopology, most: int, seed: int, *, tries: int = 120
) -> list[Cut]:
    """Cut up to ``most`` different holes: a face, or those around a vertex, grown one to three
    times.

    Half of the larger ones have the faces around a vertex taken off again. Regions that are no
    disk, touch the border or hold no irregular vertex are left out. tries: the most for each.
    """
    draw = random.Random(seed * 1_000_003 + zlib.crc32(name.encode()))
    t = topology
    arity = t.mesh.arities()
    corners, faces_at, rim = _index_faces(t)
    found: list[Cut] = []
    seen: set[frozenset[int]] = set()
    for _ in range(tries * most):
        if len(found) >= most:
            break
        first = draw.randrange(len(corners))
        region = {first} if draw.random() < 0.5 else set(faces_at[draw.choice(corners[first])])
        for _ in range(draw.randint(1, 3)):
            region |= {g for f in region for v in corners[f] for g in faces_at[v]}
            if len(region) > 2 * MOST_QUADS:
                break
        if draw.random() < 0.5 and len(region) > 8:
            region -= set(faces_at[draw.choice(corners[draw.choice(sorted(region))])])
        chosen = frozenset(region)
        if chosen in seen or not LEAST_QUADS <= len(chosen) <= MOST_QUADS:
            continue
        seen.add(chosen)
        if (arity[sorted(chosen)] != 4).any() or any(v in rim for f in chosen for v in corners[f]):
            continue
        cut = make_cut(name, t, chosen, faces_at)
        if cut is not None and cut.irregular:
            found.append(cut)
    return found


def _index_faces(
    topology: MeshTopology,
) -> tuple[list[list[int]], dict[int, list[int]], set[int]]:
    """Return the corners of every face, the faces at every vertex, and the border's vertices."""
    t = topology
    corners = [t.mesh.corners[a:b].tolist() for a, b in zip(t.start[:-1], t.start[1:], strict=True)]
    faces_at: dict[int, list[int]] = {}
    for f, face in enumerate(corners):
        for v in face:
            faces_at.setdefault(v, []).append(f)
    rim = set(t.tail[t.twin < 0].tolist()) | set(t.head[t.twin < 0].tolist())
    return corners, faces_at, rim


def make_cut(
    name: str,
    topology: MeshTopology,
    faces: frozenset[int],
    faces_at: dict[int, list[int]],
    kind: str = "irregular",
    least: int = 6,
) -> Cut | None:
    """The cut of a set of quads; None where they are no disk with at least so many edges around."""
    try:
        hole = hole_of_faces(topology, faces)
    except ValueError:
        return None
    n = len(hole)
    if n < least or len(set(hole.loop.tolist())) != n or (hole.edges < 0).any():
        return None
    number = {int(v): i for i, v in enumerate(hole.loop)}
    inner: list[int] = []
    quads: list[list[int]] = []
    for f in sorted(faces):
        begin = int(topology.start[f])
        h = begin
        quad: list[int] = []
        for _ in range(4):
            v = int(topology.tail[h])
            if v not in number:
                number[v] = n + len(inner)
                inner.append(v)
            quad.append(number[v])
            h = int(topology.next[h])
        quads.append(quad)
    array = np.array(quads, np.int32)
    twin, fault = weld_quads(array, n + len(inner), n)
    if fault:
        return None
    counts = np.bincount(array.ravel(), minlength=n + len(inner)).astype(np.int32)
    if counts[:n].max() > 4:
        return None
    total = np.array([len(faces_at[int(v)]) for v in hole.loop], np.int32)
    irregular = int((total != 4).sum() + (counts[n:] != 4).sum())
    return Cut(
        name,
        hole,
        array,
        np.array(inner, np.int32),
        counts[:n],
        total,
        irregular,
        hash_quads(array, twin, False),
        kind,
    )


def cut_everyday(
    name: str, topology: MeshTopology, most: int, seed: int, *, tries: int = 40
) -> list[Cut]:
    """Cut up to ``most`` different holes as people delete faces: a face, a strip of two to four,
    those around a vertex, a block, a face or vertex grown once or twice; regular ones, too."""
    draw = random.Random(seed * 1_000_003 + zlib.crc32(name.encode()))
    t = topology
    quad = t.mesh.arities() == 4
    corners, faces_at, rim = _index_faces(t)
    following, twin, face_of = t.next, t.twin, t.face

    def across(h: int) -> int:
        """Return the far half-edge of the quad beyond a half-edge; -1 where there is none."""
        g = int(twin[h])
        if g < 0 or not quad[face_of[g]]:
            return -1
        return int(following[following[g]])

    def draw_edge(f: int) -> int:
        """Return a half-edge of a quad."""
        h = int(t.start[f])
        for _ in range(draw.randrange(4)):
            h = int(following[h])
        return h

    def grow(region: set[int], times: int) -> set[int]:
        """Return a region with all faces at its vertices, so many times."""
        for _ in range(times):
            region = region | {g for f in region for v in corners[f] for g in faces_at[v]}
            if len(region) > 2 * MOST_QUADS:
                break
        return region

    found: list[Cut] = []
    seen: set[frozenset[int]] = set()
    for _ in range(tries * most):
        if len(found) >= most:
            break
        kind = draw.choice(EVERYDAY)
        first = draw.randrange(len(corners))
        if not quad[first]:
            continue
        region = {first}
        if kind == "strip":
            h = draw_edge(first)
            for _ in range(draw.randint(1, 3)):
                h = across(h)
                if h < 0:
                    break
                region.add(int(face_of[h]))
        elif kind == "block":
            h = draw_edge(first)
            rows, columns = draw.randint(2, 4), draw.randint(2, 4)
            for _ in range(rows):
                region.add(int(face_of[h]))
                g = int(following[h])
                for _ in range(columns - 1):
                    g = across(g)
                    if g < 0:
                        break
                    region.add(int(face_of[g]))
                h = across(h)
                if h < 0:
                    break
        elif kind != "face":
            if kind == "star" or draw.random() < 0.5:
                region = set(faces_at[draw.choice(corners[first])])
            if kind == "grown":
                region = grow(region, draw.randint(1, 2))
        chosen = frozenset(region)
        if chosen in seen or len(chosen) > MOST_QUADS:
            continue
        seen.add(chosen)
        if not quad[sorted(chosen)].all() or any(v in rim for f in chosen for v in corners[f]):
            continue
        cut = make_cut(name, t, chosen, faces_at, kind, least=4)
        if cut is not None:
            found.append(cut)
    return found
