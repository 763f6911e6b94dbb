"""Where a curve that is added meets the network."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.network.contracting import AROUND
from patterndb_sketch.retopo.network.crossings import Crossings, crossings
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.gaps import Gap
from patterndb_sketch.retopo.network.passing import in_order
from patterndb_sketch.retopo.network.samples import samples_of
from patterndb_sketch.retopo.network.structure import Chain, HalfChain

#: Takes (k, 3) points with normals to the surface.
Project = Callable[[Points, Points], tuple[Points, Points]]

#: A crossing that a hand overshot is at most this many snap radii along the chain from the node.
OVERSHOT = 2.0


@dataclass(frozen=True, slots=True)
class Nearness:
    """What counts as the same place.

    node: a crossing this near to the end of a chain, along it, is at the node there.
    ends: the same for the nodes that the curve's start and end are joined to, where the crossing
          must be this near to them along the curve, too: a hand overshoots.
    open: open ends this near to the curve are joined to it.
    """

    node: float
    ends: tuple[float, float]
    open: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """A node that the curve passes, or ends at.

    begins, ends: arc length along the curve where it gets there, and where it leaves.
    before, after: the gaps it comes from and goes to, if known.
    outside: are the parts before and after it beyond a marked side?
    """

    node: int
    begins: float
    ends: float
    before: Gap | None = None
    after: Gap | None = None
    outside: tuple[bool, bool] = (False, False)


def stops_of(
    draft: Draft,
    line: Points,
    up: Points,
    along: NDArray[np.float64],
    joints: tuple[int | None, int | None],
    near: Nearness,
    project: Project,
    passed: Collection[HalfChain] = (),
) -> list[Stop]:
    """Cut the chains where the curve crosses them.

    passed: half-chains that leave nodes on the curve: it does not cross them there.
    """
    found = crossings(line, up, False, samples_of(draft.chains))
    if passed:
        found = found.taken(_elsewhere(draft, found, passed, near.node))
    if not len(found):
        return []
    at = np.interp(found.along, np.arange(len(along)), along)
    crossed = [
        2 * int(chain) + (not rightward)
        for chain, rightward in zip(found.chain, found.rightward, strict=True)
    ]
    order = in_order(draft.nodes, draft.chains, at, crossed, near.node)
    if order != sorted(order):
        found = found.taken(order)
        at = np.maximum.accumulate(at[order])
    points, normals = between(line, up, found.along)
    for k, chain in enumerate(found.chain):
        old = draft.chains[int(chain)]
        there, above = between(old.points, old.normals, found.place[k : k + 1])
        points[k] = 0.5 * (points[k] + there[0])
        normals[k] = units((normals[k] + above[0])[None])[0]
    points, normals = project(points, normals)
    limits = _overshoots(draft, found, at, float(along[-1]), points, joints, near.ends)
    stops: list[Stop] = []
    for k in range(len(found)):
        chain, place = draft.located(int(found.chain[k]), float(found.place[k]))
        line_of = draft.chains[chain]
        near_end = _near_end(draft, line_of, place, near.node, limits)
        if near_end is None:
            node = draft.cut_chain(chain, place, (points[k], normals[k]))
            pieces = draft.pieces([chain])
            half = next(h for h in draft.nodes[node].ends if h >> 1 in pieces)
            off = 0.0
        else:
            off, node, half = near_end
        # From the left to the right of the half-chain that leaves the node?
        leaving = bool(found.rightward[k]) == (half & 1 == 0)
        marks = line_of.marks if found.rightward[k] else line_of.marks[::-1]
        stops.append(
            Stop(
                node,
                float(at[k]),
                float(at[k]),
                Gap(half, leaving, off),
                Gap(half, not leaving, off),
                (marks[0] != "", marks[1] != ""),
            )
        )
    return stops


def _elsewhere(
    draft: Draft, found: Crossings, passed: Collection[HalfChain], near: float
) -> list[int]:
    """The numbers of the crossings that are not where one of these half-chains begins."""
    elsewhere: list[int] = []
    for k in range(len(found)):
        ends = _ends(draft.chains[int(found.chain[k])], float(found.place[k]))
        if not any(half in passed and off <= near for off, _, half in ends):
            elsewhere.append(k)
    return elsewhere


def _ends(chain: Chain, place: float) -> list[tuple[float, int, HalfChain]]:
    """The two ends of a chain: how far a place is from each along it, its node, and the half-chain
    that leaves it."""
    if chain.loose:
        return []
    along = arc_length(chain.points)
    at = float(np.interp(place, np.arange(len(along)), along))
    return [(at, chain.start, 2 * chain.id), (float(along[-1]) - at, chain.end, 2 * chain.id + 1)]


def _overshoots(
    draft: Draft,
    found: Crossings,
    at: NDArray[np.float64],
    whole: float,
    points: Points,
    joints: tuple[int | None, int | None],
    reaches: tuple[float, float],
) -> dict[HalfChain, float]:
    """For half-chains that leave a node which the curve is joined to: up to where, along them,
    crossings are at the node, for a hand overshoots."""
    limits: dict[HalfChain, float] = {}
    for k in range(len(found)):
        chain, place = draft.located(int(found.chain[k]), float(found.place[k]))
        ends = _ends(draft.chains[chain], place)
        for joint, off, reach in zip(joints, (at[k], whole - at[k]), reaches, strict=True):
            if joint is None or off > reach:
                continue
            if np.linalg.norm(draft.nodes[joint].point - points[k]) > reach:
                continue
            far, half = min(
                ((far, half) for far, node, half in ends if node == joint), default=(np.inf, -1)
            )
            if far <= OVERSHOT * reach:
                limits[half] = max(limits.get(half, 0.0), far)
    return limits


def _near_end(
    draft: Draft, chain: Chain, place: float, near: float, limits: dict[HalfChain, float]
) -> tuple[float, int, HalfChain] | None:
    """The end of a chain that a crossing is at: how far off it is, the node, and the half-chain
    that leaves it."""
    now = {draft.half_now(half): limit for half, limit in limits.items()}
    ends = _ends(chain, place)
    close = [end for end in ends if end[0] <= now.get(end[2], 0.0)]
    close = close or [end for end in ends if end[0] <= near]
    return min(close, default=None)


def _together(one: Stop, two: Stop) -> Stop:
    outside = (one.outside[0], two.outside[1])
    return Stop(one.node, one.begins, two.ends, one.before, two.after, outside)


def gathered(
    stops: list[Stop], near: Nearness, joined: tuple[bool, bool], whole: float
) -> list[Stop]:
    """Neighbouring stops at one node, with next to no curve between them, as one."""
    result: list[Stop] = []
    for k, stop in enumerate(stops):
        if result and result[-1].node == stop.node:
            between = stop.begins - result[-1].ends
            limit = AROUND * near.node
            if between < 0.5 * whole:
                if joined[0] and len(result) == 1:
                    limit = max(limit, near.ends[0])
                if joined[1] and k == len(stops) - 1:
                    limit = max(limit, near.ends[1])
            if between <= limit:
                result[-1] = _together(result[-1], stop)
                continue
        result.append(stop)
    return result


def between(points: Points, normals: Points, places: NDArray[np.float64]) -> tuple[Points, Points]:
    """(k, 3) points and normals of a polyline at places in samples; a closed one goes round."""
    k = np.floor(places).astype(np.int64)
    share = (places - k)[:, None]
    n = len(points)
    one, two = k % n, np.where(share[:, 0] > 0.0, k + 1, k) % n
    at = (1.0 - share) * points[one] + share * points[two]
    return at, units((1.0 - share) * normals[one] + share * normals[two])
