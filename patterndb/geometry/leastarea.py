"""Triangulate closed polylines in space with the least area: one recurrence, for all who need it.

The best triangulation between vertices i and j is the best triangle on that edge and the best
triangulations beyond its two other edges (Barequet and Sharir 1995, "Filling gaps in the boundary
of a polyhedron", section 3). Time grows with the cube of the number of vertices.

- :func:`triangulate_cheapest` is the recurrence as it stands, for faces and other short polylines.
- :func:`tabulate_areas` and :func:`choose_triangles` are for long ones: the first runs in vector
  registers and keeps areas alone; the second goes back through them and can afford to weigh
  triangulations of equal area.
- :func:`tabulate_areas_around` has the least areas of all stretches around a closed polyline: those
  on both sides of every chord.
"""

from __future__ import annotations

#: Areas that differ by less than this part of the whole are equal: rounding is below it, and a
#: planar stretch, where all triangulations have one area, is not triangulated by rounding.
TIE = 1e-12

#: A triangle whose angle has a cosine this near to -1 is flat: never the better of equals.
FLAT = 1e-9
