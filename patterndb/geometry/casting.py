"""What lines hit of triangles, down their tree.

Three ways, for what hits are wanted of. :func:`first_along` has the hits of one side of a clean
surface, both ways along a normal. :func:`first_ahead` has those of rays of sight, of both sides.
:func:`first_hits` and :func:`all_hits` lose none between two triangles, for models of any quality.
They differ in what they do at the rims of triangles, and their numbers are part of results.
"""

from __future__ import annotations

#: Barycentric coordinates this far below 0 still count as a hit: a line through an edge hits
#: one of its two triangles.
SLACK = 1e-9


#: Boxes are this much wider for lines, as a share of the farthest coordinate from where the
#: line begins: a hit at the rim of a triangle is not lost to rounding.
ROUNDING = 1e-13
