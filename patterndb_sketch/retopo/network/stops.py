"""Find where a curve that is added meets the network; open ends that it passes are joined to it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.network.attaching import Gap
from patterndb_sketch.retopo.network.builder import NetworkBuilder
from patterndb_sketch.retopo.network.crossings import Crossings, find_crossings, order_crossings
from patterndb_sketch.retopo.network.samples import interpolate_places, take_chain_samples
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node

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


def make_stops(
    builder: NetworkBuilder,
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
    found = find_crossings(line, up, False, take_chain_samples(builder.chains))
    if passed:
        found = found.select(_list_elsewhere(builder, found, passed, near.node))
    if not len(found):
        return []
    at = np.interp(found.along, np.arange(len(along)), along)
    crossed = [
        2 * int(chain) + (not rightward)
        for chain, rightward in zip(found.chain, found.rightward, strict=True)
    ]
    order = order_crossings(builder.nodes, builder.chains, at, crossed, near.node)
    if order != sorted(order):
        found = found.select(order)
        at = np.maximum.accumulate(at[order])
    points, normals = interpolate_places(line, up, found.along)
    for k, chain in enumerate(found.chain):
        old = builder.chains[int(chain)]
        there, above = interpolate_places(old.points, old.normals, found.place[k : k + 1])
        points[k] = 0.5 * (points[k] + there[0])
        normals[k] = units((normals[k] + above[0])[None])[0]
    points, normals = project(points, normals)
    limits = _find_overshoots(builder, found, at, float(along[-1]), points, joints, near.ends)
    stops: list[Stop] = []
    for k in range(len(found)):
        chain, place = builder.locate(int(found.chain[k]), float(found.place[k]))
        line_of = builder.chains[chain]
        near_end = _find_near_end(builder, line_of, place, near.node, limits)
        if near_end is None:
            node = builder.cut_chain(chain, place, (points[k], normals[k]))
            pieces = builder.pieces([chain])
            half = next(h for h in builder.nodes[node].ends if h >> 1 in pieces)
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


def _list_elsewhere(
    builder: NetworkBuilder, found: Crossings, passed: Collection[HalfChain], near: float
) -> list[int]:
    """The numbers of the crossings that are not where one of these half-chains begins."""
    elsewhere: list[int] = []
    for k in range(len(found)):
        ends = _measure_ends(builder.chains[int(found.chain[k])], float(found.place[k]))
        if not any(half in passed and off <= near for off, _, half in ends):
            elsewhere.append(k)
    return elsewhere


def _measure_ends(chain: Chain, place: float) -> list[tuple[float, int, HalfChain]]:
    """The two ends of a chain: how far a place is from each along it, its node, and the half-chain
    that leaves it."""
    if chain.loose:
        return []
    along = arc_length(chain.points)
    at = float(np.interp(place, np.arange(len(along)), along))
    return [(at, chain.start, 2 * chain.id), (float(along[-1]) - at, chain.end, 2 * chain.id + 1)]


def _find_overshoots(
    builder: NetworkBuilder,
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
        chain, place = builder.locate(int(found.chain[k]), float(found.place[k]))
        ends = _measure_ends(builder.chains[chain], place)
        for joint, off, reach in zip(joints, (at[k], whole - at[k]), reaches, strict=True):
            if joint is None or off > reach:
                continue
            if np.linalg.norm(builder.nodes[joint].point - points[k]) > reach:
                continue
            far, half = min(
                ((far, half) for far, node, half in ends if node == joint), default=(np.inf, -1)
            )
            if far <= OVERSHOT * reach:
                limits[half] = max(limits.get(half, 0.0), far)
    return limits


def _find_near_end(
    builder: NetworkBuilder, chain: Chain, place: float, near: float, limits: dict[HalfChain, float]
) -> tuple[float, int, HalfChain] | None:
    """The end of a chain that a crossing is at: how far off it is, the node, and the half-chain
    that leaves it."""
    now = {builder.half_now(half): limit for half, limit in limits.items()}
    ends = _measure_ends(chain, place)
    close = [end for end in ends if end[0] <= now.get(end[2], 0.0)]
    close = close or [end for end in ends if end[0] <= near]
    return min(close, default=None)


#: A chain is shortened, or led on, only if it is longer than this many times the radius.
LONG = 2.0


@dataclass(frozen=True, slots=True)
class PassedEnd:
    """An open end on a curve. stem: the half-chain that leaves it. at: arc length on the curve."""

    node: int
    stem: HalfChain
    at: float

    def stop(self) -> Stop:
        return Stop(self.node, self.at, self.at)


def join_passed_ends(
    builder: NetworkBuilder,
    line: Points,
    up: Points,
    along: NDArray[np.float64],
    joints: Iterable[int | None],
    reach: float,
    project: Project,
) -> list[PassedEnd]:
    """Lead the open ends within a radius of a curve (n, 3) to it.

    along: (n,) its arc length. joints: nodes that its own ends are joined to; they, and what is
    within the radius of its ends, are left to these. A chain that crosses the curve within the
    radius of its open end is shortened to the crossing; another is led on to the nearest point of
    the curve, if nothing is between. Marked chains stay.
    """
    found: list[PassedEnd] = []
    if reach <= 0.0:
        return found
    low, high = line.min(axis=0) - reach, line.max(axis=0) + reach
    for node in sorted(builder.nodes):
        at = builder.nodes[node]
        if not at.open or node in joints or (at.point < low).any() or (at.point > high).any():
            continue
        stem = at.ends[0]
        chain = builder.chains[stem >> 1]
        if chain.marked or chain.length <= LONG * reach:
            continue
        place = _find_meeting(builder, line, up, along, at, reach)
        if place is None:
            continue
        s = float(np.interp(place, np.arange(len(along)), along))
        if not reach < s < along[-1] - reach:
            continue
        foot, normal = interpolate_places(line, up, np.array([place]))
        if _lead_end(builder, at, foot[0], normal[0], project):
            found.append(PassedEnd(node, stem, s))
    return found


def find_open_ends(
    builder: NetworkBuilder, line: Points, up: Points, reach: float
) -> NDArray[np.float64]:
    """(k,) the samples of a curve (n, 3) that are nearest to open ends within a radius."""
    found: list[float] = []
    for at in builder.nodes.values():
        if at.open:
            away = np.where(up @ at.normal > 0.0, np.linalg.norm(line - at.point, axis=1), np.inf)
            k = int(np.argmin(away))
            if away[k] <= reach:
                found.append(float(k))
    return np.array(found)


def straighten_passed(builder: NetworkBuilder, passed: Iterable[PassedEnd]) -> None:
    """Make the nodes T-junctions: the curve passes them straight on the side without a stem."""
    for one in passed:
        at = builder.nodes.get(builder.node_now(one.node))
        if at is None or at.valence != 3:
            continue
        far = (at.ends.index(builder.half_now(one.stem)) + 1) % 3
        flags = tuple(k != far for k in range(3))
        builder.set_node(replace(at, flagged=flags, cut=True))


def _find_meeting(
    builder: NetworkBuilder,
    line: Points,
    up: Points,
    along: NDArray[np.float64],
    at: Node,
    reach: float,
) -> float | None:
    """The place on the curve that an open end belongs to: where its chain crosses it first,
    within the radius, else the nearest within it. None if there is none."""
    stem = at.ends[0]
    chain = builder.chains[stem >> 1]
    found = find_crossings(line, up, False, take_chain_samples({chain.id: chain}))
    if len(found):
        whole = arc_length(chain.points)
        off = np.interp(found.place, np.arange(len(whole)), whole)
        off = whole[-1] - off if stem & 1 else off
        near = np.flatnonzero(off <= reach)
        if len(near):
            # Of several, the one that leaves least of the chain beyond the curve.
            return float(found.along[near[np.argmax(off[near])]])
    steps = np.diff(line, axis=0)
    sizes = np.einsum("nc,nc->n", steps, steps)
    towards = np.einsum("nc,nc->n", at.point - line[:-1], steps)
    share = np.clip(towards / np.maximum(sizes, np.finfo(np.float64).tiny), 0.0, 1.0)
    away = np.linalg.norm(line[:-1] + share[:, None] * steps - at.point, axis=1)
    away[(up[:-1] + up[1:]) @ at.normal <= 0.0] = np.inf
    k = int(np.argmin(away))
    return float(k + share[k]) if away[k] <= reach else None


def _lead_end(
    builder: NetworkBuilder, at: Node, foot: Points, normal: Points, project: Project
) -> bool:
    """Let the chain of an open end run to a point (3,), if nothing is between; did it?"""
    stem = at.ends[0]
    chain = builder.chains[stem >> 1]
    points, normals = chain.directed(stem)
    # What is beyond the point, seen along the chain, goes.
    keep = int(np.argmin(np.linalg.norm(points - foot, axis=1)))
    while keep < len(points) - 1 and (points[keep + 1] - points[keep]) @ (points[keep] - foot) < 0:
        keep += 1
    points, normals = points[keep:], normals[keep:]
    step = chain.length / chain.segments
    gap = float(np.linalg.norm(points[0] - foot))
    if len(points) < 3:
        return False
    share = np.linspace(0.0, 1.0, max(1, round(gap / step)) + 1)[:-1, None]
    led = (1.0 - share) * foot + share * points[0]
    above = units((1.0 - share) * normal + share * normals[0])
    if len(led) > 1:
        led[1:], above[1:] = project(led[1:], above[1:])
    points, normals = np.concatenate([led, points]), np.concatenate([above, normals])
    others = take_chain_samples({c: other for c, other in builder.chains.items() if c != chain.id})
    new = slice(len(led) + 1)
    if keep == 0 and len(find_crossings(points[new], normals[new], False, others)):
        return False
    builder.set_node(replace(at, point=foot.copy(), normal=normal.copy()))
    if stem & 1:
        points, normals = points[::-1], normals[::-1]
    builder.reshape_chain(chain.id, points, normals)
    return True
