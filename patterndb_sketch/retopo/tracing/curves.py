"""Curves on the surface: strokes, even and smooth, and traces, exact from side to side."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, as_points, units
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import GRAZE, Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.sizes import Sizes

#: A line along the normal that meets the surface further off than this many target edges has met
#: another part of it.
TOO_FAR = 4.0

#: Rounds of smoothing that take the jitter of a hand out of a stroke. Source: the released
#: program of Takayama et al. 2013.
ROUNDS = 2


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceCurve:
    """A polyline on the surface.

    points:  (n, 3) float64; a closed one does not repeat its first point.
    normals: (n, 3) float64 unit normals of the surface there.
    closed:  does it run back to its first point?
    missed:  how many of its points had no hit along their normals when they were projected, and
             were taken to the nearest point instead.
    """

    points: Points
    normals: Points
    closed: bool
    missed: int = 0

    @property
    def length(self) -> float:
        """Its arc length, with the way back of a closed one."""
        ends = self.points[:1] if self.closed else self.points[:0]
        return float(arc_length(np.concatenate([self.points, ends]))[-1])


def clean_stroke(
    points: ArrayLike,
    surface: Surface,
    sizes: Sizes,
    closed: bool | None = None,
    normals: ArrayLike | None = None,
) -> SurfaceCurve:
    """A stroke as it was drawn, (k, 3) points on or near the surface, made even and smooth.

    normals: (k, 3) the surface's normals where it was drawn, as picking gives them; without
    them those of the nearest points are taken, which may be the other side of a thin part.
    closed: None to find out: it is if its ends are within the snap radius of each other, and
    it was further away in between.

    Sampled at equal arc length, about ``sizes.sampling`` apart and at least 3 points; smoothed
    by :data:`ROUNDS`; projected. Raises InvalidRetopoError for what is no list of points, and
    RefusedError for a stroke of no length.

    Source: the released program of Takayama et al. 2013. Differs from it: a stroke that never
    leaves the snap radius is not closed, so that short curves can be drawn.
    """
    drawn = as_points(points, "a stroke's points", InvalidRetopoError)
    if normals is None:
        up = surface.nearest(drawn).normals if len(drawn) else drawn
    else:
        up = as_points(normals, "a stroke's normals", InvalidRetopoError)
    if len(up) != len(drawn):
        raise InvalidRetopoError(
            f"a stroke of {len(drawn)} points has {len(up)} normals; give one for each"
        )
    moved = np.r_[True, (np.diff(drawn, axis=0) != 0.0).any(axis=1)] if len(drawn) else []
    drawn, up = drawn[moved], up[moved]
    if len(drawn) < 2:
        raise RefusedError("the stroke has no length: it needs two points at different places")
    if closed is None:
        closed = is_closing(drawn, sizes.snap)
    if closed and (drawn[0] != drawn[-1]).any():
        drawn, up = np.concatenate([drawn, drawn[:1]]), np.concatenate([up, up[:1]])
    along = arc_length(drawn)
    edges = max(3 if closed else 2, round(along[-1] / sizes.sampling))
    wanted = np.linspace(0.0, along[-1], edges + 1)[: edges if closed else edges + 1]
    even = at_lengths(drawn, wanted)
    turned = np.stack([np.interp(wanted, along, up[:, d]) for d in range(3)], axis=1)
    even = smooth_polyline(even, ROUNDS, closed)
    done = project_near(surface, even, units(turned), sizes)
    return SurfaceCurve(done.points, done.normals, closed, len(done.missed) + len(done.lost))


def project_near(surface: Surface, points: Points, normals: Points, sizes: Sizes) -> SurfacePoints:
    """Take points (n, 3) that lie nearly on a surface, as those of a curve that was smoothed or cut
    short between places on it, along their normals to it; see :meth:`Surface.project`.

    A hit much further off than the nearest point that faces so is on another part: in a crease the
    line may pass the near side, and meet what is far beyond. Such a point counts as missed.
    """
    close = surface.nearest_facing(points, normals).points
    slack = GRAZE * np.linalg.norm(close - points, axis=1) + sizes.sampling
    return surface.project(points, normals, np.minimum(slack, TOO_FAR * sizes.edge))


def take_to_surface(
    points: Points, normals: Points, surface: Surface, sizes: Sizes
) -> tuple[Points, Points]:
    """(n, 3) points taken to the surface by :func:`project_near`, with its normals there."""
    done = project_near(surface, points, normals, sizes)
    return done.points, done.normals


def is_closing(points: Points, snap: float) -> bool:
    """Are the ends of the polyline (k, 3) within the snap radius, and was it outside between?"""
    off = np.linalg.norm(points - points[0], axis=1)
    return bool(off[-1] <= snap < off.max())


def smooth_polyline(points: Points, rounds: int, closed: bool) -> Points:
    """(n, 3) the points after rounds that bring each halfway to the mean of its two targets.

    The ends of an open polyline stay; it is not projected.
    """
    at = points.copy()
    for _ in range(rounds):
        middle, curved = smoothing_targets(at, closed)
        at = 0.5 * at + 0.25 * (middle + curved)
    return at


def smoothing_targets(points: Points, closed: bool) -> tuple[Points, Points]:
    """Where smoothing wants every point (n, 3), twice: between its neighbours, and on the
    cubic through its four neighbours.

    Points next to the end of an open polyline, which has no four, have the first target twice;
    the ends, and all of fewer than 3 points, themselves.
    """
    n = len(points)
    middle, curved = points.copy(), points.copy()
    if n < 3:
        return middle, curved
    if closed:
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        middle = 0.5 * (before + after)
        if n < 5:
            return middle, middle.copy()
        far = np.roll(points, 2, axis=0) + np.roll(points, -2, axis=0)
        return middle, (4.0 * (before + after) - far) / 6.0
    middle[1:-1] = 0.5 * (points[:-2] + points[2:])
    curved[1:-1] = middle[1:-1]
    curved[2:-2] = (4.0 * (points[1:-3] + points[3:-1]) - points[:-4] - points[4:]) / 6.0
    return middle, curved


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A polyline whose segments each lie within a triangle.

    points:    (n, 3) float64; a closed one does not repeat its first point.
    triangles: (n - 1,) or, closed, (n,) int32: the triangle that holds the segment from each
               point to the next.
    closed:    does it run back to its first point?
    """

    points: Points
    triangles: Int32Array
    closed: bool

    @property
    def round(self) -> Points:
        """(m + 1, 3) the points of the m segments; a closed one ends where it begins."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @property
    def length(self) -> float:
        return float(arc_length(self.round)[-1])

    def feet(self, surface: Surface, lengths: Points) -> SurfacePoints:
        """Points on the surface at these arc lengths (k,) from its start, the ends beyond."""
        line = self.round
        along = arc_length(line)
        wanted = np.clip(np.asarray(lengths, np.float64), 0.0, along[-1])
        k = np.clip(np.searchsorted(along, wanted, side="right") - 1, 0, len(self.triangles) - 1)
        step = along[k + 1] - along[k]
        share = np.where(step > 0.0, (wanted - along[k]) / np.where(step > 0.0, step, 1.0), 0.0)
        points = line[k] + share[:, None] * (line[k + 1] - line[k])
        triangles = self.triangles[k]
        found = surface.at(triangles, find_weights(surface, triangles, points))
        return replace(found, points=points)

    def sample(self, surface: Surface, sampling: float) -> SurfaceCurve:
        """At equal arc length, about ``sampling`` apart, at least 3 points; ends exact."""
        length = self.length
        edges = max(3 if self.closed else 2, round(length / sampling))
        lengths = np.linspace(0.0, length, edges + 1)
        feet = self.feet(surface, lengths[:-1] if self.closed else lengths)
        points = feet.points.copy()
        if not self.closed:
            points[0], points[-1] = self.points[0], self.points[-1]
        return SurfaceCurve(points, feet.normals, self.closed)


def find_weights(surface: Surface, triangles: Int32Array, points: Points) -> Points:
    """(n, 3) barycentric weights of points (n, 3) in the planes of triangles (n,), none below 0."""
    corner = surface.vertices[surface.triangles[triangles]]
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    p = points - corner[:, 0]
    normal = np.cross(u, v)
    size = np.einsum("nc,nc->n", normal, normal)
    one = np.einsum("nc,nc->n", np.cross(p, v), normal) / size
    two = np.einsum("nc,nc->n", np.cross(u, p), normal) / size
    weights = np.clip(np.stack([1.0 - one - two, one, two], axis=1), 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)
