"""Mirror symmetry: of a loop, which its fills follow, and of a mesh, whose other side shows a fill.

A hole across the plane of a face's or a body's symmetry has a loop that a reflection maps onto
itself. Artists' fills follow it all but always (205 of 207 such holes of 28 meshes), so corners and
fills that do not are hardly likely.

Where the other side of a mesh has the same hole, what fills one fills the other
(:meth:`TwinFinder.match`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from query.holes.loops import Hole
from query.holes.topology import MeshTopology
from query.recognition import hash_quads

#: How far a vertex may lie from the image of its partner, in mean edges of the loop.
NEAR = 0.1

#: What a fill loses in score, which is a logarithm of odds, by a mirror that it does not follow:
#: log(206 / 3), by the artists' fills counted above.
ASYMMETRIC = 4.2

#: Distances that differ by less than this part of NEAR edges are rounding: the mirrors are equally
#: exact, and stand in the order of their numbers.
ROUNDING = 1e-6

#: Mirrors of a loop that are looked at, the most exact ones: a flat circle has one at each edge.
MOST_MIRRORS = 8


#: Mirrors of a loop of which a fill is to follow each.
BOTH = 2


def find_mirrors(points: Floats, regular_valence: Int32Array) -> Int32Array:
    """(m,) int32, most exact first: s, where a reflection takes each vertex i of a loop to s - i.

    points: (L, 3). regular_valence: (L,) quads that make the loop regular, which a reflection
    has to keep.
    """
    n = len(points)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    near = NEAR * float(lengths.mean())
    centred = points - points.mean(axis=0)
    radius = np.linalg.norm(centred, axis=1)
    found: list[tuple[int, int]] = []
    at = np.arange(n)
    for s in range(n):
        image = (s - at) % n
        if (regular_valence != regular_valence[image]).any() or (
            np.abs(radius - radius[image]) > near
        ).any():
            continue
        # The plane's normal is that along which partners differ most: the least eigenvector of
        # the sum of what they have in common.
        common = centred.T @ centred[image]
        normal = np.linalg.eigh(common + common.T)[1][:, 0]
        across = centred[image] - 2 * np.outer(centred[image] @ normal, normal)
        off = float(np.linalg.norm(centred - across, axis=1).max())
        if off <= near:
            # A loop whose vertices all lie at one place has no mean edge to measure by.
            found.append((round(off / (near * ROUNDING)) if near > 0.0 else 0, s))
    return np.array([s for _, s in sorted(found)[:MOST_MIRRORS]], np.int32)


def follow_mirrors(quads_at: Int32Array, mirrors: Int32Array) -> NDArray[np.bool_]:
    """(c,) bool, does a mirror keep the numbers (c, L) at a loop's vertices? True without any."""
    n = quads_at.shape[1]
    kept = np.full(len(quads_at), not len(mirrors))
    for s in mirrors.tolist():
        kept |= (quads_at == quads_at[:, (s - np.arange(n)) % n]).all(axis=1)
    return kept


def count_followed(
    quads: Int32Array, n_vertices: int, n: int, key: bytes, mirrors: Int32Array
) -> int:
    """Count the mirrors that map a fill with n loop vertices, whose key is given, onto itself."""
    at_loop = np.bincount(quads.ravel(), minlength=n)[None, :n].astype(np.int32)
    count = 0
    for s in mirrors.tolist():
        if not follow_mirrors(at_loop, np.array([s], np.int32))[0]:
            continue
        image = np.where(quads < n, (s - quads) % n, quads)[:, ::-1].astype(np.int32)
        image = np.ascontiguousarray(image)
        twin, _ = weld_quads(image, n_vertices, n)
        count += hash_quads(image, twin, False) == key
    return count


def lose_by_mirrors(n_mirrors: int, followed: int) -> float:
    """Return what a fill loses in score that follows some of its loop's mirrors.

    A loop with two, such as a slot's, is symmetric across two planes, and each counts. With more it
    is round or a regular polygon; no fill follows all, and one is enough.
    """
    missed = n_mirrors - followed if n_mirrors <= BOTH else int(followed == 0)
    return ASYMMETRIC * missed


