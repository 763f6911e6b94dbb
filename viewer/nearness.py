"""How near the pointer must be to something to mean it, for every viewer.

All are in points of the picture, of which a window's height has :data:`viewer.scene.HEIGHT`.
"""

from __future__ import annotations

#: A press and a release nearer to each other than this are a click, else a drag.
CLICK = 4.0

#: A feature curve, and a pin on one.
FEATURE_REACH, PIN_REACH = 9.0, 10.0

#: A feature curve of a shape: there is nothing else beside them that could be meant.
SHAPE_CURVE_REACH = 11.0

#: A curve of a network of quads.
CHAIN_REACH = 14.0

#: The ring of a patch that is switched off.
RING_REACH = 12.0

#: A stroke's end and the curve that it is meant to be on.
STROKE_END_REACH = 16.0

#: A side or a corner of a boundary, which the picture is full of.
SIDE_REACH = 90.0
