"""Pulls: from where the pointer goes to where a curve shall go in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from viewer.view import View

#: An axis that is seen shorter than this part of itself points at the viewer: nobody can tell how
#: far along it a pull goes.
END_ON = 0.15


@dataclass(frozen=True, slots=True)
class Grab:
    """A curve in hand: its number, the nearest vertex in it, and where it was pressed."""

    line: int
    place: int
    pressed: tuple[float, float]


def displaced(view: View, dx: float, dy: float, axis: int | None) -> Points | None:
    """(3,) what a pull by so many points of the picture means in space.

    In the plane of the screen, or along an axis: as far as the pull goes along the axis as it is
    seen. None if that points at the viewer.
    """
    if axis is None:
        return (dx * view.axes[0] + dy * view.axes[1]) / view.scale
    seen = view.axes[:2, axis]
    size = float(seen @ seen)
    if size < END_ON**2:
        return None
    offset = np.zeros(3)
    offset[axis] = (dx * seen[0] + dy * seen[1]) / (size * view.scale)
    return offset
