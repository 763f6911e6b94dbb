"""The flanks of a spine's patch: parallel snapping."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.plane import Boundary, Corner, OldSide, Side, straight

#: A boundary runs along the stroke if it is less than this off its direction, in radians. The
#: paper has no figure; that of the released program.
ALONG = np.deg2rad(30.0)

#: Points nearer than this part of the brush are one, and so are places nearer than this.
SAME = 1e-9


@dataclass(frozen=True, slots=True)
class Run:
    """A stretch of a boundary along the flank: places, and points (2,) of its ends."""

    boundary: int
    start: float
    end: float
    low: Points
    high: Points


def is_along(step: Points) -> NDArray[np.bool_]:
    """(n,) do these steps (n, 2) go up, along the stroke?"""
    return (step[:, 1] > 0.0) & (np.abs(step[:, 0]) < np.tan(ALONG) * step[:, 1])


def snapped_corner(
    boundaries: Sequence[Boundary], v: float, half_width: float, snap: float
) -> Corner | None:
    """What the corner of the right flank at height v snaps to, or None.

    Of corners within the snap radius of that height, and under the brush, the one nearest to
    the spine; without any, the place at that height, or nearest to it, on a boundary along the
    stroke.

    Differs from the released program, which takes the vertex nearest to the spine and so
    meets a slanted boundary up to a snap radius early.
    """
    corners: list[tuple[float, int, int]] = []
    places: list[tuple[float, float, int, float]] = []
    for number, boundary in enumerate(boundaries):
        u, height = boundary.points.T
        near = (u > 0.0) & (u <= half_width) & (np.abs(height - v) <= snap)
        corners += [(float(u[k]), number, int(k)) for k in np.flatnonzero(near & boundary.corner)]
        for run in _stretches(number, boundary, half_width):
            low, high = float(run.low[1]), float(run.high[1])
            nearest = min(max(v, low), high)
            if abs(nearest - v) <= snap:
                place = place_at(boundary, run, nearest)
                places.append((abs(nearest - v), boundary.at(place)[0], number, place))
    if corners:
        _, number, k = min(corners)
        return Corner(boundaries[number].points[k], number, float(k))
    if places:
        _, _, number, place = min(places)
        return Corner(boundaries[number].at(place), number, place)
    return None


def flank(
    boundaries: Sequence[Boundary], low: Corner, high: Corner, half_width: float
) -> tuple[Side, ...]:
    """The right flank of a patch from its corner below to the one above.

    Boundaries along the stroke between the corners' heights, under the brush, are part of it;
    new curves lead from one to the next. Of boundaries at one height the nearest to the spine
    counts.
    """
    runs = []
    for number, boundary in enumerate(boundaries):
        for run in _stretches(number, boundary, half_width):
            cut = _between(boundary, run, low, high)
            if cut is not None:
                runs.append(cut)
    kept: list[Run] = []
    for run in sorted(runs, key=lambda run: _rank(run, low, high)):
        apart = (run.high[1] <= other.low[1] or run.low[1] >= other.high[1] for other in kept)
        if all(apart):
            kept.append(run)
    sides: list[Side] = []
    at = low.point
    for run in sorted(kept, key=lambda run: run.low[1]):
        if _apart(at, run.low, half_width):
            sides.append(straight(at, run.low))
        sides.append(OldSide(run.boundary, run.start, run.end))
        at = run.high
    if _apart(at, high.point, half_width):
        sides.append(straight(at, high.point))
    return tuple(sides)


def place_at(boundary: Boundary, run: Run, v: float | np.floating) -> float:
    """The place of a run at height v, which is between those of its ends."""
    k = np.arange(np.ceil(run.start), np.floor(run.end) + 1.0)
    places = np.unique(np.concatenate([[run.start], k, [run.end]]))
    heights = np.array([boundary.at(place)[1] for place in places])
    return float(np.interp(v, heights, places))


def _apart(a: Points, b: Points, half_width: float) -> bool:
    """Are these two places? Half a turn there and back rounds."""
    return bool(np.abs(a - b).max() > SAME * half_width)


def _rank(run: Run, low: Corner, high: Corner) -> tuple[bool, float]:
    """Runs that begin or end at a corner of the patch go first, then those near the spine."""
    at_corner = any(
        corner.boundary == run.boundary
        and min(np.abs(corner.point - run.low).max(), np.abs(corner.point - run.high).max())
        < SAME * (high.point[1] - low.point[1])
        for corner in (low, high)
    )
    return not at_corner, float(run.low[0] + run.high[0])


def _stretches(number: int, boundary: Boundary, half_width: float) -> Iterator[Run]:
    """Maximal runs of edges along the stroke that lie under the right half of the brush."""
    points, n = boundary.points, len(boundary.points)
    if n < 2:
        return
    under = (points[:, 0] > 0.0) & (points[:, 0] <= half_width)
    following = np.roll(points, -1, axis=0)
    good = under & np.roll(under, -1) & is_along(following - points)
    if not boundary.closed:
        good[-1] = False
    # Going up all the time, a run cannot be all of a closed boundary.
    for begin in np.flatnonzero(good & ~np.roll(good, 1)).tolist():
        length = 1
        while good[(begin + length) % n]:
            length += 1
        start, end = float(begin), float(begin + length)
        # Where the next edge goes on along the stroke it leaves the brush: up to there.
        end += _rest(boundary, begin + length, 1, half_width)
        start -= _rest(boundary, begin, -1, half_width)
        yield Run(number, start, end, boundary.at(start), boundary.at(end))


def _rest(boundary: Boundary, at: int, step: int, half_width: float) -> float:
    """How much of the edge before or after a vertex is along the stroke and under the brush."""
    n = len(boundary.points)
    if not boundary.closed and not 0 <= at + step < n:
        return 0.0
    here, there = boundary.points[at % n], boundary.points[(at + step) % n]
    if not is_along(np.array([step * (there - here)]))[0]:
        return 0.0
    edge = half_width if there[0] > half_width else 0.0
    # Never onto the spine itself: u = 0 is on neither side.
    return float((edge - here[0]) / (there[0] - here[0])) if edge > 0.0 else 0.0


def _between(boundary: Boundary, run: Run, low: Corner, high: Corner) -> Run | None:
    """The part of a run between the heights of two corners, or None."""
    if run.high[1] <= low.point[1] or run.low[1] >= high.point[1]:
        return None
    start, end = run.start, run.end
    if run.low[1] < low.point[1]:
        start = _exactly(boundary, low, run, place_at(boundary, run, low.point[1]))
    if run.high[1] > high.point[1]:
        end = _exactly(boundary, high, run, place_at(boundary, run, high.point[1]))
    if not start + SAME < end:
        return None
    return Run(run.boundary, start, end, boundary.at(start), boundary.at(end))


def _exactly(boundary: Boundary, corner: Corner, run: Run, place: float) -> float:
    """The place of a corner if it is this one, but for rounding and turns around the boundary."""
    if corner.boundary != run.boundary:
        return place
    n = len(boundary.points)
    own = corner.place + n * round((place - corner.place) / n) if boundary.closed else corner.place
    return own if abs(own - place) < SAME * n else place
