"""Strokes drawn on a surface, and what they are to the network: new curves from curve to curve."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, find_nearest_on
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.joining import join_polylines
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, InvalidNetworkError, Step
from patterndb_sketch.curvenetwork.normals import carry_normals
from patterndb_sketch.curvenetwork.polylines import drop_repeats, move_ends
from patterndb_sketch.surfacing.patch import Surfacing


@dataclass(frozen=True, slots=True, eq=False)
class InkedStroke:
    """One stroke as it lies on a surface.

    surfacing: the surface, None for a stroke that was read and is not laid on one yet.
    parts:  each (k, 3) float64, k >= 1, on the surface; the stroke broke where it left it.
    owners: for every part the patch (k,) that each of its points is on.
    missed: how many of its rays met nothing. rays: how many it had.
    """

    surfacing: Surfacing | None = field(repr=False)
    parts: tuple[Points, ...] = field(repr=False)
    owners: tuple[Int64Array, ...] = field(repr=False)
    missed: int
    rays: int

    def lay_on(self, surfacing: Surfacing) -> InkedStroke | None:
        """Return it on a surface made again; None if that has not the patches it was on."""
        if any(owner.max(initial=-1) >= len(surfacing.patches) for owner in self.owners):
            return None
        return replace(self, surfacing=surfacing)


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """A drawing with new curves.

    drawing: without cycles. walks: for every curve of before the steps that it has become.
    curves:  the new ones.
    """

    drawing: Drawing
    walks: tuple[tuple[Step, ...], ...]
    curves: tuple[int, ...]


def add_ink_curves(drawing: Drawing, ink: InkedStroke, reach: float, stage: int) -> Grown:
    """Add a stroke to a drawing as new curves, which end on curves that are there.

    The stroke is cut where it goes from one patch to the next, and its ends are moved onto the
    nearest place of the curves around their patch. drawing: the whole one. reach: how far an
    end may be off a curve, in units of the points. stage: after how many stages of the drawing
    the stroke comes; of no matter if it has none.

    Raises InvalidNetworkError for an end that meets no curve, and for a stroke that is none
    but the curves that are there.
    """
    whole = drawing.network
    lines = _from_curve_to_curve(ink, reach)
    names = [curve.stroke for curve in whole.curves]
    new = _new_name(names)
    strokes = [*names, *(new for _ in lines)]
    # Its ends are on curves already: it meets them exactly, and nothing else by accident.
    made = join_polylines([*(c.points for c in whole.curves), *lines], None, strokes, 0.0)
    n = len(whole.curves)
    lost = [left for left in made.left_out if left.curve not in range(n)]
    if lost:
        raise InvalidNetworkError(f"the stroke runs along curves: {lost[0]}")
    walks = made.walks[:n]
    added = tuple(dict.fromkeys(c for walk in made.walks[n:] for c, _ in walk))
    # Joined, curves are called by their number; they keep the names of before.
    curves = tuple(_renamed(curve, whole, new) for curve in made.network.curves)
    drawn = [(curve.points, curve.normals) for curve in whole.curves]
    after = carry_normals(CurveNetwork(curves, made.network.nodes), drawn, walks)
    stages: tuple[tuple[int, ...], ...] = ()
    if drawing.stages:
        moved = [
            tuple(dict.fromkeys(c for old in one for c, _ in walks[old])) for one in drawing.stages
        ]
        stages = (*moved[:stage], added, *moved[stage:])
    return Grown(Drawing(after, stages, (*drawing.notes, *made.notes)), walks, added)


def find_snaps(ink: InkedStroke, reach: float) -> list[Points]:
    """Find where the ends of a stroke would be moved to, (3,) each; none for an end without a
    curve of its patch within a reach."""
    found: list[Points] = []
    surfacing = ink.surfacing
    if not ink.parts or surfacing is None:
        return found
    for end in (0, -1):
        patch = surfacing.cycles[int(ink.owners[end][end])]
        around = [surfacing.network.curves[curve].points for curve in patch.curves]
        with suppress(InvalidNetworkError):
            found.append(_foot(around, ink.parts[end][end], reach))
    return found


def _from_curve_to_curve(ink: InkedStroke, reach: float) -> list[Points]:
    """The stroke's runs, each within one patch, with their ends on curves."""
    if ink.surfacing is None:
        raise InvalidNetworkError("the surface that the stroke is on is being made; wait for it")
    network, cycles = ink.surfacing.network, ink.surfacing.cycles
    runs: list[tuple[int, Points]] = []
    for part, owner in zip(ink.parts, ink.owners, strict=True):
        cuts = np.flatnonzero(np.diff(owner)) + 1
        for points, owners in zip(np.split(part, cuts), np.split(owner, cuts), strict=True):
            runs.append((int(owners[0]), points))
    ends: list[list[Points]] = []
    for patch, points in runs:
        around = [network.curves[curve].points for curve in cycles[patch].curves]
        ends.append([_foot(around, points[0], reach), _foot(around, points[-1], reach)])
    for i in range(len(runs) - 1):
        # Where the stroke goes over a curve, one run ends where the next begins.
        gap = np.linalg.norm(runs[i][1][-1] - runs[i + 1][1][0])
        shared = set(cycles[runs[i][0]].curves) & set(cycles[runs[i + 1][0]].curves)
        if gap <= 2.0 * reach and shared:
            halfway = (runs[i][1][-1] + runs[i + 1][1][0]) / 2.0
            both = [network.curves[curve].points for curve in sorted(shared)]
            ends[i][1] = ends[i + 1][0] = _foot(both, halfway, reach)
    lines: list[Points] = []
    for (_, points), (start, end) in zip(runs, ends, strict=True):
        line = drop_repeats(points)
        if len(line) < 2 or arc_length(line)[-1] <= reach:
            # A run as short as this only grazes its patch.
            continue
        lines.append(move_ends(line, start, end))
    if not lines:
        raise InvalidNetworkError("the stroke is too short to be a curve; draw a longer one")
    return lines


def _foot(lines: Sequence[Points], place: Points, reach: float) -> Points:
    """(3,) the nearest place to ``place`` of some polylines, an end of theirs if one is near."""
    best, least = place, np.inf
    for points in lines:
        off, k, share = find_nearest_on(points, place)
        if off < least:
            best, least = points[k] + share * (points[k + 1] - points[k]), off
    if least > reach:
        raise InvalidNetworkError(
            f"the stroke ends {least:.3g} away from the curves around its patch, further than "
            f"{reach:.3g}; begin and end it on curves"
        )
    ends = np.concatenate([points[[0, -1]] for points in lines])
    apart = np.linalg.norm(ends - best, axis=1)
    return ends[apart.argmin()] if apart.min() <= reach / 2.0 else best


def _new_name(names: Sequence[int | str]) -> str:
    taken = set(map(str, names))
    count = 1
    while f"drawn {count}" in taken:
        count += 1
    return f"drawn {count}"


def _renamed(curve: Curve, before: CurveNetwork, new: str) -> Curve:
    number = curve.id
    assert isinstance(number, int)
    if number >= len(before.curves):
        return replace(curve, id=new, stroke=new)
    return replace(curve, id=before.curves[number].id, stroke=before.curves[number].stroke)
