"""The surface: the surface of triangles that curves and quads lie on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import GRAZE, Surface, Triangles
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.ground.orientation import orient_triangles
from patterndb_sketch.retopo.ground.topology import GroundTopology
from patterndb_sketch.retopo.sizes import EDGE, Sizes
from patterndb_sketch.retopo.wording import format_place


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePoints:
    """Points on the surface.

    points: (n, 3) float64. normals: (n, 3) float64 unit normals, interpolated between the
    vertices'. triangles: (n,) int32. weights: (n, 3) float64 barycentric, of the triangle's
    corners; none below 0, sum 1.
    """

    points: Points
    normals: Points
    triangles: Int32Array
    weights: Points

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, which: slice | NDArray[np.integer] | NDArray[np.bool_]) -> SurfacePoints:
        """Some of them, by a slice or an index array; for one take ``feet[i : i + 1]``."""
        return SurfacePoints(
            self.points[which], self.normals[which], self.triangles[which], self.weights[which]
        )


@dataclass(frozen=True, slots=True, eq=False)
class ProjectedPoints:
    """Points taken to the surface along their normals.

    feet:   where they are now, all of them on the surface.
    missed: (k,) int32 numbers of those whose line met no triangle that faces as the normal
            does, or only too far off: they are at the nearest point that does face so.
    lost:   (l,) int32 numbers of those, not among ``missed``, for which no triangle of the
            whole surface faces as the normal does: they are at the nearest point of all.
    """

    feet: SurfacePoints
    missed: Int32Array
    lost: Int32Array

    @property
    def points(self) -> Points:
        """(n, 3) float64."""
        return self.feet.points

    @property
    def normals(self) -> Points:
        """(n, 3) float64 unit normals of the surface."""
        return self.feet.normals


#: A line along the normal that meets the surface further off than this many target edges has
#: met another part of it.
TOO_FAR = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """A surface of triangles, ready to be drawn on; made once, shared by all tools.

    surface:  the triangles, with vertex normals and a tree of boxes.
    topology: what lies beside what.
    diagonal: length of the diagonal of its box.
    vertex:   (v,) int32, the surface's number of every vertex given: vertices at one place are
              one, as files that keep a vertex per texture or normal mean it.
    dropped:  how many triangles had no area, and were left out.
    turned:   how many were turned over, so that all are turned alike; see :mod:`.orientation`.
    """

    surface: Surface
    topology: GroundTopology
    diagonal: float
    vertex: Int32Array
    dropped: int
    turned: int = 0

    @classmethod
    def of(cls, vertices: ArrayLike, triangles: ArrayLike) -> Ground:
        """From (v, 3) vertices and (t, 3) triangles, counter-clockwise seen from outside.

        Any number of parts, with or without borders; an edge may have any number of triangles.
        Triangles that are turned against their neighbours are turned over. Raises
        InvalidMeshError for arrays of another shape, indices out of range, coordinates that are
        not finite, if no triangle has an area, and for a surface with one side only.
        """
        # Everything is checked before vertices are taken together.
        given = Surface.from_arrays(vertices, triangles)
        places, vertex = np.unique(given.vertices, axis=0, return_inverse=True)
        # The order of the vertices given is kept, for what is near in it is near in memory.
        first = np.full(len(places), len(vertex))
        vertex = vertex.reshape(-1)
        np.minimum.at(first, vertex, np.arange(len(vertex)))
        rank = np.empty(len(places), np.int32)
        rank[np.argsort(first)] = np.arange(len(places), dtype=np.int32)
        vertex = rank[vertex]
        surface = given
        if len(places) < len(vertex):
            points = np.empty_like(places)
            points[vertex] = given.vertices
            surface = Surface.from_arrays(points, vertex[given.triangles])
        found = orient_triangles(surface.vertices, surface.triangles)
        if len(found.onesided):
            sides = found.triangles.ravel()[found.onesided]
            raise InvalidMeshError(
                f"the surface is one-sided, as a Moebius strip: its triangles cannot be turned "
                f"alike at {format_place(surface.vertices[sides[0]])}; cut it along edges there"
            )
        if len(found.turned):
            surface = Surface.from_arrays(surface.vertices, found.triangles)
        return cls(
            surface,
            GroundTopology.of(surface.vertices, surface.triangles),
            surface.diagonal,
            vertex.astype(np.int32),
            len(np.asarray(triangles)) - len(surface.triangles),
            len(found.turned),
        )

    @classmethod
    def of_mesh(cls, mesh: Triangles) -> Ground:
        """From anything with ``vertices`` and ``faces``, as trimesh.Trimesh; see :meth:`of`."""
        return cls.of(mesh.vertices, mesh.faces)

    @classmethod
    def of_polygons(cls, mesh: PolygonMesh) -> Ground:
        """From a mesh of polygons, cut into triangles that cover each once; see :meth:`of`."""
        surface = Surface.from_polygons(mesh)
        return cls.of(surface.vertices, surface.triangles)

    def is_same(self, other: Ground) -> bool:
        """Has another surface the same vertices and triangles?"""
        return np.array_equal(self.vertices, other.vertices) and np.array_equal(
            self.triangles, other.triangles
        )

    @property
    def vertices(self) -> Points:
        """(v, 3) float64."""
        return self.surface.vertices

    @property
    def triangles(self) -> Int32Array:
        """(t, 3) int32."""
        return self.surface.triangles

    @property
    def normals(self) -> Points:
        """(v, 3) float64 unit normals of the vertices."""
        return self.surface.normals

    def at(self, triangles: Int32Array, weights: Points) -> SurfacePoints:
        """The points with these barycentric weights (n, 3) on these triangles (n,)."""
        triangles = np.asarray(triangles, np.int32)
        corner = self.surface.triangles[triangles]
        points = np.einsum("ne,nec->nc", weights, self.surface.vertices[corner])
        normals = units(np.einsum("ne,nec->nc", weights, self.surface.normals[corner]))
        return SurfacePoints(points, normals, triangles, np.ascontiguousarray(weights))

    def nearest(self, points: ArrayLike) -> SurfacePoints:
        """The points of the surface nearest to (n, 3) points."""
        at = _three(points, "points")
        return self.at(*self.surface.located(at))

    def nearest_facing(self, points: ArrayLike, normals: ArrayLike) -> ProjectedPoints:
        """The nearest points on triangles that face as (n, 3) normals do.

        Where no triangle of the surface does, the nearest point of all (``lost``).
        """
        at, up = _three(points, "points"), _three(normals, "normals")
        triangle, weights = self.surface.mesh.find_nearest_facing(at, up)
        lost = np.flatnonzero(triangle < 0).astype(np.int32)
        if len(lost):
            triangle[lost], weights[lost] = self.surface.located(at[lost])
        return ProjectedPoints(self.at(triangle, weights), np.empty(0, np.int32), lost)

    def project_near(self, points: ArrayLike, normals: ArrayLike, sizes: Sizes) -> ProjectedPoints:
        """Points (n, 3) that lie nearly on the surface, as those of a curve that was smoothed or
        cut short between places on it, taken along their normals; see :meth:`project`.

        A hit much further off than the nearest point that faces so is on another part: in a
        crease the line may pass the near side, and meet what is far beyond. Such a point counts
        as missed.
        """
        at, up = _three(points, "points"), _three(normals, "normals")
        close = self.nearest_facing(at, up).feet.points
        off = np.linalg.norm(close - at, axis=1)
        return self.project(at, up, np.minimum(GRAZE * off + sizes.sampling, TOO_FAR * sizes.edge))

    def project(
        self, points: ArrayLike, normals: ArrayLike, reach: ArrayLike | None = None
    ) -> ProjectedPoints:
        """Points (n, 3) taken along their normals (n, 3), both ways, to the nearest hit.

        Triangles that face away from the normal are not seen. reach: how far a hit may be, one
        length or (n,); by default TOO_FAR times the default target edge. Where there is none
        within, the nearest point whose triangle faces as the normal does, and it is reported.

        Source: the released program of Takayama et al. 2013. Differs from it: points without a
        hit do not stay off the surface; lines begin at the points, not a little to either
        side, for a hit at the point itself counts here.
        """
        at, up = _three(points, "points"), units(_three(normals, "normals"))
        if len(at) != len(up):
            raise InvalidRetopoError(f"{len(at)} points have {len(up)} normals; give one for each")
        far = TOO_FAR * EDGE * self.diagonal if reach is None else np.asarray(reach, np.float64)
        triangle, weights = self.surface.mesh.cast_along(at, up, np.full(len(at), far))
        missed = np.flatnonzero(triangle < 0).astype(np.int32)
        lost = missed[:0]
        if len(missed):
            other = self.nearest_facing(at[missed], up[missed])
            triangle[missed], weights[missed] = other.feet.triangles, other.feet.weights
            lost = missed[other.lost]
            missed = np.setdiff1d(missed, lost)
        return ProjectedPoints(self.at(triangle, weights), missed, lost)


def _three(points: ArrayLike, name: str) -> Points:
    array = np.ascontiguousarray(points, np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidRetopoError(f"{name} must be (n, 3), got {array.shape}")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise InvalidRetopoError(f"row {bad[0]} of {name} is not finite")
    return array
