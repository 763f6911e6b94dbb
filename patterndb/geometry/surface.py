"""The surface of triangles that quads and curves lie on, and places on it."""

# scipy has no types: what it returns is typed by the functions' own annotations.
# pyright: reportMissingTypeStubs=false, reportUnknownVariableType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb._native.geometry.casting import all_hits, first_along, first_hits
from patterndb._native.geometry.proximity import nearest, nearest_facing
from patterndb._native.geometry.tree import build
from patterndb.core.halfedge import Int32Array, Int64Array, sort_by_edge
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.adjacency import Adjacency, list_sides, orient_triangles
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.triangulation import (
    WELD,
    cut_faces,
    sort_triangles,
    triangulate_faces,
    weld,
)
from patterndb.verbs import PlotVerbs

#: A hit along the normal this many times as far as the nearest point is a graze: the line runs
#: along the surface, and the nearest point is meant.
GRAZE = 4.0

#: Points drawn within less than this part of the diagonal are at one place.
ONE_PLACE = 1e-6

#: Kinds of fallback of projected points; see :class:`SurfacePoints`.
MISSED, LOST = 1, 2


class Triangles(Protocol):
    """A mesh of triangles, as ``trimesh.Trimesh`` is one."""

    @property
    def vertices(self) -> ArrayLike: ...
    @property
    def faces(self) -> ArrayLike: ...


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Places on a surface, one for each point or line that was asked about.

    surface:   that they are on.
    triangles: (n,) int32, -1 without a place, as for a ray that hits nothing.
    weights:   (n, 3) float64 barycentric, of the triangle's corners; none below 0, sum 1.
    points:    (n, 3) float64, nan without a place.
    distances: (n,) float64, how far along rays or lines their hits are, inf without a hit; (0,) for
               places that were found otherwise.
    fallback:  (n,) int8, of projected points: 0 for a hit, MISSED or LOST, see ``missed`` and
               ``lost``; (0,) for places that were found otherwise.
    """

    surface: Surface
    triangles: Int32Array
    weights: Points
    points: Points
    distances: Floats = field(default_factory=lambda: np.empty(0))
    fallback: NDArray[np.int8] = field(default_factory=lambda: np.empty(0, np.int8))

    def __len__(self) -> int:
        return len(self.triangles)

    def __getitem__(self, which: slice | NDArray[np.integer] | NDArray[np.bool_]) -> SurfacePoints:
        """Return some of them, by a slice or an index array; for one take ``feet[i : i + 1]``."""
        return SurfacePoints(
            self.surface,
            self.triangles[which],
            self.weights[which],
            self.points[which],
            self.distances[which] if len(self.distances) else self.distances,
            self.fallback[which] if len(self.fallback) else self.fallback,
        )

    @cached_property
    def normals(self) -> Points:
        """(n, 3) float64 unit normals, interpolated between the vertices'; nan without a place."""
        values = self.surface.normals
        result = units(self.surface.interpolate(values, self.triangles, self.weights))
        result[~self.found] = np.nan
        return result

    @property
    def found(self) -> NDArray[np.bool_]:
        """(n,) bool, is there a place?"""
        return self.triangles >= 0

    def list_runs(self) -> list[NDArray[np.intp]]:
        """List the numbers (k,) of neighbouring places with no gap between them, run by run: a
        stroke that is drawn by rays breaks where these hit nothing."""
        met = np.flatnonzero(self.found)
        return np.split(met, 1 + np.flatnonzero(np.diff(met) > 1)) if len(met) else []

    @property
    def missed(self) -> Int32Array:
        """(k,) int32 numbers of projected points whose line met no triangle that faces as the
        normal does, or only too far off: they are at the nearest point that does face so."""
        return np.flatnonzero(self.fallback == MISSED).astype(np.int32)

    @property
    def lost(self) -> Int32Array:
        """(l,) int32 numbers of points for which no triangle of the surface faces as the normal
        does: they are at the nearest point of all."""
        return np.flatnonzero(self.fallback == LOST).astype(np.int32)


@dataclass(frozen=True, slots=True)
class Repairs:
    """The changes that a constructor made to the triangles it was given.

    vertex:   (n,) int32, the surface's number of every vertex given; None where vertices kept
              their numbers, or were sorted.
    dropped:  triangles left out because they have no area, or because corners fell together.
    turned:   triangles turned over.
    repeated: triangles left out because they repeat another.
    """

    vertex: Int32Array | None = None
    dropped: int = 0
    turned: int = 0
    repeated: int = 0


