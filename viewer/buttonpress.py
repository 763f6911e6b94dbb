"""A button that is held down over a picture: a click, or a drag."""

from __future__ import annotations

import math

from viewer.nearness import CLICK

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
