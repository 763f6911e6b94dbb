"""The base that boundaries and strokes are drawn on: a surface, or a plane without one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from patterndb.geometry.surface import Surface

if TYPE_CHECKING:
    from query.boundary import Boundary

#: Points of a path between two clicks, and rounds in which it is pulled taut: each moves every
#: point to the middle of its neighbours, and so many of them are settled by some P**2 / 8.
PATH_POINTS = 33
ROUNDS = 140


class DrawingBase:
    """A surface to draw on, or the plane through a point.

    surface: None for the plane. point, normal: (3,) of the plane.
    """

    def __init__(
        self,
        surface: Surface | None,
        point: Points | None = None,
        normal: Points | None = None,
    ) -> None:
        self.surface = surface
        self.point = np.zeros(3) if point is None else point
        self.normal = np.array([0.0, 0.0, 1.0]) if normal is None else normal
        self._edges: coo_array | None = None

    @classmethod
    def of_boundary(cls, boundary: Boundary) -> DrawingBase:
        """The plane through the middle of a boundary whose vertices are placed, across its mean
        normal."""
        assert boundary.points is not None
        middle = boundary.points.mean(axis=0)
        spokes = boundary.points - middle
        area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
        size = float(np.linalg.norm(area))
        return cls(None, middle, area / size if size > 0.0 else None)

    def hit(self, at: Points, toward: Points) -> Points | None:
        """Find the point (3,) seen at a point (3,) of space, from far away against a unit vector
        (3,); None off the surface."""
        if self.surface is None:
            slope = float(toward @ self.normal)
            if abs(slope) < 1e-3:
                return None
            return at + toward * (float((self.point - at) @ self.normal) / slope)
        reach = self.surface.diagonal + float(
            np.abs((self.surface.vertices - at) @ toward).max(initial=0.0)
        )
        start = at + toward * reach
        hit = self.surface.cast_along(start[None], toward[None], np.array([2.0 * reach]))
        return hit.points[0] if hit.found[0] else None

    def on(self, points: Points) -> tuple[Points, Points]:
        """Return the nearest points of the base to (n, 3) points, and its normals there."""
        if self.surface is None:
            off = (points - self.point) @ self.normal
            return points - off[:, None] * self.normal, np.tile(self.normal, (len(points), 1))
        feet = self.surface.nearest(points)
        return feet.points, feet.normals

    def path(self, a: Points, b: Points) -> Points:
        """Return a taut line (k, 3) along the base from one of its points to another.

        From the shortest way along edges, pulled taut point by point: near a shortest path,
        and smooth. Where the surface is in pieces, the chord projected.
        """
        if self.surface is None:
            return np.stack([a, b])
        chain = self._along_edges(a, b)
        if chain is None or arc_length(chain)[-1] == 0.0:
            chain = np.stack([a, b])
        line = sample_polyline(chain, PATH_POINTS - 1)
        line[1:-1] = self.on(line[1:-1])[0]
        for _ in range(ROUNDS):
            line[1:-1] = self.on((line[:-2] + line[2:]) / 2.0)[0]
        return line

    def _along_edges(self, a: Points, b: Points) -> Points | None:
        surface = self.surface
        assert surface is not None
        ends = surface.triangles[surface.nearest(np.stack([a, b])).triangles]
        place = surface.vertices
        start, goal = (
            int(corners[np.linalg.norm(place[corners] - at, axis=1).argmin()])
            for corners, at in zip(ends, (a, b), strict=True)
        )
        length, before = dijkstra(
            self._graph(surface), directed=False, indices=start, return_predecessors=True
        )
        if not np.isfinite(length[goal]):
            return None
        way = [goal]
        while way[-1] != start:
            way.append(int(before[way[-1]]))
        # The first and last vertex may lie behind the ends.
        inner = place[way[::-1]][1:-1]
        return np.concatenate([a[None], inner, b[None]])

    def _graph(self, surface: Surface) -> coo_array:
        if self._edges is None:
            ends = surface.adjacency.ends
            step = surface.vertices[ends[:, 1]] - surface.vertices[ends[:, 0]]
            n = len(surface.vertices)
            self._edges = coo_array(
                (np.linalg.norm(step, axis=1), (ends[:, 0], ends[:, 1])), shape=(n, n)
            )
        return self._edges
