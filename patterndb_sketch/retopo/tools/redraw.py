"""The redraw tool: a stroke takes the place of the part of a chain between its two ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import POINTS
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.builder import NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.samples import (
    find_nearest_place,
    interpolate_places,
    take_chain_samples,
)
from patterndb_sketch.retopo.network.structure import Chain, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.course import find_crossed
from patterndb_sketch.retopo.tracing import SurfaceCurve
from patterndb_sketch.retopo.tracing.curves import take_to_surface


@dataclass(frozen=True, slots=True)
class _Part:
    """The part of a chain that goes: between the samples nearest to the stroke's ends.

    begin, end: numbers of samples, not descending; on a closed chain without a node, end may be
    beyond the last sample: the part goes over the chain's first. turned: does the stroke run
    against it? distance: how far the stroke's ends were off, together.
    """

    chain: int
    begin: int
    end: int
    turned: bool
    distance: float


def redraw_chain(network: Network, surface: Surface, sizes: Sizes, stroke: SurfaceCurve) -> Edit:
    """Let a chain run along a stroke, cleaned before, between the places where both its ends are
    within the snap radius of the chain.

    Of chains that are near both ends the nearest is taken; a stroke that begins or ends within
    the snap radius of an end of the chain begins or ends there. Of a closed chain the part that
    goes is that which is nearer to the stroke. The ends of the stroke are taken to the chain, and
    all of it along by even shares; its samples are at equal arc length. The rest of the chain
    stays, and so do its ends, its count and its patches.

    Raises RefusedError for a closed stroke, if no chain is near both ends, for a border or the
    seam of symmetry, if the ends are at one place of the chain, and if the new course would cross
    a chain. Source: the program of Takayama et al. 2013. Differs from it: what would cross is
    refused.
    """
    if stroke.closed:
        raise RefusedError("the stroke is closed: draw it from one place of the curve to another")
    part = _find_part(network, sizes, stroke)
    line = network.chains[part.chain]
    if line.marked:
        raise RefusedError("a border or the seam of symmetry stays where it is")
    if part.begin == part.end:
        raise RefusedError("the stroke begins and ends at one place of the curve: draw it longer")
    way, up = (stroke.points, stroke.normals)
    if part.turned:
        way, up = way[::-1], up[::-1]
    k = np.array([part.begin, part.end]) % len(line.points)
    ends, above = line.points[k], line.normals[k]
    along = arc_length(way)
    share = (along / along[-1])[:, None]
    way = way + (1.0 - share) * (ends[0] - way[0]) + share * (ends[1] - way[-1])
    along = arc_length(way)
    edges = max(2, round(along[-1] / sizes.sampling))
    wanted = np.linspace(0.0, along[-1], edges + 1)
    up = interpolate_places(way, up, np.interp(wanted, along, np.arange(len(along))))[1]
    way, up = take_to_surface(at_lengths(way, wanted), up, surface, sizes)
    way[[0, -1]], up[[0, -1]] = ends, above
    points, normals = _splice(line, part, way, up)
    builder = NetworkBuilder(network)
    builder.reshape_chain(line.id, points, normals)
    after = builder.finish()
    before = find_crossed(network, [line.id], sizes.sampling)
    if find_crossed(after, [line.id], sizes.sampling) - before:
        raise RefusedError(
            "the new course would cross a curve, or itself: draw it as a stroke of its own, or "
            "erase what it crosses first"
        )
    return Edit.of(network, after)


def _find_part(network: Network, sizes: Sizes, stroke: SurfaceCurve) -> _Part:
    """The part of the chain that is nearest to both ends of a stroke."""
    best: _Part | None = None
    for chain, line in network.chains.items():
        of = take_chain_samples({chain: line})
        found = [
            find_nearest_place(of, stroke.points[k], stroke.normals[k], sizes.snap) for k in (0, -1)
        ]
        if found[0] is None or found[1] is None:
            continue
        distance = found[0].distance + found[1].distance
        if best is None or distance < best.distance:
            best = _part_between(line, found[0].place, found[1].place, distance, sizes, stroke)
    if best is None:
        raise RefusedError(
            "no curve is near both ends of the stroke: begin and end it on the curve to redraw"
        )
    return best


def _part_between(
    line: Chain, one: float, two: float, distance: float, sizes: Sizes, stroke: SurfaceCurve
) -> _Part:
    """The part of a chain between two places. Of a chain that is closed, with a node or without,
    there may be two: that which is nearer to the stroke."""
    n = len(line.points)
    if line.is_closed_loop:
        begin, end = round(one) % n, round(two) % n
        ways = [
            _Part(line.id, begin, begin + (end - begin) % n, False, distance),
            _Part(line.id, end, end + (begin - end) % n, True, distance),
        ]
    else:
        begin, end = (_find_sample(line, place, sizes.snap) for place in (one, two))
        both = {(begin, end)}
        if line.start == line.end:
            # The node is at either end of the chain.
            begins, ends = ({k, *((0, n - 1) if k in (0, n - 1) else ())} for k in (begin, end))
            both = {(a, b) for a in begins for b in ends if {a, b} != {0, n - 1}}
        ways = [_Part(line.id, min(a, b), max(a, b), a > b, distance) for a, b in sorted(both)]
    tree = KDTree(stroke.points)
    off = [tree.query(line.points[np.arange(way.begin, way.end + 1) % n])[0].mean() for way in ways]
    return ways[int(np.argmin(off))]


def _find_sample(line: Chain, place: float, snap: float) -> int:
    """The sample nearest to a place, or the nearer end of the chain if it is within the snap
    radius along the chain."""
    along = arc_length(line.points)
    last = len(along) - 1
    at = float(np.interp(place, np.arange(len(along)), along))
    if min(at, along[-1] - at) > snap:
        return round(place)
    return 0 if at <= along[-1] - at else last


def _splice(line: Chain, part: _Part, way: Points, up: Points) -> tuple[Points, Points]:
    """The chain's course with a way (k, 3) in the place of a part."""
    if line.is_closed_loop:
        n = len(line.points)
        rest = np.arange(part.end + 1, part.begin + n) % n
        return np.concatenate([way, line.points[rest]]), np.concatenate([up, line.normals[rest]])
    before, after = slice(part.begin), slice(part.end + 1, None)
    return (
        np.concatenate([line.points[before], way, line.points[after]]),
        np.concatenate([line.normals[before], up, line.normals[after]]),
    )


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    drawn = work.clean_stroke_here(a["points"], "the stroke", False)
    return work.keep_edit(redraw_chain(work.network, work.surface, work.state.sizes, drawn))


REDRAW = Tool(
    "redraw",
    "Redraw a part of a curve, from one place on it to another.",
    {"points": POINTS},
    _act,
    position=170,
    snaps=True,
    control=Control("r", "redraw", "redraw a part of a curve, from it back to it", brush="snap"),
)
