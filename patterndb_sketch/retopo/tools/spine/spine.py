"""The patch about a stroke.

Source: sketch-based quad meshes paper, section 4 and Fig. 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.tools.plane import (
    Boundary,
    Corner,
    NewSide,
    OldSide,
    PlanarPatch,
    Side,
    fault,
    straight,
)
from patterndb_sketch.retopo.tools.spine.ends import snapped_end
from patterndb_sketch.retopo.tools.spine.flanks import flank, snapped_corner


def spine_patch(
    boundaries: Sequence[Boundary], length: float, half_width: float, snap: float
) -> PlanarPatch:
    """The four-sided patch about a stroke from (0, 0) to (0, length).

    boundaries: of patches that are there, empty on their left. half_width: of the brush, and of
    the patch where nothing is near. snap: radius within which the stroke's ends and the patch's
    corners are taken to a boundary.

    Its corners are, from the stroke's start, left and right, then right and left at its end.
    Raises RefusedError for a patch that would cross a boundary or itself.
    """
    turned = [_turned(boundary, length) for boundary in boundaries]
    start = snapped_end(boundaries, half_width, snap)
    end = snapped_end(turned, half_width, snap)
    if end is not None:
        end = (_back(end[0], length), _back(end[1], length))
    low_right = _corner(boundaries, start and start[1], half_width, 0.0, snap)
    high_right = _corner(boundaries, end and end[0], half_width, length, snap)
    high_left = _turned_corner(turned, end and end[1], half_width, 0.0, snap, length)
    low_left = _turned_corner(turned, start and start[0], half_width, length, snap, length)
    right = flank(boundaries, low_right, high_right, half_width)
    left = flank(turned, _back(high_left, length), _back(low_left, length), half_width)
    patch = PlanarPatch(
        (low_left, low_right, high_right, high_left),
        (
            (_end(start, low_left, low_right),),
            right,
            (_end(end, high_right, high_left),),
            tuple(_turned_side(side, length) for side in left),
        ),
    )
    wrong = fault(patch, boundaries)
    if wrong is not None:
        raise RefusedError(
            f"the spine's patch would {wrong}; draw the stroke elsewhere, or take a narrower brush"
        )
    return patch


def _corner(
    boundaries: Sequence[Boundary],
    at_end: Corner | None,
    half_width: float,
    v: float,
    snap: float,
) -> Corner:
    """The corner of the right flank at height v: where the end is, else where it snaps to."""
    if at_end is not None:
        return at_end
    found = snapped_corner(boundaries, v, half_width, snap)
    return Corner(np.array([half_width, v])) if found is None else found


def _turned_corner(
    turned: Sequence[Boundary],
    at_end: Corner | None,
    half_width: float,
    v: float,
    snap: float,
    length: float,
) -> Corner:
    """The corner of the left flank that is at height v after half a turn."""
    if at_end is not None:
        return at_end
    return _back(_corner(turned, None, half_width, v, snap), length)


def _end(stretch: tuple[Corner, Corner] | None, start: Corner, end: Corner) -> Side:
    if stretch is None or stretch[0].boundary is None:
        return straight(start.point, end.point)
    first, last = stretch[0].place, stretch[1].place
    return OldSide(stretch[0].boundary, first, last)


def _half_turn(points: Points, length: float) -> Points:
    """About the middle of the stroke: its end becomes its start, the left flank the right one."""
    return np.array([0.0, length]) - points


def _turned(boundary: Boundary, length: float) -> Boundary:
    return replace(boundary, points=_half_turn(boundary.points, length))


def _back(corner: Corner, length: float) -> Corner:
    return replace(corner, point=_half_turn(corner.point, length))


def _turned_side(side: Side, length: float) -> Side:
    return NewSide(_half_turn(side.points, length)) if isinstance(side, NewSide) else side
