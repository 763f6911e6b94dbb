"""A curve along the surface, from side to side of its triangles: exact, and sampled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Points
from patterndb_sketch.retopo.ground.feet import Feet
from patterndb_sketch.retopo.ground.ground import Ground
from patterndb_sketch.retopo.ground.strokes import Stroke


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

    def feet(self, ground: Ground, lengths: Points) -> Feet:
        """Points on the ground at these arc lengths (k,) from its start, the ends beyond."""
        line = self.round
        along = arc_length(line)
        wanted = np.clip(np.asarray(lengths, np.float64), 0.0, along[-1])
        k = np.clip(np.searchsorted(along, wanted, side="right") - 1, 0, len(self.triangles) - 1)
        step = along[k + 1] - along[k]
        share = np.where(step > 0.0, (wanted - along[k]) / np.where(step > 0.0, step, 1.0), 0.0)
        points = line[k] + share[:, None] * (line[k + 1] - line[k])
        triangles = self.triangles[k]
        found = ground.at(triangles, weights_in(ground, triangles, points))
        return Feet(points, found.normals, found.triangles, found.weights)

    def sampled(self, ground: Ground, sampling: float) -> Stroke:
        """At equal arc length, about ``sampling`` apart, at least 3 points; ends exact."""
        length = self.length
        edges = max(3 if self.closed else 2, round(length / sampling))
        lengths = np.linspace(0.0, length, edges + 1)
        feet = self.feet(ground, lengths[:-1] if self.closed else lengths)
        points = feet.points.copy()
        if not self.closed:
            points[0], points[-1] = self.points[0], self.points[-1]
        return Stroke(points, feet.normals, self.closed)


def weights_in(ground: Ground, triangles: Int32Array, points: Points) -> Points:
    """(n, 3) barycentric weights of points (n, 3) in the planes of triangles (n,), none below 0."""
    corner = ground.vertices[ground.triangles[triangles]]
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    p = points - corner[:, 0]
    normal = np.cross(u, v)
    size = np.einsum("nc,nc->n", normal, normal)
    one = np.einsum("nc,nc->n", np.cross(p, v), normal) / size
    two = np.einsum("nc,nc->n", np.cross(u, p), normal) / size
    weights = np.clip(np.stack([1.0 - one - two, one, two], axis=1), 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)
