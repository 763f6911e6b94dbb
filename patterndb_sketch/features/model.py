"""A model of any quality: triangles to ask for nearest points, hits of lines and parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Floats, Points, as_points
from patterndb.geometry.trianglemesh import TriangleMesh
from patterndb.geometry.triangulation import WELD, sort_triangles, triangulate_faces, weld
from patterndb_sketch.features.errors import InvalidFeatureError


@dataclass(frozen=True, slots=True, eq=False)
class ModelFeet:
    """Points of a model, each for one that was asked for.

    points: (n, 3) float64. triangles: (n,) int32, where they lie; -1 without a hit.
    lengths: (n,) float64, how far off in units of the model: the distance of a nearest point,
    or how far along a line, inf without a hit. Points without a hit are nan.
    """

    points: Points
    triangles: Int32Array
    lengths: Floats

    @property
    def found(self) -> NDArray[np.bool_]:
        """(n,) bool, is there a point?"""
        return self.triangles >= 0


@dataclass(frozen=True, slots=True, eq=False)
class LineHits:
    """All hits of lines with a model.

    Those of line i are the entries ``offsets[i]:offsets[i + 1]`` of points (h, 3), triangles
    (h,) and lengths (h,), ascending in length, which is negative behind where the line begins.
    A line through an edge hits every triangle there, each for itself.
    """

    offsets: NDArray[np.int64]
    points: Points
    triangles: Int32Array
    lengths: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Any polygon mesh as a soup of triangles; nothing is repaired, and no sense is trusted.

    mesh:      every place once, in lexicographic order; triangles ascending, each within itself
               and all in lexicographic order.
    components: (t,) int32, the surface patch that each triangle belongs to: parts that share
               no point, numbered from 0 by their first triangles.
    diagonal:  length of the diagonal of the box of the points.
    dropped:   triangles left out because two of their corners are one point, and faces with
               fewer than three corners. Needles without area stay: they hold parts together.
    repeated:  triangles left out because they repeat another: CAD models have sheets twice,
               once for each side.

    The same triangles in another order, sense or soup give the same arrays, bit for bit.
    """

    mesh: TriangleMesh
    components: Int32Array
    diagonal: float
    dropped: int
    repeated: int

    @classmethod
    def from_polygons(cls, mesh: PolygonMesh) -> Model:
        """From faces of any arity, concave ones too.

        Raises InvalidFeatureError for points that are not finite, and if there is no triangle.
        """
        used = np.unique(mesh.corners)
        if not len(used):
            raise InvalidFeatureError("the model has no faces; give a mesh with faces")
        bad = np.flatnonzero(~np.isfinite(mesh.points[used]).all(axis=1))
        if len(bad):
            raise InvalidFeatureError(f"point {used[bad[0]]} of the model is not finite; mend it")
        chosen = np.asarray(mesh.points[used], np.float64)
        diagonal = float(np.linalg.norm(np.ptp(chosen, axis=0)))
        points, place = weld(chosen, WELD * diagonal)
        name = np.zeros(len(mesh.points), np.int64)
        name[used] = place
        pieces, dropped = triangulate_faces(points, name[mesh.corners], mesh.offsets)
        triangles, repeated = sort_triangles(pieces)
        if not len(triangles):
            raise InvalidFeatureError("the model has no triangle with three corners")
        # Points of nothing but dropped triangles are none of the model's.
        kept, triangles = np.unique(triangles, return_inverse=True)
        points = np.ascontiguousarray(points[kept])
        triangles = np.ascontiguousarray(triangles.reshape(-1, 3), np.int32)
        return cls(
            TriangleMesh(points, triangles),
            _components(triangles, len(points)),
            float(np.linalg.norm(np.ptp(points, axis=0))),
            dropped,
            repeated,
        )

    @classmethod
    def from_arrays(cls, points: ArrayLike, triangles: ArrayLike) -> Model:
        """From (v, 3) points and (t, 3) triangles; see :meth:`from_polygons`."""
        places = np.asarray(points, np.float64)
        faces = np.asarray(triangles)
        if places.ndim != 2 or places.shape[1] != 3:
            raise InvalidFeatureError(f"the model's points must be (v, 3), got {places.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise InvalidFeatureError(
                f"the model's triangles must be (t, 3) whole numbers, got {faces.dtype} "
                f"{faces.shape}; faces of other arities go into a PolygonMesh"
            )
        if faces.size and not (faces.min() >= 0 and faces.max() < len(places)):
            raise InvalidFeatureError(
                f"a triangle of the model names a point outside 0..{len(places) - 1}"
            )
        offsets = 3 * np.arange(len(faces) + 1, dtype=np.int64)
        return cls.from_polygons(PolygonMesh(places, faces.ravel().astype(np.int32), offsets))

    @property
    def points(self) -> Points:
        """(v, 3) float64."""
        return self.mesh.points

    @property
    def triangles(self) -> Int32Array:
        """(t, 3) int32."""
        return self.mesh.triangles

    @property
    def corners(self) -> Points:
        """(t, 3, 3) float64, the points of the triangles."""
        return self.mesh.corners

    @property
    def n_components(self) -> int:
        return int(self.components.max()) + 1

    def nearest(self, points: ArrayLike) -> ModelFeet:
        """The points of the model nearest to (n, 3) points, and how far they are."""
        asked = as_points(points, "points asked for", InvalidFeatureError)
        triangles, weights = self.mesh.find_nearest(asked)
        feet = self.mesh.interpolate_points(triangles, weights)
        return ModelFeet(feet, triangles, np.linalg.norm(feet - asked, axis=1))

    def first_hits(self, origins: ArrayLike, directions: ArrayLike) -> ModelFeet:
        """Where rays from (n, 3) origins along (n, 3) directions of any length first hit.

        Both sides of triangles are hit; a ray within a triangle's plane does not hit it.
        """
        begin, unit = _lines(origins, directions)
        triangles, weights, lengths = self.mesh.cast_rays(begin, unit)
        points = self.mesh.interpolate_points(triangles, weights)
        points[triangles < 0] = np.nan
        return ModelFeet(points, triangles, lengths)

    def all_hits(self, origins: ArrayLike, directions: ArrayLike) -> LineHits:
        """All hits of lines through (n, 3) origins along (n, 3) directions, both ways."""
        begin, unit = _lines(origins, directions)
        line, triangles, weights, lengths = self.mesh.cast_lines(begin, unit)
        order = np.lexsort((triangles, lengths, line))
        offsets = np.searchsorted(line, np.arange(len(begin) + 1))
        points = self.mesh.interpolate_points(triangles[order], weights[order])
        return LineHits(offsets, points, triangles[order], lengths[order])

    def outermost(self, origins: ArrayLike, directions: ArrayLike) -> ModelFeet:
        """The last hits of lines along their directions, which may lie behind the origins.

        Source: feature curve recovery paper, section 5.1.2; lengths are its gamma_max. Where
        the line hits nothing the length is inf, the triangle -1.
        """
        hits = self.all_hits(origins, directions)
        met = np.diff(hits.offsets) > 0
        last = hits.offsets[1:][met] - 1
        points = np.full((len(met), 3), np.nan)
        triangles = np.full(len(met), -1, np.int32)
        lengths = np.full(len(met), np.inf)
        points[met], triangles[met] = hits.points[last], hits.triangles[last]
        lengths[met] = hits.lengths[last]
        return ModelFeet(points, triangles, lengths)

    def within_box(self, low: ArrayLike, high: ArrayLike) -> Int32Array:
        """(k,) the triangles whose boxes meet the box from (3,) to (3,), ascending."""
        corner = np.asarray(low, np.float64), np.asarray(high, np.float64)
        return self.mesh.find_in_box(*corner)


def _components(triangles: Int32Array, n_points: int) -> Int32Array:
    tail = triangles[:, [0, 1]].ravel()
    head = triangles[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(tail), np.int8), (tail, head)), (n_points, n_points))
    label = connected_components(graph, directed=False)[1][triangles[:, 0]]
    _, first, name = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int32)
    rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return rank[name]


def _lines(origins: ArrayLike, directions: ArrayLike) -> tuple[Points, Points]:
    begin = as_points(origins, "origins of lines", InvalidFeatureError)
    along = as_points(directions, "directions of lines", InvalidFeatureError)
    if begin.shape != along.shape:
        raise InvalidFeatureError(
            f"there are {len(begin)} origins and {len(along)} directions; give one for each"
        )
    size = np.linalg.norm(along, axis=1, keepdims=True)
    bad = np.flatnonzero(size[:, 0] == 0.0)
    if len(bad):
        raise InvalidFeatureError(f"direction {bad[0]} has no length; give one that has")
    return begin, along / size
