"""A curve that may cross the network and itself becomes chains: both are cut where they cross."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.network.crossings import crossings, self_crossings
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.ends import AtNode, End, Free
from patterndb_sketch.retopo.network.passedends import open_places, passed_ends, straightened
from patterndb_sketch.retopo.network.pieces import pairs, piece
from patterndb_sketch.retopo.network.samples import samples_of
from patterndb_sketch.retopo.network.stops import (
    Nearness,
    Project,
    Stop,
    between,
    gathered,
    stops_of,
)


def weave(
    draft: Draft,
    line: Points,
    up: Points,
    start: End,
    end: End,
    near: Nearness,
    project: Project,
) -> list[int]:
    """Add an open curve (n, 3), cut where it crosses chains or itself; both are.

    A curve that crosses itself is added in parts that do not, joined smoothly: each meets the
    ones before as it meets any chain. Parts beyond marked sides are left out, and so are loose
    ends beyond the last crossing that are shorter than ``near.node``. Returns the ids of
    the new chains that are there at the end, none if nothing is left of the curve.
    """
    round_trip = len(line) > 3 and bool((line[0] == line[-1]).all())
    last = len(line) - 1 if round_trip else len(line)
    own = self_crossings(line[:last], up[:last], round_trip)
    made: list[int] = []
    joints: list[int] = []
    others = crossings(line, up, False, samples_of(draft.chains)).along if len(own) else own.along
    bounds = [0.0, *_cuts(own.place, own.along, others), float(len(line) - 1)]
    for k, (begin, finish) in enumerate(pairwise(bounds)):
        points, normals = _part(line, up, begin, finish)
        one, two = _now(draft, start), _now(draft, end)
        reach = list(near.ends)
        if k > 0:
            one, reach[0] = AtNode(draft.node_now(joints[-1])), near.node
        if k < len(bounds) - 2:
            joints.append(draft.add_node(points[-1], normals[-1]))
            two, reach[1] = AtNode(joints[-1]), near.node
        nearness = replace(near, ends=(reach[0], reach[1]))
        made += _open(draft, points, normals, one, two, nearness, project)
    return _smoothed(draft, made, joints)


def weave_closed(
    draft: Draft, line: Points, up: Points, near: Nearness, project: Project
) -> list[int]:
    """The same of a closed curve (n, 3), its first point not repeated."""
    own = self_crossings(line, up, True)
    others = crossings(line, up, True, samples_of(draft.chains))
    ends = open_places(draft, line, up, near.open)
    places = np.sort(np.concatenate([own.along, own.place, others.along, ends]))
    if not len(places):
        return [draft.add_loop(line, up)]
    # It is opened where it is furthest from all it meets, and joined again in the end.
    gaps = np.diff(places, append=places[0] + len(line))
    widest = int(np.argmax(gaps))
    begin = float((places[widest] + 0.5 * gaps[widest]) % len(line))
    around = np.concatenate([line, line, line[:1]]), np.concatenate([up, up, up[:1]])
    points, normals = _part(*around, begin, begin + len(line))
    joint = draft.add_node(points[0], normals[0])
    at = AtNode(joint)
    nearness = replace(near, ends=(near.node, near.node))
    made = weave(draft, points, normals, at, at, nearness, project)
    return _smoothed(draft, made, [joint])


def _open(
    draft: Draft,
    line: Points,
    up: Points,
    start: End,
    end: End,
    near: Nearness,
    project: Project,
) -> list[int]:
    """Add an open curve that does not cross itself."""
    along = arc_length(line)
    whole = float(along[-1])
    first = None if isinstance(start, Free) else draft.end_node(start, line[0], up[0])
    last = None if isinstance(end, Free) else draft.end_node(end, line[-1], up[-1])
    passed = passed_ends(draft, line, up, along, (first, last), near.open, project)
    stems = [one.stem for one in passed]
    stops = stops_of(draft, line, up, along, (first, last), near, project, stems)
    stops = sorted([*stops, *(one.stop() for one in passed)], key=lambda stop: stop.begins)
    if first is not None:
        stops.insert(0, Stop(first, 0.0, 0.0))
    if last is not None:
        stops.append(Stop(last, whole, whole))
    stops = gathered(stops, near, (first is not None, last is not None), whole)
    made: list[int] = []
    for one, two in pairs(stops, (first is None, last is None), whole, near.node):
        made += piece(draft, line, up, along, one, two, near)
    straightened(draft, passed)
    return made


def _now(draft: Draft, end: End) -> End:
    """An end whose node may have gone into another."""
    return replace(end, node=draft.node_now(end.node)) if isinstance(end, AtNode) else end


def _smoothed(draft: Draft, made: Iterable[int], joints: Iterable[int]) -> list[int]:
    """Join the parts of one curve; what its chains are then."""
    now = draft.pieces(made)
    for joint in map(draft.node_now, joints):
        if joint in draft.nodes:
            parts = {half >> 1 for half in draft.nodes[joint].ends}
            merged = draft.merge(joint)
            if merged is not None:
                now = (now - parts) | {merged}
    return sorted(now)


def _cuts(
    earlier: NDArray[np.float64], later: NDArray[np.float64], others: NDArray[np.float64]
) -> list[float]:
    """Places between which a curve does not cross itself, given both places of every crossing.

    Each is in the middle between the crossings next to it, with itself or with ``others``.
    """
    events = np.sort(np.concatenate([earlier, later, others]))
    order = np.argsort(later, kind="stable")
    found: list[float] = []
    begin = -1.0
    for one, two in zip(earlier[order], later[order], strict=True):
        if one >= begin:
            before = events[np.searchsorted(events, two) - 1]
            begin = float(0.5 * (before + two))
            found.append(begin)
    return found


def _part(line: Points, up: Points, begin: float, finish: float) -> tuple[Points, Points]:
    """The polyline from one place, in samples, to another."""
    inner = np.arange(int(np.floor(begin)) + 1, int(np.ceil(finish)))
    ends, above = between(line, up, np.array([begin, finish]))
    return (
        np.concatenate([ends[:1], line[inner], ends[1:]]),
        np.concatenate([above[:1], up[inner], above[1:]]),
    )
