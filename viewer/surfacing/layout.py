"""Where the slider stands in the panel."""

from __future__ import annotations

from viewer.panel import MARGIN, PANEL
from viewer.scene import HEIGHT

#: The slider's ends from the panel's left, and its height above the picture's lower edge.
SLIDER = (MARGIN + 6.0, PANEL - MARGIN - 6.0)
SLIDER_Y = HEIGHT - 318.0

#: How near to the slider's line the pointer must be, in points.
GRIP = 14.0

#: Places of the slider go by the square root: where alpha is small, little of it does much.
POWER = 2.0

Room = tuple[float, float]


def share_of(alpha: float) -> float:
    """Where an alpha from 0 to 1 is on the slider, 0 to 1."""
    return min(max(alpha, 0.0), 1.0) ** (1.0 / POWER)


def alpha_of(share: float) -> float:
    """The alpha at a place of the slider."""
    return min(max(share, 0.0), 1.0) ** POWER


def alpha_at(room: Room, x: float) -> float:
    """The alpha at x points from the middle of the view; room: size of the view."""
    left = room[0] / 2.0 + SLIDER[0]
    return alpha_of((x - left) / (SLIDER[1] - SLIDER[0]))


def on_slider(room: Room, x: float, y: float) -> bool:
    """Is a place, in points from the middle of the view, on the slider?"""
    left, right = (room[0] / 2.0 + end for end in SLIDER)
    return left - GRIP <= x <= right + GRIP and abs(y - (SLIDER_Y - room[1] / 2.0)) <= GRIP
