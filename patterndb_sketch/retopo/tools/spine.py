"""The spine tool: one stroke makes a four-sided patch about itself, snapped to what is around.

Source: sketch-based quad meshes paper, section 4 and Fig. 4. The patch is planned in the plane of
the stroke's parameterisation (:func:`plan_spine`): its ends snap where the stroke meets a boundary
(:func:`_snap_end`, orthogonal snapping), its flanks where boundaries run along
(:func:`_plan_flank`, parallel snapping). :func:`draw_spine` takes it from the surface there and
back into the network.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import POINTS, optional_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Edit, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.closing import (
    PlannedPatch,
    close_patch,
    find_boundaries,
    map_boundaries,
    measure_coarseness,
)
from patterndb_sketch.retopo.tools.planar import (
    NewSide,
    OldSide,
    PlanarBoundary,
    PlanarCorner,
    PlanarPatch,
    Side,
    find_fault,
    make_line,
)
from patterndb_sketch.retopo.tracing import MapExtent, SurfaceCurve, spread_map

#: Points that a spine's stroke must have: fewer have no direction in the middle.
FEWEST_POINTS = 3


def draw_spine(network: Network, surface: Surface, stroke: SurfaceCurve, sizes: Sizes) -> Edit:
    """The network with a four-sided patch whose midline is the stroke.

    The patch is ``sizes.spine`` wide to either side, less where a boundary is nearer. Raises
    RefusedError, and nothing changes, for a stroke that is closed, too short or partly off the
    surface, and for a patch that would cross curves or leave the surface.

    Source: sketch-based quad meshes paper, section 4, and section 5 on its parameterisation.
    """
    return close_patch(network, preview_spine(network, surface, stroke, sizes), sizes)


def preview_spine(
    network: Network, surface: Surface, stroke: SurfaceCurve, sizes: Sizes
) -> PlannedPatch:
    """The patch that :func:`draw_spine` would make; raises as that does."""
    if stroke.closed:
        raise RefusedError("a spine has two ends; this stroke is closed")
    if len(stroke.points) < FEWEST_POINTS:
        raise RefusedError(f"a spine needs {FEWEST_POINTS} points or more; draw it longer")
    if stroke.missed:
        raise RefusedError(
            f"{stroke.missed} points of the stroke are off the surface; draw it on the surface"
        )
    width, snap = sizes.spine, sizes.snap_within(sizes.spine)
    length = float(arc_length(stroke.points)[-1])
    seeds = surface.nearest_facing(stroke.points, stroke.normals)
    along = np.gradient(stroke.points, axis=0)
    edges = find_boundaries(network)

    def plan_within(window: MapExtent) -> PlannedPatch:
        onto = spread_map(surface, seeds, along, window)
        boundaries, strokes = map_boundaries(network, edges, onto)
        patch = plan_spine(boundaries, length, width, snap)
        wrong = find_fault(patch, [*boundaries, *strokes])
        if wrong is not None:
            raise RefusedError(f"the spine's patch would {wrong}; erase that, or draw elsewhere")
        return PlannedPatch(patch, tuple(edges), onto)

    window = MapExtent.spine(width, length)
    found = plan_within(window)
    if found.is_on_surface(sizes):
        return found
    # Where triangles are coarse the usual extent has hardly one of them whole.
    return plan_within(window.widen(measure_coarseness(surface, seeds)))


def plan_spine(
    boundaries: Sequence[PlanarBoundary], length: float, half_width: float, snap: float
) -> PlanarPatch:
    """The four-sided patch about a stroke from (0, 0) to (0, length).

    boundaries: of patches that are there, empty on their left. half_width: of the brush, and of
    the patch where nothing is near. snap: radius within which the stroke's ends and the patch's
    corners are taken to a boundary.

    Its corners are, from the stroke's start, left and right, then right and left at its end.
    Raises RefusedError for a patch that would cross a boundary or itself.
    """
    turned = [_turn_boundary(boundary, length) for boundary in boundaries]
    start = _snap_end(boundaries, half_width, snap)
    end = _snap_end(turned, half_width, snap)
    if end is not None:
        end = (_turn_back(end[0], length), _turn_back(end[1], length))
    low_right = _find_right_corner(boundaries, start and start[1], half_width, 0.0, snap)
    high_right = _find_right_corner(boundaries, end and end[0], half_width, length, snap)
    high_left = _find_left_corner(turned, end and end[1], half_width, 0.0, snap, length)
    low_left = _find_left_corner(turned, start and start[0], half_width, length, snap, length)
    right = _plan_flank(boundaries, low_right, high_right, half_width)
    left = _plan_flank(
        turned, _turn_back(high_left, length), _turn_back(low_left, length), half_width
    )
    patch = PlanarPatch(
        (low_left, low_right, high_right, high_left),
        (
            (_plan_end(start, low_left, low_right),),
            right,
            (_plan_end(end, high_right, high_left),),
            tuple(_turn_side(side, length) for side in left),
        ),
    )
    wrong = find_fault(patch, boundaries)
    if wrong is not None:
        raise RefusedError(
            f"the spine's patch would {wrong}; draw the stroke elsewhere, or take a narrower brush"
        )
    return patch


def _find_right_corner(
    boundaries: Sequence[PlanarBoundary],
    at_end: PlanarCorner | None,
    half_width: float,
    v: float,
    snap: float,
) -> PlanarCorner:
    """The corner of the right flank at height v: where the end is, else where it snaps to."""
    if at_end is not None:
        return at_end
    found = _snap_corner(boundaries, v, half_width, snap)
    return PlanarCorner(np.array([half_width, v])) if found is None else found


def _find_left_corner(
    turned: Sequence[PlanarBoundary],
    at_end: PlanarCorner | None,
    half_width: float,
    v: float,
    snap: float,
    length: float,
) -> PlanarCorner:
    """The corner of the left flank that is at height v after half a turn."""
    if at_end is not None:
        return at_end
    return _turn_back(_find_right_corner(turned, None, half_width, v, snap), length)


def _plan_end(
    stretch: tuple[PlanarCorner, PlanarCorner] | None, start: PlanarCorner, end: PlanarCorner
) -> Side:
    if stretch is None or stretch[0].boundary is None:
        return make_line(start.point, end.point)
    first, last = stretch[0].place, stretch[1].place
    return OldSide(stretch[0].boundary, first, last)


def _half_turn(points: Points, length: float) -> Points:
    """About the middle of the stroke: its end becomes its start, the left flank the right one."""
    return np.array([0.0, length]) - points


def _turn_boundary(boundary: PlanarBoundary, length: float) -> PlanarBoundary:
    return replace(boundary, points=_half_turn(boundary.points, length))


def _turn_back(corner: PlanarCorner, length: float) -> PlanarCorner:
    return replace(corner, point=_half_turn(corner.point, length))


def _turn_side(side: Side, length: float) -> Side:
    return NewSide(_half_turn(side.points, length)) if isinstance(side, NewSide) else side


def _snap_end(
    boundaries: Sequence[PlanarBoundary], half_width: float, snap: float
) -> tuple[PlanarCorner, PlanarCorner] | None:
    """The stretch of a boundary that is the end of a patch at the origin, or None.

    The patch goes on in v and is up to half_width wide to either side. The nearest vertex that
    is no corner counts, if it is within the snap radius. From it the end reaches to the next
    corners, or as far as the patch is wide. Returned in the boundary's direction: left, right.
    """
    best, at = snap, None
    for number, boundary in enumerate(boundaries):
        gaps = np.linalg.norm(boundary.points, axis=1)
        gaps[boundary.corner | np.isnan(gaps)] = np.inf
        k = int(np.argmin(gaps))
        if gaps[k] < best or (at is None and gaps[k] <= best):
            best, at = float(gaps[k]), (number, k)
    if at is None:
        return None
    number, start = at
    left = _walk(number, boundaries[number], start, -1, half_width)
    right = _walk(number, boundaries[number], start, 1, half_width)
    # A boundary that runs the other way has its patch where this one would be.
    return (left, right) if left.point[0] < right.point[0] else None


def _walk(
    number: int, boundary: PlanarBoundary, start: int, step: int, half_width: float
) -> PlanarCorner:
    """Where a walk along the boundary stops: at a corner, or where the patch is no wider."""
    n, at = len(boundary.points), start
    for _ in range(n):
        following = at + step
        if not boundary.closed and not 0 <= following < n:
            break
        here, there = boundary.points[at % n], boundary.points[following % n]
        if np.isnan(there).any():
            break
        if abs(there[0]) > half_width:
            edge = np.copysign(half_width, there[0])
            place = at + step * float((edge - here[0]) / (there[0] - here[0]))
            return PlanarCorner(boundary.at(place), number, place)
        at = following
        if boundary.corner[at % n]:
            break
    return PlanarCorner(boundary.at(at), number, float(at))


#: A boundary runs along the stroke if it is less than this off its direction, in radians. The
#: paper has no figure; that of the released program.
ALONG = np.deg2rad(30.0)

#: Points nearer than this part of the brush are one, and so are places nearer than this.
SAME = 1e-9


@dataclass(frozen=True, slots=True)
class _FlankRun:
    """A stretch of a boundary along the flank: places, and points (2,) of its ends."""

    boundary: int
    start: float
    end: float
    low: Points
    high: Points


def _is_along(step: Points) -> NDArray[np.bool_]:
    """(n,) do these steps (n, 2) go up, along the stroke?"""
    return (step[:, 1] > 0.0) & (np.abs(step[:, 0]) < np.tan(ALONG) * step[:, 1])


def _snap_corner(
    boundaries: Sequence[PlanarBoundary], v: float, half_width: float, snap: float
) -> PlanarCorner | None:
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
        for run in _find_stretches(number, boundary, half_width):
            low, high = float(run.low[1]), float(run.high[1])
            nearest = min(max(v, low), high)
            if abs(nearest - v) <= snap:
                place = _find_place(boundary, run, nearest)
                places.append((abs(nearest - v), boundary.at(place)[0], number, place))
    if corners:
        _, number, k = min(corners)
        return PlanarCorner(boundaries[number].points[k], number, float(k))
    if places:
        _, _, number, place = min(places)
        return PlanarCorner(boundaries[number].at(place), number, place)
    return None


def _plan_flank(
    boundaries: Sequence[PlanarBoundary], low: PlanarCorner, high: PlanarCorner, half_width: float
) -> tuple[Side, ...]:
    """The right flank of a patch from its corner below to the one above.

    Boundaries along the stroke between the corners' heights, under the brush, are part of it;
    new curves lead from one to the next. Of boundaries at one height the nearest to the spine
    counts.
    """
    runs = []
    for number, boundary in enumerate(boundaries):
        for run in _find_stretches(number, boundary, half_width):
            cut = _cut_between(boundary, run, low, high)
            if cut is not None:
                runs.append(cut)
    kept: list[_FlankRun] = []
    for run in sorted(runs, key=lambda run: _rank(run, low, high)):
        apart = (run.high[1] <= other.low[1] or run.low[1] >= other.high[1] for other in kept)
        if all(apart):
            kept.append(run)
    sides: list[Side] = []
    at = low.point
    for run in sorted(kept, key=lambda run: run.low[1]):
        if _are_apart(at, run.low, half_width):
            sides.append(make_line(at, run.low))
        sides.append(OldSide(run.boundary, run.start, run.end))
        at = run.high
    if _are_apart(at, high.point, half_width):
        sides.append(make_line(at, high.point))
    return tuple(sides)


def _find_place(boundary: PlanarBoundary, run: _FlankRun, v: float | np.floating) -> float:
    """The place of a run at height v, which is between those of its ends."""
    k = np.arange(np.ceil(run.start), np.floor(run.end) + 1.0)
    places = np.unique(np.concatenate([[run.start], k, [run.end]]))
    heights = np.array([boundary.at(place)[1] for place in places])
    return float(np.interp(v, heights, places))


def _are_apart(a: Points, b: Points, half_width: float) -> bool:
    """Are these two places? Half a turn there and back rounds."""
    return bool(np.abs(a - b).max() > SAME * half_width)


def _rank(run: _FlankRun, low: PlanarCorner, high: PlanarCorner) -> tuple[bool, float]:
    """Runs that begin or end at a corner of the patch go first, then those near the spine."""
    at_corner = any(
        corner.boundary == run.boundary
        and min(np.abs(corner.point - run.low).max(), np.abs(corner.point - run.high).max())
        < SAME * (high.point[1] - low.point[1])
        for corner in (low, high)
    )
    return not at_corner, float(run.low[0] + run.high[0])


def _find_stretches(
    number: int, boundary: PlanarBoundary, half_width: float
) -> Iterator[_FlankRun]:
    """Maximal runs of edges along the stroke that lie under the right half of the brush."""
    points, n = boundary.points, len(boundary.points)
    if n < 2:
        return
    under = (points[:, 0] > 0.0) & (points[:, 0] <= half_width)
    following = np.roll(points, -1, axis=0)
    good = under & np.roll(under, -1) & _is_along(following - points)
    if not boundary.closed:
        good[-1] = False
    # Going up all the time, a run cannot be all of a closed boundary.
    for begin in np.flatnonzero(good & ~np.roll(good, 1)).tolist():
        length = 1
        while good[(begin + length) % n]:
            length += 1
        start, end = float(begin), float(begin + length)
        # Where the next edge goes on along the stroke it leaves the brush: up to there.
        end += _measure_rest(boundary, begin + length, 1, half_width)
        start -= _measure_rest(boundary, begin, -1, half_width)
        yield _FlankRun(number, start, end, boundary.at(start), boundary.at(end))


def _measure_rest(boundary: PlanarBoundary, at: int, step: int, half_width: float) -> float:
    """How much of the edge before or after a vertex is along the stroke and under the brush."""
    n = len(boundary.points)
    if not boundary.closed and not 0 <= at + step < n:
        return 0.0
    here, there = boundary.points[at % n], boundary.points[(at + step) % n]
    if not _is_along(np.array([step * (there - here)]))[0]:
        return 0.0
    edge = half_width if there[0] > half_width else 0.0
    # Never onto the spine itself: u = 0 is on neither side.
    return float((edge - here[0]) / (there[0] - here[0])) if edge > 0.0 else 0.0


def _cut_between(
    boundary: PlanarBoundary, run: _FlankRun, low: PlanarCorner, high: PlanarCorner
) -> _FlankRun | None:
    """The part of a run between the heights of two corners, or None."""
    if run.high[1] <= low.point[1] or run.low[1] >= high.point[1]:
        return None
    start, end = run.start, run.end
    if run.low[1] < low.point[1]:
        start = _settle_place(boundary, low, run, _find_place(boundary, run, low.point[1]))
    if run.high[1] > high.point[1]:
        end = _settle_place(boundary, high, run, _find_place(boundary, run, high.point[1]))
    if not start + SAME < end:
        return None
    return _FlankRun(run.boundary, start, end, boundary.at(start), boundary.at(end))


def _settle_place(
    boundary: PlanarBoundary, corner: PlanarCorner, run: _FlankRun, place: float
) -> float:
    """The place of a corner if it is this one, but for rounding and turns around the boundary."""
    if corner.boundary != run.boundary:
        return place
    n = len(boundary.points)
    own = corner.place + n * round((place - corner.place) / n) if boundary.closed else corner.place
    return own if abs(own - place) < SAME * n else place


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    if a["width"] is not None:
        sizes = replace(sizes, spine=work.check_length("spine: width", a["width"]) / 2.0)
    drawn = work.clean_stroke_here(a["points"], "the spine", False)
    return work.keep_edit(draw_spine(work.network, work.surface, drawn, sizes))


SPINE = Tool(
    "spine",
    "Draw the midline of a four-sided patch.",
    {"points": POINTS, "width": optional_length("of the patch")},
    _act,
    position=20,
    snaps=True,
    control=Control("i", "spine", "draw the midline of a patch    [ ]: its width", brush="spine"),
)
