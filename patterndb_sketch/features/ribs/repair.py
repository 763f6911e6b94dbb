"""Repair: segments without what hangs over where they cross others, and with small gaps bridged.

Surfaces that were drawn out to meet go on beyond the place where they cross: trim_overhangs takes
that off. Ends that face each other are joined as the surfaces on both sides go on: bridge_gaps.
mend_segments does both in turn.
"""

from __future__ import annotations

#: SHARPEST, GAP and OVERHANG in rust/features/src/ribs/repair.rs are the same as here.

#: The direction of an end is taken over this share of the gap.
SPAN = 0.25

#: Cosine of the sharpest turn at which both sides of a gap are drawn out until they meet: 120
#: degrees. So the corner is no farther than 1.16 times the gap's width from either end.
SHARPEST = -0.5

#: An end that runs at the side of another segment meets it no farther away than this many times
#: the gap: at 30 degrees or more.
STEEP = 2.0


#: The other segment must not come much closer to an end than its own end does.
BESIDE = 0.7

#: How often overhangs are taken off, and ends joined: what one leaves may be for the next.
MENDS = 4

#: Ends this close to others, as a share of the radius, leave a gap that is to be closed: as much
#: as dilation may close within the picture's margin. At the usual radius 0.28 % of the diagonal,
#: or 13 mm of a car.
GAP = 0.055

#: Where two segments cross, both may hang over by this share of the radius: at the usual radius
#: 0.75 % of the diagonal, or 35 mm of a car.
OVERHANG = 0.15

#: Edges this close touch, as a share of the tolerance for stitching: points are computed to some
#: 1e-15 of the diagonal.
TOUCH = 1e-3