@dataclass(frozen=True, eq=False)
class Surface(PlotVerbs):
    """Triangles that are asked for nearest points and hits of lines; make it once, ask it often.

    vertices:  (v, 3) float64.
    triangles: (t, 3) int32, counter-clockwise seen from outside where the surface has an outside.
    repairs:   the changes that a constructor made.

    The constructor itself checks nothing: triangles may be without area, and in any order and
    sense. :meth:`from_arrays` checks, :meth:`orient` welds and turns, :meth:`from_soup` welds and
    sorts. Everything else is computed when it is first needed.
    """

    vertices: Points
    triangles: Int32Array
    repairs: Repairs = field(default_factory=Repairs)

    @classmethod
    def of(cls, mesh: Triangles | Surface) -> Surface:
        """Take anything with ``vertices`` (v, 3) and ``faces`` (t, 3), as trimesh.Trimesh; see
        :meth:`from_arrays`."""
        if isinstance(mesh, Surface):
            return mesh
        return cls.from_arrays(mesh.vertices, mesh.faces)

    @classmethod
    def from_corners(cls, corners: Points) -> Surface:
        """Take triangles (t, 3, 3) that share no vertices, unchecked."""
        return cls(
            corners.reshape(-1, 3), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
        )

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, triangles: ArrayLike) -> Surface:
        """Take (v, 3) vertices and (t, 3) triangles, without those that have no area.

        Raises InvalidMeshError for arrays of another shape, indices out of range, coordinates that
        are not finite, and if no triangle has an area.
        """
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
        sound = np.linalg.norm(_double_areas(points, faces), axis=1) > 0.0
        if not sound.any():
            raise InvalidMeshError("the surface has no triangle with an area")
        return cls(points, faces[sound], Repairs(dropped=int((~sound).sum())))

    @classmethod
    def from_polygons(cls, mesh: PolygonMesh) -> Surface:
        """Take a mesh of polygons, cut into triangles that cover each once; see
        :meth:`from_arrays`."""
        return cls.from_arrays(mesh.points, cut_faces(mesh)[0])

    @classmethod
    def from_soup(cls, mesh: PolygonMesh) -> Surface:
        """Take faces of any quality: weld their vertices, and sort vertices and triangles.

        Every place is one vertex, in lexicographic order; triangles ascend, each within itself and
        all of them, so that their sense means nothing. Triangles that repeat another are left out:
        CAD models have sheets twice, once for each side. Needles without area stay: they hold
        components together. The same triangles in another order, sense or soup give the same
        arrays, bit for bit.

        Raises InvalidMeshError for vertices that are not finite, and if there is no triangle.
        """
        used = np.unique(mesh.corners)
        if not len(used):
            raise InvalidMeshError("the mesh has no faces; give one with faces")
        bad = np.flatnonzero(~np.isfinite(mesh.points[used]).all(axis=1))
        if len(bad):
            raise InvalidMeshError(f"vertex {used[bad[0]]} of the mesh is not finite; mend it")
        chosen = np.asarray(mesh.points[used], np.float64)
        points, place = weld(chosen, WELD * float(np.linalg.norm(np.ptp(chosen, axis=0))))
        name = np.zeros(len(mesh.points), np.int64)
        name[used] = place
        pieces, dropped = triangulate_faces(points, name[mesh.corners], mesh.offsets)
        triangles, repeated = sort_triangles(pieces)
        if not len(triangles):
            raise InvalidMeshError("the mesh has no triangle with three corners")
        # Vertices that only dropped triangles have are left out.
        kept, triangles = np.unique(triangles, return_inverse=True)
        return cls(
            np.ascontiguousarray(points[kept]),
            np.ascontiguousarray(triangles.reshape(-1, 3), np.int32),
            Repairs(dropped=dropped, repeated=repeated),
        )

    def orient(self) -> Surface:
        """Weld vertices at the same place, and turn triangles that are against their neighbours.

        Files keep a vertex for each texture coordinate or normal; welded, vertices keep their
        order. Triangles may form any number of components, with or without borders; an edge may
        have any number of triangles. Raises InvalidMeshError for a surface with one side only.
        """
        places, vertex = np.unique(self.vertices, axis=0, return_inverse=True)
        # The order of the vertices given is kept, for what is near in it is near in memory.
        first = np.full(len(places), len(vertex))
        vertex = vertex.reshape(-1)
        np.minimum.at(first, vertex, np.arange(len(vertex)))
        rank = np.empty(len(places), np.int32)
        rank[np.argsort(first)] = np.arange(len(places), dtype=np.int32)
        vertex = rank[vertex]
        points, triangles = self.vertices, self.triangles
        if len(places) < len(vertex):
            points = np.empty_like(places)
            points[vertex] = self.vertices
            triangles = np.ascontiguousarray(vertex[triangles], np.int32)
        found = orient_triangles(points, triangles)
        if len(found.onesided):
            x, y, z = points[found.triangles.ravel()[found.onesided[0]]] + 0.0
            raise InvalidMeshError(
                "the surface is one-sided, as a Moebius strip: its triangles cannot be turned "
                f"alike at ({x:.4g}, {y:.4g}, {z:.4g}); cut it along edges there"
            )
        repairs = Repairs(vertex.astype(np.int32), self.repairs.dropped, len(found.turned))
        return Surface(points, found.triangles, repairs)

    def part(self, chosen: NDArray[np.bool_]) -> Surface:
        """Return some of its triangles, (t,) bool; vertices and their normals as they are."""
        part = Surface(self.vertices, self.triangles[chosen])
        name = np.cumsum(chosen, dtype=np.int32) - 1
        pairs = name[self.pairs[chosen[self.pairs].all(axis=1)]]
        vars(part).update(normals=self.normals, pairs=pairs)
        return part

    def inherit(self, normals: Points, diagonal: float | None = None) -> Surface:
        """Return the same triangles with the unit normals (v, 3), and the diagonal, that the
        vertices have in the surface of which they are a part."""
        part = Surface(self.vertices, self.triangles, self.repairs)
        vars(part).update(vars(self), normals=normals, diagonal=diagonal or self.diagonal)
        return part

    def is_same(self, other: Surface) -> bool:
        """Return whether another surface has the same vertices and triangles."""
        return np.array_equal(self.vertices, other.vertices) and np.array_equal(
            self.triangles, other.triangles
        )

    @cached_property
    def corners(self) -> Points:
        """(t, 3, 3) float64, the triangles' points."""
        return np.ascontiguousarray(self.vertices[self.triangles])

    @cached_property
    def areas(self) -> Floats:
        """(t,) float64, of the triangles."""
        return np.linalg.norm(_double_areas(self.vertices, self.triangles), axis=1) / 2.0

    @cached_property
    def normals(self) -> Points:
        """(v, 3) float64 unit normals, means of the triangles' by their areas."""
        doubled = _double_areas(self.vertices, self.triangles)
        total = np.zeros_like(self.vertices)
        for e in range(3):
            np.add.at(total, self.triangles[:, e], doubled)
        return units(total)

    @cached_property
    def diagonal(self) -> float:
        """Length of the diagonal of the triangles' box."""
        return float(np.linalg.norm(np.ptp(self.corners.reshape(-1, 3), axis=0)))

    @cached_property
    def pairs(self) -> Int32Array:
        """(e, 2) int32 pairs of triangles that share an edge; where more than two do, each and the
        next."""
        order, start = sort_by_edge(*list_sides(self.triangles))
        has_next = np.ones(len(order), np.bool_)
        has_next[start[1:] - 1] = False
        same = np.flatnonzero(has_next)
        return (np.stack([order[same], order[same + 1]], axis=1) // 3).astype(np.int32)

    @cached_property
    def border_sides(self) -> Int32Array:
        """(b,) int32, the sides 3 f + e of triangles that no other triangle has, by their edges."""
        order, start = sort_by_edge(*list_sides(self.triangles))
        return order[start[:-1][np.diff(start) == 1]].astype(np.int32)

    @cached_property
    def adjacency(self) -> Adjacency:
        """Its edges, and what is on the other side of them."""
        return Adjacency.of(self.vertices, self.triangles)

    @cached_property
    def components(self) -> Int32Array:
        """(t,) int32, the component of each triangle: parts that share no vertex, numbered from 0
        by their first triangles."""
        n = len(self.vertices)
        tail, head = self.triangles[:, [0, 1]].ravel(), self.triangles[:, [1, 2]].ravel()
        graph = coo_array((np.ones(len(tail), np.int8), (tail, head)), (n, n))
        label = connected_components(graph, directed=False)[1][self.triangles[:, 0]]
        _, first, name = np.unique(label, return_index=True, return_inverse=True)
        rank = np.empty(len(first), np.int32)
        rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
        return rank[name]

    @property
    def n_components(self) -> int:
        return int(self.components.max()) + 1

    @cached_property
    def boxes(self) -> tuple[Points, Int32Array, Int32Array]:
        """The tree of boxes: boxes, nodes and order, see :mod:`patterndb._native.geometry.tree`."""
        return build(self.corners)

    @property
    def tree(self) -> tuple[Points, Points, Int32Array, Int32Array]:
        """Arguments of the compiled core: corners, boxes, nodes and order."""
        return self.corners, *self.boxes

    def at(self, triangles: Int32Array, weights: Points) -> SurfacePoints:
        """Return the places with these barycentric weights (n, 3) on these triangles (n,)."""
        triangles = np.asarray(triangles, np.int32)
        points = self.interpolate(self.vertices, triangles, weights)
        return SurfacePoints(self, triangles, np.ascontiguousarray(weights), points)

    def interpolate(self, values: Points, triangles: Int32Array, weights: Points) -> Points:
        """Interpolate values (v, 3) of the vertices at places; nan for the triangle -1."""
        found = triangles >= 0
        if found.all():
            return np.einsum("ne,nec->nc", weights, values[self.triangles[triangles]])
        result = np.full((len(triangles), 3), np.nan)
        corner = self.triangles[triangles[found]]
        result[found] = np.einsum("ne,nec->nc", weights[found], values[corner])
        return result

    def nearest(self, points: ArrayLike) -> SurfacePoints:
        """Return the places nearest to (n, 3) points."""
        return self.at(*nearest(*self.tree, _check(points, "points")))

    def measure_distances(self, points: ArrayLike) -> Floats:
        """Measure (n,) how far (n, 3) points are from the surface."""
        at = _check(points, "points")
        return np.linalg.norm(self.nearest(at).points - at, axis=1)

    def nearest_facing(self, points: ArrayLike, normals: ArrayLike) -> SurfacePoints:
        """Return the nearest places on triangles that face as (n, 3) normals do.

        Where no triangle of the surface does, the nearest place of all (``lost``).
        """
        at, up = _check_lines(points, normals)
        triangles, weights = nearest_facing(*self.tree, at, up)
        fallback = np.where(triangles < 0, np.int8(LOST), np.int8(0))
        lost = np.flatnonzero(triangles < 0)
        if len(lost):
            triangles[lost], weights[lost] = nearest(*self.tree, at[lost])
        return replace(self.at(triangles, weights), fallback=fallback)

    def project(
        self, points: ArrayLike, normals: ArrayLike, reach: float | Floats
    ) -> SurfacePoints:
        """Take points (n, 3) along their normals (n, 3), both ways, to the nearest hit.

        Triangles that face away from the normal are not seen. reach: how far a hit may be, one
        length or (n,). Where there is none within, the nearest place whose triangle faces as the
        normal does (``missed``), or the nearest of all (``lost``).

        Source: the released program of Takayama et al. 2013. Differs from it: points without a hit
        do not stay off the surface; lines begin at the points, not a little to either side, for a
        hit at the point itself counts here.
        """
        at, up = _check_lines(points, normals)
        up = units(up)
        far = np.ascontiguousarray(np.broadcast_to(np.asarray(reach, np.float64), len(at)))
        triangles, weights = first_along(*self.tree, at, up, far)
        fallback = np.where(triangles < 0, np.int8(MISSED), np.int8(0))
        missed = np.flatnonzero(triangles < 0)
        if len(missed):
            other = self.nearest_facing(at[missed], up[missed])
            triangles[missed], weights[missed] = other.triangles, other.weights
            fallback[missed[other.lost]] = LOST
        return replace(self.at(triangles, weights), fallback=fallback)

    def along(self, points: Points, normals: Points) -> SurfacePoints:
        """Find where lines through (n, 3) points along (n, 3) unit normals first meet the surface.

        Both ways along the line count, and only triangles that face as the normal does. Where the
        line meets none, or only grazes the surface far off, the nearest point.
        """
        points = np.ascontiguousarray(points)
        close = self.nearest(points)
        reach = GRAZE * np.linalg.norm(close.points - points, axis=1) + 1e-9 * self.diagonal
        hit = self.cast_along(points, normals, reach)
        met = hit.found
        return self.at(
            np.where(met, hit.triangles, close.triangles),
            np.where(met[:, None], hit.weights, close.weights),
        )

    def cast_along(self, points: Points, normals: Points, reach: Floats) -> SurfacePoints:
        """Return the hits nearest to (n, 3) points of lines along (n, 3) unit normals, both ways.

        reach: (n,) how far they may be. Triangles that face away are not seen.
        """
        starts, directions = np.ascontiguousarray(points), np.ascontiguousarray(normals)
        return self.at(*first_along(*self.tree, starts, directions, reach))

    def cast_rays(self, origins: ArrayLike, directions: ArrayLike) -> SurfacePoints:
        """Return the first hits of rays from (n, 3) origins along (n, 3) directions of any length.

        Both sides of triangles are hit, and no ray slips between two of them; a ray within a
        triangle's plane does not hit it.
        """
        triangles, weights, distances = first_hits(*self.tree, *_check_rays(origins, directions))
        return replace(self.at(triangles, weights), distances=distances)

    def cast_lines(
        self, origins: ArrayLike, directions: ArrayLike
    ) -> tuple[Int64Array, SurfacePoints]:
        """Return all hits of lines through (n, 3) origins along (n, 3) directions, both ways.

        Returns (n + 1,) int64 offsets, and the hits: those of line i are
        ``hits[offsets[i] : offsets[i + 1]]``, ascending in distance, which is negative behind the
        origin. A line through an edge hits every triangle there, each for itself.
        """
        begin, unit = _check_rays(origins, directions)
        line, triangles, weights, distances = all_hits(*self.tree, begin, unit)
        order = np.lexsort((triangles, distances, line))
        hits = self.at(triangles[order], weights[order])
        offsets = np.searchsorted(line, np.arange(len(begin) + 1))
        return offsets, replace(hits, distances=distances[order])

    def explain_distance(
        self, points: Points, what: str, reach: float, most: float = math.inf
    ) -> str | None:
        """Explain why points (n, 3) that are to lie on the surface are in another unit, or
        elsewhere, as a part of a sentence; None if they are near it.

        what: the surface is called. reach: how far off the nearest point may be, and most: the
        farthest, as shares of the diagonal. Nor may the nearest be farther off than the points are
        apart: in metres, what is drawn on a surface in millimetres is in one place.
        """
        off = self.measure_distances(points)
        size = self.diagonal
        extent = float(np.linalg.norm(np.ptp(points, axis=0)))
        mend = f"is it in another unit, or was the {what} turned or moved?"
        if off.min() > min(reach * size, max(extent, ONE_PLACE * size)):
            return (
                f"none of its points is near the {what}: the nearest is {off.min():.4g} off, "
                f"{off.min() / size:.3g} times the diagonal of the {what}; {mend}"
            )
        if off.max() > most * size:
            return (
                f"not all of its points are near the {what}: the farthest is {off.max():.4g} off, "
                f"{off.max() / size:.3g} times the diagonal of the {what}; {mend}"
            )
        return None


def _double_areas(vertices: Points, triangles: Int32Array) -> Points:
    """Return (t, 3) the normals of triangles, twice as long as their areas."""
    corners = vertices[triangles]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _check(points: ArrayLike, name: str) -> Points:
    array = np.ascontiguousarray(points, np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidMeshError(f"{name} must be (n, 3), got {array.shape}")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise InvalidMeshError(f"row {bad[0]} of {name} is not finite")
    return array


def _check_lines(points: ArrayLike, normals: ArrayLike) -> tuple[Points, Points]:
    at, up = _check(points, "points"), _check(normals, "normals")
    if len(at) != len(up):
        raise InvalidMeshError(f"{len(at)} points have {len(up)} normals; give one for each")
    return at, up


def _check_rays(origins: ArrayLike, directions: ArrayLike) -> tuple[Points, Points]:
    begin, along = _check(origins, "origins"), _check(directions, "directions")
    if begin.shape != along.shape:
        raise InvalidMeshError(
            f"there are {len(begin)} origins and {len(along)} directions; give one for each"
        )
    size = np.linalg.norm(along, axis=1, keepdims=True)
    bad = np.flatnonzero(size[:, 0] == 0.0)
    if len(bad):
        raise InvalidMeshError(f"direction {bad[0]} has no length; give one that has")
    return begin, along / size
