"""A strip of triangles rerouted round vertices until its shortest path is shortest all round."""

from __future__ import annotations

#: A path that turns at a vertex by less than this angle, in radians, stays there: rerouting
#: would shorten it by the square of it at most.
STRAIGHT = 1e-8

#: A point with a smaller barycentric weight than this lies on the opposite edge.
ON_EDGE = 1e-12

#: Rounds that do not shorten the path before it counts as shortest.
PATIENCE = 4
