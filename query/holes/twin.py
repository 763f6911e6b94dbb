"""The mirror twin of a hole: where a mesh is symmetric, the other side shows what belongs there."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.holes.loops import Hole, MeshTopology

#: A vertex is the mirror image of another if it is this near, as a part of the mesh's diagonal.
NEAR = 2e-3

#: A twin of more faces than this is no hole's.
MOST_FACES = 5_000


#: Planes are found by so many vertices, in so many rounds; so large a part must have an image.
SAMPLES, ROUNDS, MOSTLY = 3_000, 12, 0.5

#: A unit normal (3,) and the distance of a plane from the origin along it.
Plane = tuple[NDArray[np.float64], float]


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
                image = points - 2 * (points @ normal - offset)[:, None] * normal
                distance, at = self._tree.query(image)
                paired = distance < reach
                across = (self._points[at] - points)[paired]
                if len(across) < 3:
                    break
                normal = np.linalg.svd(across, full_matrices=False)[2][0]
                middle = (self._points[at] + points)[paired] / 2
                offset = float(np.median(middle @ normal))
                reach = max(reach / 2, 2 * NEAR * self._diagonal)
            image = points - 2 * (points @ normal - offset)[:, None] * normal
            near = self._tree.query(image)[0] < NEAR * self._diagonal
            if near.mean() >= MOSTLY:
                found.append((normal, offset))
        return found

    def _find_beyond(
        self, hole: Hole, normal: NDArray[np.float64], offset: float
    ) -> tuple[Int32Array, NDArray[np.float64]] | None:
        points = hole.points
        image = points - 2 * (points @ normal - offset)[:, None] * normal
        distance, at = self._tree.query(image)
        if distance.max() > NEAR * self._diagonal:
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
        where = t.mesh.points[inner].reshape(-1, 3)
        mirrored = where - 2 * (where @ normal - offset)[:, None] * normal
        return np.array(quads, np.int32), mirrored
