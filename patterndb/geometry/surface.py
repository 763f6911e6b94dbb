"""A triangulated surface that fills are placed on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points, units
from patterndb.geometry.trianglemesh import TriangleMesh
from patterndb.geometry.triangulation import cut_faces

#: A hit along the normal this many times as far as the nearest point is a graze: the line runs
#: along the surface, and the nearest point is what is meant.
GRAZE = 4.0


class Triangles(Protocol):
    """What is taken of a surface: a ``trimesh.Trimesh`` is one."""

    @property
    def vertices(self) -> ArrayLike: ...
    @property
    def faces(self) -> ArrayLike: ...


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Points on a surface.

    points: (n, 3) float64. normals: (n, 3) float64 unit normals of the surface there,
    interpolated. triangles: (n,) int32.
    """

    points: Points
    normals: Points
    triangles: Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles, ready to be asked for nearest points; make it once and place many fills.

    mesh:     its triangles, counter-clockwise seen from outside.
    normals:  (v, 3) float64 unit normals, means of the triangles' by their areas.
    areas:    (t,) float64, of the triangles.
    beside:   (e, 2) int32, the triangles on both sides of every inner edge.
    diagonal: length of the diagonal of its box.
    """

    mesh: TriangleMesh
    normals: Points
    areas: NDArray[np.float64]
    beside: Int32Array
    diagonal: float

    @classmethod
    def of(cls, mesh: Triangles | Surface) -> Surface:
        """From anything with ``vertices`` (v, 3) and ``faces`` (t, 3), as trimesh.Trimesh.

        Triangles without area are left out. Raises InvalidMeshError for arrays of another
        shape, indices out of range, coordinates that are not finite, and if nothing is left.
        """
        if isinstance(mesh, Surface):
            return mesh
        return cls.from_arrays(mesh.vertices, mesh.faces)

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, triangles: ArrayLike) -> Surface:
        """From (v, 3) vertices and (t, 3) triangles; see :meth:`of`."""
        points = np.ascontiguousarray(vertices, np.float64)
        faces = np.asarray(triangles)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InvalidMeshError(f"the surface's vertices must be (v, 3), got {points.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise InvalidMeshError(
                f"the surface's faces must be triangles (t, 3), got {faces.shape}; triangulate them"
            )
        if faces.size and not (faces.min() >= 0 and faces.max() < len(points)):
            raise InvalidMeshError(
                f"a triangle of the surface names a vertex outside 0..{len(points) - 1}"
            )
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            raise InvalidMeshError(f"vertex {bad[0]} of the surface is not finite")
        faces = np.ascontiguousarray(faces, np.int32)
        corners = points[faces]
        area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(area, axis=1)
        sound = size > 0.0
        if not sound.any():
            raise InvalidMeshError("the surface has no triangle with an area")
        faces = faces[sound]
        normals = np.zeros_like(points)
        for e in range(3):
            np.add.at(normals, faces[:, e], area[sound])
        sizes = size[sound] / 2.0
        beside = _beside(faces)
        mesh = TriangleMesh(points, faces)
        return cls(mesh, units(normals), sizes, beside, mesh.diagonal)

    @classmethod
    def from_polygons(cls, mesh: PolygonMesh) -> Surface:
        """From a mesh of polygons, cut into triangles that cover each once; see :meth:`of`."""
        return cls.from_arrays(mesh.points, cut_faces(mesh)[0])

    def part(self, chosen: NDArray[np.bool_]) -> Surface:
        """Some of its triangles, (t,) bool; vertices and their normals as they are."""
        name = np.cumsum(chosen, dtype=np.int32) - 1
        beside = name[self.beside[chosen[self.beside].all(axis=1)]]
        mesh = TriangleMesh(self.vertices, self.triangles[chosen])
        return Surface(mesh, self.normals, self.areas[chosen], beside, mesh.diagonal)

    @property
    def vertices(self) -> Points:
        """(v, 3) float64."""
        return self.mesh.points

    @property
    def triangles(self) -> Int32Array:
        """(t, 3) int32."""
        return self.mesh.triangles

    def nearest(self, points: Points) -> Feet:
        """The points of the surface nearest to (n, 3) points."""
        return self.at(*self.located(points))

    def located(self, points: Points) -> tuple[Int32Array, Points]:
        """(n,) the triangles nearest to (n, 3) points, and (n, 3) barycentric weights there."""
        return self.mesh.find_nearest(points)

    def along(self, points: Points, normals: Points) -> Feet:
        """Where lines through (n, 3) points along (n, 3) unit normals first meet the surface.

        Both ways along the line count, and only triangles that face as the normal does.
        Where the line meets none, or only grazes the surface far off, the nearest point.
        """
        points = np.ascontiguousarray(points)
        triangle, weights = self.located(points)
        close = self.at(triangle, weights)
        reach = GRAZE * np.linalg.norm(close.points - points, axis=1) + 1e-9 * self.diagonal
        hit, at = self.mesh.cast_along(points, normals, reach)
        met = hit >= 0
        triangle[met], weights[met] = hit[met], at[met]
        return self.at(triangle, weights)

    def at(self, triangle: Int32Array, weights: Points) -> Feet:
        """The points with these barycentric weights (n, 3) on these triangles (n,)."""
        corner = self.triangles[triangle]
        points = np.einsum("ne,nec->nc", weights, self.vertices[corner])
        normals = units(np.einsum("ne,nec->nc", weights, self.normals[corner]))
        return Feet(points, normals, triangle)


def edge_keys(triangles: Int32Array) -> NDArray[np.int64]:
    """(3t,) a number per half-edge 3 f + e, the same for both of an edge."""
    tail = triangles.astype(np.int64)
    head = np.roll(tail, -1, axis=1)
    return ((np.minimum(tail, head) << 32) | np.maximum(tail, head)).ravel()


def _beside(triangles: Int32Array) -> Int32Array:
    """(e, 2) pairs of triangles that share an edge; where more than two do, each and the next."""
    key = edge_keys(triangles)
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order][1:] == key[order][:-1])
    return (np.stack([order[same], order[same + 1]], axis=1) // 3).astype(np.int32)
