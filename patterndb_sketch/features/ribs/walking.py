"""From segments to a picture and back: drawing them, finding where along them a pixel is, and
following a contour's pixels along them, from where to where."""

from __future__ import annotations

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Floats, Points

#: What the kernels here hand on: points (p, 2) in pixels, lengths along (p,), offsets (s + 1,),
#: closed (s,), rims (s, 2); the edges' first points (e,) and owners (e,); per cell the head of
#: its list, the list's edges and links, and how many cells are in a row.
Drawn = tuple[
    Points, Floats, Int32Array, Bools, Bools, Int32Array, Int32Array,
    Int32Array, Int32Array, Int32Array, int,
]  # fmt: skip

#: Pixels by which a segment may run ahead of the contour from one of its pixels to the next,
#: beside twice the contour's steps: an edge crosses a pixel in up to 1.5.
AHEAD = 4.0

#: Pixels that the contour must go back along a segment before it counts as turned round.
BACK = 3.5


#: Pixels that a change between segments may lie before or behind where both are in one pixel.
SLACK = 3.0

#: Contour pixels looked ahead for whether a walk leaves the segment that it begins on.
LEAVING = 12

#: Contour pixels looked back, and ahead, at a change between segments: half of the picture.
LOOK = 400

#: How a walk ends: where it began, at the circle, at the free end of a sheet, or where it meets
#: itself. ``Ended`` in rust/features/src/ribs/walking.rs has the same numbers.
AROUND, RIM_MET, SHEET_END, MET_ITSELF = 0, 1, 2, 3
