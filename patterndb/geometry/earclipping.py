"""Triangulate faces of many corners in the plane: ears are clipped, a round of them at a time.

An ear is a corner whose triangle holds no other part of the face; every simple polygon has one
(Meisters 1975, "Polygons have ears"). Whether a corner is an ear is asked of a tree of the corners
that are not convex, for one of these lies within any triangle that anything enters. A corner that
another stands in the way of waits until that one is clipped, and of two neighbours only one is
clipped in a round: so the time grows little faster than the number of corners, and no corner
gathers more triangles than the shape asks for.

Corners are moved onto a grid, where every turn is exact. Two that lie at one place are fine: a face
with a hole is written as one outline that runs to the hole and back along the same edge.
"""

from __future__ import annotations

#: Coordinates on the grid run from 0 to this. A turn is a difference of two products of two
#: differences: below 2**61, so it fits in 64 bits.
GRID = 1 << 30
