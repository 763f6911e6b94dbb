"""Local parameterisation: (u, v) spread over the surface from a stroke or a point.

A discrete exponential map. Source: Schmidt 2013, "Stroke Parameterization", as Takayama et
al. 2013 and their released program use it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.retopo.tracing.localmap import (
    file_triangles,
    find_containing,
    find_mapped,
    propose,
    spread_front,
)
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: A triangle with an edge this many times as long in (u, v) as it is lies where two fronts met,
#: as on the back of a thin limb.
TORN = 2.5


#: The way along edges of triangles is at most about so many times as long as the straight one.
AROUND = 2.0


@dataclass(frozen=True, slots=True)
class MapExtent:
    """How far a map goes: along the surface's edges from its seeds, and in u and v.

    The factors of the two makers are those of the released program of Takayama et al. 2013.
    """

    distance: float
    u: tuple[float, float]
    v: tuple[float, float]

    @classmethod
    def spine(cls, b: float, length: float) -> MapExtent:
        """Around a stroke of this length, for a brush of half-width b."""
        return cls(1.8 * b, (-1.5 * b, 1.5 * b), (-0.5 * b, length + 0.5 * b))

    def widen(self, by: float) -> MapExtent:
        """This much further on all sides: so that triangles of such edges, which lie in it only in
        part, have all their corners in it."""
        (left, right), (low, high) = self.u, self.v
        # Along edges it is further than straight.
        return MapExtent(
            self.distance + AROUND * by, (left - by, right + by), (low - by, high + by)
        )

    @classmethod
    def completion(cls, b: float) -> MapExtent:
        """Around a point of a boundary, for suggestions of radius b."""
        return cls(3.8 * b, (-1.2 * b, 1.2 * b), (-0.3 * b, 2.2 * b))


@dataclass(frozen=True, slots=True, eq=False)
class LocalMap:
    """(u, v) of a part of the surface: v along the stroke, u to its right seen from outside.

    vertices:  (m,) int32, the surface's vertices that have (u, v), the nearest first.
    uv:        (m, 2) float64.
    distance:  (m,) float64 along edges from the seeds.
    triangles: (k,) int32 ascending, the surface's triangles with (u, v) at all three corners.
    corners:   (k, 3) int32, their corners as places in ``vertices``.
    """

    surface: Surface
    vertices: Int32Array
    uv: Points
    distance: NDArray[np.float64]
    triangles: Int32Array
    corners: Int32Array
    _grid: tuple[Points, Int32Array, Int32Array]

    def of(self, feet: SurfacePoints) -> Points:
        """(n, 2) the (u, v) of points on the surface; nan outside of the map."""
        result = np.full((len(feet), 2), np.nan)
        if len(self.triangles) == 0:
            return result
        place = np.searchsorted(self.triangles, feet.triangles)
        place = np.minimum(place, len(self.triangles) - 1)
        within = self.triangles[place] == feet.triangles
        corner = self.uv[self.corners[place[within]]]
        result[within] = np.einsum("ne,nec->nc", feet.weights[within], corner)
        return result

    def of_points(self, points: ArrayLike, normals: ArrayLike) -> Points:
        """(n, 2) the (u, v) of (n, 3) points, with (n, 3) normals, on or near the surface.

        Each is taken to the nearest point that faces as it does; nan where that is outside of
        the map, and for points further from the map's box than half its diagonal, which cost
        nothing.
        """
        at, up = np.asarray(points, np.float64), np.asarray(normals, np.float64)
        result = np.full((len(at), 2), np.nan)
        if len(self.vertices) == 0:
            return result
        mapped = self.surface.vertices[self.vertices]
        low, high = mapped.min(axis=0), mapped.max(axis=0)
        room = 0.5 * float(np.linalg.norm(high - low))
        near = np.flatnonzero(((at >= low - room) & (at <= high + room)).all(axis=1))
        there = self.surface.nearest_facing(at[near], up[near])
        result[near] = self.of(there)
        result[near[there.lost]] = np.nan
        return result

    def at(self, uv: ArrayLike) -> tuple[SurfacePoints, NDArray[np.bool_]]:
        """Points of the surface with these (u, v), (n, 2), and (n,) whether there is one.

        Where the map lies over itself the one nearest to the seeds. Where there is none the
        foot is nan, its triangle -1.
        """
        wanted = np.ascontiguousarray(uv, np.float64)
        if wanted.ndim != 2 or wanted.shape[1] != 2:
            raise InvalidRetopoError(f"(u, v) must be (n, 2), got {wanted.shape}")
        place, weights = find_containing(self.uv, self.corners, self.distance, *self._grid, wanted)
        found = place >= 0
        triangles = np.full(len(wanted), -1, np.int32)
        triangles[found] = self.triangles[place[found]]
        feet = self.surface.at(triangles, weights)
        return feet, found


def spread_map(
    surface: Surface, seeds: SurfacePoints, tangents: ArrayLike, window: MapExtent
) -> LocalMap:
    """The map spread from a stroke's points (n >= 1), or from one point.

    tangents: (n, 3) directions of v, of any length above 0; only their parts along the surface
    count. v is 0 at the first seed and grows by the distance from seed to seed.
    Raises InvalidRetopoError for no seeds, and for a tangent without a part along the surface.

    Differs from the sources: triangles where two fronts met, torn in (u, v), have none.
    """
    along = np.ascontiguousarray(tangents, np.float64)
    if len(seeds) == 0 or along.shape != seeds.points.shape:
        raise InvalidRetopoError(
            f"a local map was asked for from {len(seeds)} points with tangents of the shape "
            f"{along.shape}; give one point or more, and (n, 3) tangents"
        )
    up = seeds.normals
    along = along - np.einsum("nc,nc->n", along, up)[:, None] * up
    size = np.linalg.norm(along, axis=1)
    bad = np.flatnonzero(~(size > 1e-9 * np.linalg.norm(np.asarray(tangents), axis=1)))
    if len(bad):
        raise InvalidRetopoError(
            f"tangent {bad[0]} of a local map has no part along the surface; give the direction "
            "of the stroke there"
        )
    right = np.cross(along / size[:, None], up)
    vertices, uv, axes, distance = _seed_vertices(surface, seeds, right)
    low = np.array([window.u[0], window.v[0]])
    high = np.array([window.u[1], window.v[1]])
    found, uv, distance = spread_front(
        surface.vertices,
        surface.normals,
        surface.adjacency.star_start,
        surface.adjacency.star,
        vertices,
        uv,
        axes,
        distance,
        window.distance,
        low,
        high,
    )
    triangles, corners = find_mapped(surface.triangles, surface.vertices, found, uv, TORN)
    return LocalMap(surface, found, uv, distance, triangles, corners, file_triangles(uv, corners))


def _seed_vertices(
    surface: Surface, seeds: SurfacePoints, right: Points
) -> tuple[Int32Array, Points, Points, NDArray[np.float64]]:
    """The vertices nearest to the seeds, with (u, v), u axes and distances: means over all the
    seeds of a vertex. right (n, 3): the seeds' own u axes."""
    n = len(seeds)
    corner = seeds.weights.argmax(axis=1)
    vertex = surface.triangles[seeds.triangles, corner]
    # Every seed hands on to its vertex what a vertex hands on to its neighbour.
    places = np.concatenate([seeds.points, surface.vertices[vertex]])
    normals = np.concatenate([seeds.normals, surface.normals[vertex]])
    axes = np.concatenate([right, right])
    uv = np.stack([np.zeros(n), arc_length(seeds.points)], axis=1)
    offset = np.linalg.norm(places[n:] - places[:n], axis=1)
    step = np.empty(5)
    turned = right.copy()
    for i in range(n):
        if offset[i] > 0.0 and propose(places, normals, axes, i, n + i, step):
            uv[i] += step[:2]
            turned[i] = step[2:]
    chosen, which, count = np.unique(vertex, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    mean_uv, mean_axes = np.zeros((len(chosen), 2)), np.zeros((len(chosen), 3))
    np.add.at(mean_uv, which, uv)
    np.add.at(mean_axes, which, turned)
    distance = np.full(len(chosen), np.inf)
    np.minimum.at(distance, which, offset)
    return (
        chosen.astype(np.int32),
        mean_uv / count[:, None],
        units(mean_axes / count[:, None]),
        distance,
    )
