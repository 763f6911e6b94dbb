"""Triangles that are asked for nearest points, hits of lines and what is in a box.

Surfaces of every kind hold one: they say what their triangles may be and what an answer is in
their own terms; how it is found stands here, and in rust/geometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from patterndb._native.geometry.casting import all_hits, first_ahead, first_along, first_hits
from patterndb._native.geometry.proximity import nearest, nearest_facing, within_box
from patterndb._native.geometry.tree import build
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

#: What is drawn within less than this part of a mesh's diagonal is in one place.
ONE_PLACE = 1e-6


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles, with a tree of boxes that is built when they are first asked.

    points:    (v, 3) float64.
    triangles: (t, 3) int32, numbers of points. Nothing is checked: triangles may be without area,
               and in any order and sense.

    A place on the triangles is given by its triangle (n,) int32 and the barycentric weights (n, 3)
    of the triangle's corners.
    """

    points: Points
    triangles: Int32Array

    @classmethod
    def from_corners(cls, corners: Points) -> TriangleMesh:
        """Make a mesh of triangles (t, 3, 3) that share no points."""
        return cls(
            corners.reshape(-1, 3), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
        )

    @cached_property
    def corners(self) -> Points:
        """(t, 3, 3) float64, the triangles' points."""
        return np.ascontiguousarray(self.points[self.triangles])

    @cached_property
    def boxes(self) -> tuple[Points, Int32Array, Int32Array]:
        """Boxes, nodes and order, see :mod:`patterndb.geometry.tree`."""
        return build(self.corners)

    @property
    def tree(self) -> tuple[Points, Points, Int32Array, Int32Array]:
        """What the compiled core asks: corners, boxes, nodes and order."""
        return self.corners, *self.boxes

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of the triangles' box."""
        return float(np.linalg.norm(np.ptp(self.corners.reshape(-1, 3), axis=0)))

    def interpolate_points(self, triangles: Int32Array, weights: Points) -> Points:
        """Compute the points (n, 3) of places."""
        return np.einsum("ne,nec->nc", weights, self.corners[triangles])

    def find_nearest(self, points: Points) -> tuple[Int32Array, Points]:
        """Find the places nearest to (n, 3) points."""
        return nearest(*self.tree, np.ascontiguousarray(points))

    def explain_distance(
        self, points: Points, what: str, reach: float, most: float = math.inf
    ) -> str | None:
        """Why points (n, 3) that are to lie on the mesh are in another unit, or elsewhere, as a
        sentence's part; None if they are near it.

        what: the mesh is called. reach: how far off the nearest point may be, and most: the
        farthest, as shares of the mesh's diagonal. Nor may the nearest be farther off than the
        points are apart: in metres, what is drawn on a mesh in millimetres is in one place.
        """
        off = np.linalg.norm(self.interpolate_points(*self.find_nearest(points)) - points, axis=1)
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

    def find_nearest_facing(self, points: Points, normals: Points) -> tuple[Int32Array, Points]:
        """Find the nearest places on triangles that face as (n, 3) normals do; triangle -1 where
        there is none."""
        return nearest_facing(
            *self.tree, np.ascontiguousarray(points), np.ascontiguousarray(normals)
        )

    def cast_along(
        self, points: Points, normals: Points, reach: Floats
    ) -> tuple[Int32Array, Points]:
        """Find the hits nearest to (n, 3) points of lines along (n, 3) unit normals, both ways.

        reach: (n,) how far they may be. Triangles that face away are not seen; triangle -1 where
        there is no hit.
        """
        return first_along(
            *self.tree, np.ascontiguousarray(points), np.ascontiguousarray(normals), reach
        )

    def cast_ahead(self, origins: Points, directions: Points) -> tuple[Int32Array, Points]:
        """Find what rays (n, 3), (n, 3) of unit direction meet first, of either side; triangle -1
        where there is nothing. A ray at the rim of a triangle may meet its neighbour, or, at the
        mesh's border, the triangle."""
        return first_ahead(
            *self.tree, np.ascontiguousarray(origins), np.ascontiguousarray(directions)
        )

    def cast_rays(self, origins: Points, directions: Points) -> tuple[Int32Array, Points, Floats]:
        """Find the first hits of rays (n, 3), (n, 3), of either side, none slipping between two
        triangles: places, triangle -1 without a hit, and how far along (n,), then inf."""
        return first_hits(
            *self.tree, np.ascontiguousarray(origins), np.ascontiguousarray(directions)
        )

    def cast_lines(
        self, origins: Points, directions: Points
    ) -> tuple[Int32Array, Int32Array, Points, Floats]:
        """Find all hits of lines (n, 3), (n, 3), both ways, of either side: for each its line
        (h,), ascending, its place, and how far along (h,), negative behind the origin."""
        return all_hits(*self.tree, np.ascontiguousarray(origins), np.ascontiguousarray(directions))

    def find_in_box(self, low: Points, high: Points) -> Int32Array:
        """Find the triangles (k,) whose boxes meet the box from (3,) to (3,), ascending."""
        return within_box(*self.tree, low, high)