#: A vertex is the mirror image of another if it is this near, as a part of the mesh's diagonal.
AT_IMAGE = 2e-3

#: A twin of more faces than this is no hole's.
MOST_FACES = 5_000


#: Two holes are mirror images of each other if their vertices are this near, as a part of the mean
#: edge of the loop: clothes on a body that is not quite symmetric are so within 0.6 to 1 of it.
NEAR_PAIR = 1.0

#: Planes are found by so many vertices, in so many rounds; so large a part must have an image.
SAMPLES, ROUNDS, MOSTLY = 3_000, 12, 0.5

#: A unit normal (3,) and the distance of a plane from the origin along it.
Plane = tuple[NDArray[np.float64], float]


@dataclass(frozen=True, slots=True, eq=False)
class MirroredHole:
    """How the loop of a hole is the mirror image of another one's.

    places: (L,) int64 the place in the other loop whose mirror image lies at each place.
    plane:  that of symmetry. exact: is the mirror image of a point of the other side where the
            point belongs on this one, or only near it?
    """

    places: NDArray[np.int64]
    plane: Plane
    exact: bool

    def mirror_quads(self, quads: Int32Array, n_vertices: int) -> Int32Array:
        """Quads (q, 4) int32 of the other loop as quads of this one; inner vertices keep their
        numbers."""
        here = np.arange(n_vertices, dtype=np.int32)
        here[self.places] = np.arange(len(self.places))
        return here[quads[:, ::-1]]

    def mirror_points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The mirror images of points (k, 3)."""
        return _reflect(points, *self.plane)


@lru_cache(maxsize=4)
def prepare_twins(topology: MeshTopology) -> TwinFinder:
    """Prepare a mesh for finding the twins of its holes; kept for the last few meshes."""
    return TwinFinder(topology)


class TwinFinder:
    """Finds twins in one mesh; prepared once for all of its holes: see :func:`prepare_twins`."""

    def __init__(self, topology: MeshTopology) -> None:
        # Imported here because what else is known of holes serves queries that need no tree.
        from scipy.spatial import KDTree

        mesh = topology.mesh
        self._topology = topology
        self._used = np.unique(mesh.corners)
        self._points = mesh.points[self._used]
        self._tree = KDTree(self._points)
        low, high = self._points.min(axis=0), self._points.max(axis=0)
        self._diagonal = float(np.linalg.norm(high - low))
        self._middle = (low + high) / 2
        ends = zip(topology.tail.tolist(), topology.head.tolist(), strict=True)
        self._found: list[Plane] | None = None
        self._true: list[Plane] | None = None
        self._edge = {pair: h for h, pair in enumerate(ends)}

    def find(self, hole: Hole) -> tuple[Int32Array, NDArray[np.float64]] | None:
        """The artist's own quads on the other side of a symmetry plane, turned to fit the hole.

        Returns (q, 4) int32 quads, loop vertices 0..L-1, and the mirrored points (k, 3) of their
        inner vertices; None where the mesh has no such twin, or it is no disk of quads.
        """
        for normal, offset in self._planes():
            found = self._find_beyond(hole, normal, offset)
            if found is not None:
                return found
        return None

    def _planes(self) -> Iterator[Plane]:
        """Planes to try: across x, y, z through the origin and through the middle of the mesh, then
        those that the mesh is found to be symmetric in."""
        for axis in np.eye(3):
            yield axis, 0.0
            middle = float(axis @ self._middle)
            if abs(middle) > 1e-9 * self._diagonal:
                yield axis, middle
        if self._found is None:
            self._found = self._find_planes()
        yield from self._found

    def _find_planes(self) -> list[Plane]:
        """Find planes in which most vertices have a mirror image.

        From the main axes of the vertices, each drawn to the plane half-way between vertices and
        the nearest to their images until it rests.
        """
        step = max(len(self._points) // SAMPLES, 1)
        points = self._points[::step]
        centre = points.mean(axis=0)
        found: list[Plane] = []
        for normal in np.linalg.svd(points - centre, full_matrices=False)[2]:
            offset = float(normal @ centre)
            reach = 0.1 * self._diagonal
            for _ in range(ROUNDS):
                image = _reflect(points, normal, offset)
                distance, at = self._tree.query(image)
                paired = distance < reach
                across = (self._points[at] - points)[paired]
                if len(across) < 3:
                    break
                normal = np.linalg.svd(across, full_matrices=False)[2][0]
                middle = (self._points[at] + points)[paired] / 2
                offset = float(np.median(middle @ normal))
                reach = max(reach / 2, 2 * AT_IMAGE * self._diagonal)
            image = _reflect(points, normal, offset)
            near = self._tree.query(image)[0] < AT_IMAGE * self._diagonal
            if near.mean() >= MOSTLY:
                found.append((normal, offset))
        return found

    def _find_beyond(
        self, hole: Hole, normal: NDArray[np.float64], offset: float
    ) -> tuple[Int32Array, NDArray[np.float64]] | None:
        points = hole.points
        image = _reflect(points, normal, offset)
        distance, at = self._tree.query(image)
        if distance.max() > AT_IMAGE * self._diagonal:
            return None
        twin = self._used[at]
        n = len(twin)
        if len(set(twin.tolist())) < n or (twin == hole.loop).all():
            return None
        t = self._topology
        # Mirrored, the loop runs the other way: quads within lie along twin[i + 1] -> twin[i].
        rim: list[int] = []
        for i in range(n):
            h = self._edge.get((int(twin[(i + 1) % n]), int(twin[i])))
            if h is None:
                return None
            rim.append(h)
        removed = set(hole.removed.tolist())
        on_rim = set(rim)
        faces = {int(t.face[h]) for h in rim}
        stack = list(faces)
        while stack:
            f = stack.pop()
            if f in removed or len(faces) > MOST_FACES or t.start[f + 1] - t.start[f] != 4:
                return None
            for h in range(int(t.start[f]), int(t.start[f + 1])):
                g = int(t.twin[h])
                if h in on_rim:
                    continue
                if g < 0:
                    return None
                other = int(t.face[g])
                if other not in faces:
                    faces.add(other)
                    stack.append(other)
        number = {int(v): i for i, v in enumerate(twin)}
        quads, inner = self._number_quads(faces, number, n)
        return quads, _reflect(t.mesh.points[inner].reshape(-1, 3), normal, offset)

    def match(self, hole: Hole, other: Hole) -> MirroredHole | None:
        """How a hole is the mirror image of another hole of this mesh.

        None where it is not in any plane of the mesh, within an edge, and where both are the same.
        """
        n = len(hole)
        if len(other) != n or (np.sort(hole.loop) == np.sort(other.loop)).all():
            return None
        reach = NEAR_PAIR * max(hole.length, other.length) / n
        place = np.arange(n)
        best: tuple[float, MirroredHole] | None = None
        for normal, offset in self._planes():
            image = _reflect(other.points, normal, offset)
            for first in range(n):
                # Mirrored, the loop runs the other way.
                at = (first - place) % n
                off = float(np.linalg.norm(image[at] - hole.points, axis=1).max())
                if off <= reach and (best is None or off < best[0]):
                    exact = off <= AT_IMAGE * self._diagonal
                    best = off, MirroredHole(at, (normal, offset), exact)
        return None if best is None else best[1]

    def find_part(self, hole: Hole) -> tuple[Int32Array, NDArray[np.float64]] | None:
        """The quads of a hole across the symmetry plane whose mirror images are not in the hole.

        Returned as by :meth:`find`; they leave a part of the hole, its own mirror image, to be
        filled. None where there are none, and where the mesh is not symmetric in most.
        """
        if len(set(hole.loop.tolist())) < len(hole):
            return None
        if self._true is None:
            self._true = [plane for plane in self._planes() if self._holds(*plane)]
        parts = [self._find_part(hole, *plane) for plane in self._true]
        return max((part for part in parts if part), key=lambda part: len(part[0]), default=None)

    def _holds(self, normal: NDArray[np.float64], offset: float) -> bool:
        points = self._points[:: max(len(self._points) // SAMPLES, 1)]
        near = self._tree.query(_reflect(points, normal, offset))[0] < AT_IMAGE * self._diagonal
        return bool(near.mean() >= MOSTLY)

    def _find_part(
        self, hole: Hole, normal: NDArray[np.float64], offset: float
    ) -> tuple[Int32Array, NDArray[np.float64]] | None:
        t = self._topology
        n = len(hole)
        near = AT_IMAGE * self._diagonal
        distance, at = self._tree.query(_reflect(hole.points, normal, offset))
        partner = np.where(distance <= near, self._used[at], -1)
        number = {v: i for i, v in enumerate(partner.tolist()) if v >= 0}
        rim: set[int] = set()
        for i in range(n):
            h = self._edge.get((int(partner[(i + 1) % n]), int(partner[i])))
            if h is not None:
                rim.add(h)
        removed = set(hole.removed.tolist())

        def serves(f: int) -> bool:
            return f not in removed and t.start[f + 1] - t.start[f] == 4

        faces = {f for h in rim if serves(f := int(t.face[h]))}
        stack = list(faces)
        while stack:
            f = stack.pop()
            if len(faces) > MOST_FACES:
                return None
            for h in range(int(t.start[f]), int(t.start[f + 1])):
                g = int(t.twin[h])
                other = int(t.face[g])
                if h in rim or g < 0 or other in faces or not serves(other):
                    continue
                faces.add(other)
                stack.append(other)
        if not faces:
            return None
        quads, inner = self._number_quads(faces, number, n)
        points = _reflect(t.mesh.points[inner].reshape(-1, 3), normal, offset)
        # Where a vertex is already, the images have run out of the hole.
        gone = np.zeros(t.mesh.n_faces, np.bool_)
        gone[hole.removed] = True
        stays = np.zeros(len(t.mesh.points), np.bool_)
        stays[t.tail[~gone[t.face]]] = True
        if len(points):
            distance, at = self._tree.query(points)
            if (stays[self._used[at]] & (distance <= near)).any():
                return None
        return quads, points

    def _number_quads(
        self, faces: set[int], number: dict[int, int], n: int
    ) -> tuple[Int32Array, list[int]]:
        """The mirror images of faces, their vertices by the numbers given and then from n on, and
        the vertices that have these."""
        t = self._topology
        number = dict(number)
        inner: list[int] = []
        quads: list[list[int]] = []
        for f in sorted(faces):
            h = int(t.start[f])
            quad: list[int] = []
            for _ in range(4):
                v = int(t.tail[h])
                if v not in number:
                    number[v] = n + len(inner)
                    inner.append(v)
                quad.append(number[v])
                h = int(t.next[h])
            quads.append(quad[::-1])
        return np.array(quads, np.int32), inner


def _reflect(
    points: NDArray[np.float64], normal: NDArray[np.float64], offset: float
) -> NDArray[np.float64]:
    return points - 2 * (points @ normal - offset)[:, None] * normal


def find_rest(quads: Int32Array, n: int) -> list[int] | None:
    """The one loop that quads leave of a loop 0..n-1 which they lie within; None where they leave
    none or several, or touch."""
    ahead = {
        (int(a), int(b)) for quad in quads for a, b in zip(quad, np.roll(quad, -1), strict=True)
    }
    around = {(i, (i + 1) % n) for i in range(n)}
    if len(ahead) < 4 * len(quads):
        return None
    inner = {(b, a) for a, b in ahead if (b, a) not in ahead and (a, b) not in around}
    following: dict[int, int] = {}
    for a, b in (around - ahead) | inner:
        if a in following:
            return None
        following[a] = b
    if not following:
        return None
    loop = [min(following)]
    while (v := following.get(loop[-1], -1)) != loop[0]:
        if v < 0 or len(loop) > len(following):
            return None
        loop.append(v)
    return loop if len(loop) == len(following) else None
