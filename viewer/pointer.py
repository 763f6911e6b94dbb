"""The pointer over a picture: how near it must be to mean something, and clicks and drags.

All lengths are in points of the picture; a window's height has :data:`viewer.scene.HEIGHT`.
"""

from __future__ import annotations

import math

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

#: A place of the picture, in points from its middle.
Place = tuple[float, float]


class ButtonPress:
    """A click until the pointer strays from where the button went down, a drag from then on.

    place: where it went down, while it may be a click; None in a drag, and with no button down.
    """

    def __init__(self) -> None:
        self.place: Place | None = None

    @property
    def may_be_click(self) -> bool:
        """Has the pointer not strayed yet from where the button went down?"""
        return self.place is not None

    def begin(self, place: Place, *, drags: bool = False) -> None:
        """The button goes down. drags: it is no click, whatever comes."""
        self.place = None if drags else place

    def find_drag(self, last: Place, now: Place) -> Place | None:
        """Find from where a drag goes on to here; None while it may be a click. last: where the
        pointer was before. A drag that began as a click begins where the button went down."""
        if self.place is None:
            return last
        if math.dist(self.place, now) < CLICK:
            return None
        last, self.place = self.place, None
        return last

    def end(self) -> bool:
        """The button comes up, or what it does is dropped; was it a click?"""
        clicked, self.place = self.place is not None, None
        return clicked
