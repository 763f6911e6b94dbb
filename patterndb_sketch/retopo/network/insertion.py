"""Insert a curve that may cross the network and itself: both are cut where they cross.

A curve that crosses itself is inserted in parts that do not (:func:`insert_curve`). Each part takes
one walk (:class:`_PlainCurve`): its stops are found, the nodes at which it meets the network, for
which open ends are led to it and chains are cut; then new chains connect stop to stop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.network.attaching import Gap, Gaps, SeparatedError
from patterndb_sketch.retopo.network.builder import AtNode, End, Free, NetworkBuilder
from patterndb_sketch.retopo.network.crossings import (
    Crossings,
    find_crossings,
    find_hidden_crossings,
    find_self_crossings,
    order_crossings,
)
from patterndb_sketch.retopo.network.joining import AROUND, unite_nodes
from patterndb_sketch.retopo.network.samples import (
    AT_SAMPLE,
    interpolate_places,
    take_chain_samples,
)
from patterndb_sketch.retopo.network.structure import NONE, Chain, HalfChain, Node
from patterndb_sketch.retopo.tracing.curves import SurfaceCurve

#: Takes (k, 3) points with normals to the surface.
Project = Callable[[Points, Points], tuple[Points, Points]]

#: A crossing that a hand overshot is at most this many snap radii along the chain from the node.
OVERSHOT = 2.0

#: A chain is shortened, or led on, only if it is longer than this many times the radius.
LONG = 2.0


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


def insert_curve(
    builder: NetworkBuilder,
    curve: SurfaceCurve,
    start: End,
    end: End,
    near: Nearness,
    project: Project,
) -> list[int]:
    """Add a curve, cut where it crosses chains or itself; both are.

    start, end: what it is joined to; a closed curve has neither. A curve that crosses itself is
    added in parts that do not, joined smoothly: each meets the ones before as it meets any chain.
    Parts beyond marked sides are left out, and so are loose ends beyond the last crossing that are
    shorter than ``near.node``. Returns the ids of the new chains that are there at the end, none if
    nothing is left of the curve.
    """
    if curve.closed:
        return _insert_closed(builder, curve, near, project)
    line, up = curve.points, curve.normals
    round_trip = len(line) > 3 and bool((line[0] == line[-1]).all())
    last = len(line) - 1 if round_trip else len(line)
    own = find_self_crossings(line[:last], up[:last], round_trip)
    others = (
        find_crossings(line, up, False, take_chain_samples(builder.chains)).along
        if len(own)
        else own.along
    )
    bounds = [0.0, *_find_cuts(own.place, own.along, others), float(len(line) - 1)]
    made: list[int] = []
    joints: list[int] = []
    for k, (begin, finish) in enumerate(pairwise(bounds)):
        points, normals = _cut_out(line, up, begin, finish)
        ends, reach = [_update_end(builder, one) for one in (start, end)], list(near.ends)
        if k > 0:
            ends[0], reach[0] = AtNode(builder.node_now(joints[-1])), near.node
        if k < len(bounds) - 2:
            joints.append(builder.add_node(points[-1], normals[-1]))
            ends[1], reach[1] = AtNode(joints[-1]), near.node
        one, two = (
            NONE if isinstance(joint, Free) else builder.end_node(joint, points[-j], normals[-j])
            for j, joint in enumerate(ends)
        )
        nearness = replace(near, ends=(reach[0], reach[1]))
        along = arc_length(points)
        part = _PlainCurve(builder, points, normals, along, (one, two), nearness, project)
        made += part.insert()
    return _join_parts(builder, made, joints)


def _insert_closed(
    builder: NetworkBuilder, curve: SurfaceCurve, near: Nearness, project: Project
) -> list[int]:
    """The same of a closed curve: it is opened where it is furthest from all that it meets, and
    joined again in the end."""
    line, up = curve.points, curve.normals
    own = find_self_crossings(line, up, True)
    others = find_crossings(line, up, True, take_chain_samples(builder.chains))
    ends = _find_open_ends(builder, line, up, near.open)
    places = np.sort(np.concatenate([own.along, own.place, others.along, ends]))
    if not len(places):
        return [builder.add_loop(line, up)]
    gaps = np.diff(places, append=places[0] + len(line))
    widest = int(np.argmax(gaps))
    begin = float((places[widest] + 0.5 * gaps[widest]) % len(line))
    around = np.concatenate([line, line, line[:1]]), np.concatenate([up, up, up[:1]])
    points, normals = _cut_out(*around, begin, begin + len(line))
    joint = builder.add_node(points[0], normals[0])
    at, nearness = AtNode(joint), replace(near, ends=(near.node, near.node))
    made = insert_curve(builder, SurfaceCurve(points, normals, False), at, at, nearness, project)
    return _join_parts(builder, made, [joint])


def _find_open_ends(
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


def _update_end(builder: NetworkBuilder, end: End) -> End:
    """An end whose node may have gone into another."""
    return replace(end, node=builder.node_now(end.node)) if isinstance(end, AtNode) else end


def _join_parts(builder: NetworkBuilder, made: Iterable[int], joints: Iterable[int]) -> list[int]:
    """Join the parts of one curve; what its chains are then."""
    now = builder.pieces(made)
    for joint in map(builder.node_now, joints):
        if joint in builder.nodes:
            parts = {half >> 1 for half in builder.nodes[joint].ends}
            merged = builder.merge(joint)
            if merged is not None:
                now = (now - parts) | {merged}
    return sorted(now)


def _find_cuts(
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


def _cut_out(line: Points, up: Points, begin: float, finish: float) -> tuple[Points, Points]:
    """The polyline from one place, in samples, to another."""
    inner = np.arange(int(np.floor(begin)) + 1, int(np.ceil(finish)))
    ends, above = interpolate_places(line, up, np.array([begin, finish]))
    return (
        np.concatenate([ends[:1], line[inner], ends[1:]]),
        np.concatenate([above[:1], up[inner], above[1:]]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """A node that the curve passes, or ends at; NONE where it ends loose.

    begins, ends: arc length along the curve where it gets there, and where it leaves.
    before, after: the gaps it comes from and goes to, if known.
    outside: are the parts before and after it beyond a marked side?
    stem: of an open end that was led to the curve, the half-chain that leaves it; else NONE.
    """

    node: int
    begins: float
    ends: float
    before: Gap | None = None
    after: Gap | None = None
    outside: tuple[bool, bool] = (False, False)
    stem: HalfChain = NONE

    def unite(self, other: Stop) -> Stop:
        """One stop of this and the next."""
        outside = self.outside[0], other.outside[1]
        return Stop(self.node, self.begins, other.ends, self.before, other.after, outside)


@dataclass(frozen=True, slots=True, eq=False)
class _PlainCurve:
    """An open curve that does not cross itself, on its way into a network.

    points, normals: (n, 3). along: (n,) its arc length. joints: the nodes that its start and its
    end are joined to, or NONE.
    """

    builder: NetworkBuilder
    points: Points
    normals: Points
    along: NDArray[np.float64]
    joints: tuple[int, int]
    near: Nearness
    project: Project

    def insert(self) -> list[int]:
        """Find the stops, and connect each with the next; returns the ids of the new chains."""
        led = self._lead_open_ends()
        stops = self._gather(self._find_stops(led))
        made: list[int] = []
        for one, two in self._pair(stops):
            made += self._connect(one, two)
        self._straighten(led)
        return made

    @property
    def length(self) -> float:
        return float(self.along[-1])

    def _measure(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) arc lengths of places in samples."""
        return np.interp(places, np.arange(len(self.along)), self.along)

    # Open ends near to the curve

    def _lead_open_ends(self) -> list[Stop]:
        """Lead the open ends within ``near.open`` of the curve to it; the stops there.

        Nodes that its own ends are joined to, and what is within the radius of its ends, are left
        to these. A chain that crosses the curve within the radius of its open end is shortened to
        the crossing; another is led on to the nearest point of the curve, if nothing is between.
        Marked chains stay.
        """
        builder, reach = self.builder, self.near.open
        found: list[Stop] = []
        if reach <= 0.0:
            return found
        low, high = self.points.min(axis=0) - reach, self.points.max(axis=0) + reach
        for node in sorted(builder.nodes):
            at = builder.nodes[node]
            if not at.open or node in self.joints:
                continue
            if (at.point < low).any() or (at.point > high).any():
                continue
            chain = builder.chains[at.ends[0] >> 1]
            if chain.marked or chain.length <= LONG * reach:
                continue
            place = self._find_meeting(at)
            if place is None:
                continue
            s = float(self._measure(np.array(place)))
            if reach < s < self.length - reach and self._lead_end(at, place):
                found.append(Stop(node, s, s, stem=at.ends[0]))
        return found

    def _find_meeting(self, at: Node) -> float | None:
        """The place on the curve that an open end belongs to: where its chain crosses it first,
        within the radius, else the nearest within it. None if there is none."""
        line, up, reach = self.points, self.normals, self.near.open
        stem = at.ends[0]
        chain = self.builder.chains[stem >> 1]
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

    def _lead_end(self, at: Node, place: float) -> bool:
        """Let the chain of an open end run to a place of the curve, if nothing is between; did
        it?"""
        builder, stem = self.builder, at.ends[0]
        feet, above = interpolate_places(self.points, self.normals, np.array([place]))
        foot, normal = feet[0], above[0]
        chain = builder.chains[stem >> 1]
        points, normals = chain.directed(stem)
        # What is beyond the point, seen along the chain, goes.
        keep = int(np.argmin(np.linalg.norm(points - foot, axis=1)))
        last = len(points) - 1
        while keep < last and (points[keep + 1] - points[keep]) @ (points[keep] - foot) < 0:
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
            led[1:], above[1:] = self.project(led[1:], above[1:])
        points, normals = np.concatenate([led, points]), np.concatenate([above, normals])
        others = {c: other for c, other in builder.chains.items() if c != chain.id}
        new = slice(len(led) + 1)
        if keep == 0 and len(
            find_crossings(points[new], normals[new], False, take_chain_samples(others))
        ):
            return False
        builder.set_node(replace(at, point=foot.copy(), normal=normal.copy()))
        if stem & 1:
            points, normals = points[::-1], normals[::-1]
        builder.reshape_chain(chain.id, points, normals)
        return True

    def _straighten(self, led: Iterable[Stop]) -> None:
        """Make the open ends T-junctions: the curve passes them straight on the side without a
        stem."""
        for one in led:
            at = self.builder.nodes.get(self.builder.node_now(one.node))
            if at is None or at.valence != 3:
                continue
            far = (at.ends.index(self.builder.half_now(one.stem)) + 1) % 3
            flags = tuple(k != far for k in range(3))
            self.builder.set_node(replace(at, corner_flags=flags, cut=True))

    # Where the curve meets the network

    def _find_stops(self, led: list[Stop]) -> list[Stop]:
        """All stops in order: the joints, the open ends that were led to the curve, and where it
        crosses chains, which are cut."""
        stops = sorted([*self._cross_chains(led), *led], key=lambda stop: stop.begins)
        if self.joints[0] != NONE:
            stops.insert(0, Stop(self.joints[0], 0.0, 0.0))
        if self.joints[1] != NONE:
            stops.append(Stop(self.joints[1], self.length, self.length))
        return stops

    def _cross_chains(self, led: list[Stop]) -> list[Stop]:
        """Cut the chains where the curve crosses them; it does not cross those that were led to it
        at their open ends."""
        builder, near = self.builder, self.near.node
        found = find_crossings(self.points, self.normals, False, take_chain_samples(builder.chains))
        stems = {stop.stem for stop in led}
        if stems:
            elsewhere = [
                k
                for k in range(len(found))
                if not any(
                    half in stems and off <= near
                    for off, _, half in _measure_ends(
                        builder.chains[int(found.chain[k])], float(found.place[k])
                    )
                )
            ]
            found = found.select(elsewhere)
        if not len(found):
            return []
        at = self._measure(found.along)
        crossed = [
            2 * int(chain) + (not rightward)
            for chain, rightward in zip(found.chain, found.rightward, strict=True)
        ]
        order = order_crossings(builder.nodes, builder.chains, at, crossed, near)
        if order != sorted(order):
            found = found.select(order)
            at = np.maximum.accumulate(at[order])
        points, normals = self._place_crossings(found)
        limits = self._find_overshoots(found, at, points)
        return [
            self._stop_at(found, k, float(at[k]), (points[k], normals[k]), limits)
            for k in range(len(found))
        ]

    def _place_crossings(self, found: Crossings) -> tuple[Points, Points]:
        """(k, 3) points and normals of the surface halfway between the curve and the chains."""
        points, normals = interpolate_places(self.points, self.normals, found.along)
        for k, chain in enumerate(found.chain):
            old = self.builder.chains[int(chain)]
            there, above = interpolate_places(old.points, old.normals, found.place[k : k + 1])
            points[k] = 0.5 * (points[k] + there[0])
            normals[k] = units((normals[k] + above[0])[None])[0]
        return self.project(points, normals)

    def _find_overshoots(
        self, found: Crossings, at: NDArray[np.float64], points: Points
    ) -> dict[HalfChain, float]:
        """For half-chains that leave a node which the curve is joined to: up to where, along them,
        crossings are at the node, for a hand overshoots."""
        builder = self.builder
        limits: dict[HalfChain, float] = {}
        for k in range(len(found)):
            chain, place = builder.locate(int(found.chain[k]), float(found.place[k]))
            ends = _measure_ends(builder.chains[chain], place)
            off_ends = (at[k], self.length - at[k])
            for joint, off, reach in zip(self.joints, off_ends, self.near.ends, strict=True):
                if joint == NONE or off > reach:
                    continue
                if np.linalg.norm(builder.nodes[joint].point - points[k]) > reach:
                    continue
                far, half = min(
                    ((far, half) for far, node, half in ends if node == joint),
                    default=(np.inf, NONE),
                )
                if far <= OVERSHOT * reach:
                    limits[half] = max(limits.get(half, 0.0), far)
        return limits

    def _stop_at(
        self,
        found: Crossings,
        k: int,
        along: float,
        at: tuple[Points, Points],
        limits: dict[HalfChain, float],
    ) -> Stop:
        """The stop at a crossing: at the end of the chain if that is near, else where it is cut.

        at: (3,) point and normal for a new node.
        """
        builder = self.builder
        chain, place = builder.locate(int(found.chain[k]), float(found.place[k]))
        line = builder.chains[chain]
        ends = _measure_ends(line, place)
        now = {builder.half_now(half): limit for half, limit in limits.items()}
        close = [end for end in ends if end[0] <= now.get(end[2], 0.0)]
        close = close or [end for end in ends if end[0] <= self.near.node]
        if close:
            off, node, half = min(close)
        else:
            off, node = 0.0, builder.cut_chain(chain, place, at)
            pieces = builder.pieces([chain])
            half = next(h for h in builder.nodes[node].ends if h >> 1 in pieces)
        # From the left to the right of the half-chain that leaves the node?
        leaving = bool(found.rightward[k]) == (half & 1 == 0)
        left, right = line.marks if found.rightward[k] else line.marks[::-1]
        gaps = Gap(half, leaving, off), Gap(half, not leaving, off)
        return Stop(node, along, along, *gaps, (left != "", right != ""))

    def _gather(self, stops: list[Stop]) -> list[Stop]:
        """Neighbouring stops at one node, with next to no curve between them, as one."""
        near = self.near
        result: list[Stop] = []
        for k, stop in enumerate(stops):
            if result and result[-1].node == stop.node:
                gap = stop.begins - result[-1].ends
                limit = AROUND * near.node
                if gap < 0.5 * self.length:
                    if self.joints[0] != NONE and len(result) == 1:
                        limit = max(limit, near.ends[0])
                    if self.joints[1] != NONE and k == len(stops) - 1:
                        limit = max(limit, near.ends[1])
                if gap <= limit:
                    result[-1] = result[-1].unite(stop)
                    continue
            result.append(stop)
        return result

    # From stop to stop

    def _pair(self, stops: list[Stop]) -> list[tuple[Stop, Stop]]:
        """The parts of the curve: from stop to stop, and from and to its loose ends."""
        start, end = Stop(NONE, 0.0, 0.0), Stop(NONE, self.length, self.length)
        if not stops:
            return [(start, end)]
        found = list(pairwise(stops))
        if self.joints[0] == NONE and stops[0].begins > self.near.node:
            found.insert(0, (start, stops[0]))
        if self.joints[1] == NONE and self.length - stops[-1].ends > self.near.node:
            found.append((stops[-1], end))
        return found

    def _connect(self, a: Stop, b: Stop) -> list[int]:
        """Add the part of the curve between two stops; nothing beyond a marked side.

        Nodes of two stops that are no further apart than ``near.node`` become one, if they can.
        Raises SeparatedError if what is between is further off than ``near.open``.
        """
        builder, near = self.builder, self.near.node
        if a.outside[1] or b.outside[0]:
            return []
        gaps = a.after, b.before
        if NONE not in (a.node, b.node) and b.begins - a.ends <= near:
            one, two = builder.node_now(a.node), builder.node_now(b.node)
            if one == two or unite_nodes(builder, one, two, gaps, near):
                return []
        points, normals, ends = self._cut_between(a, b)
        if (points[0] == points[-1]).all() and len(points) < 4:
            return []
        try:
            return [builder.add_chain(points, normals, *ends, gaps=gaps)]
        except SeparatedError:
            made: list[int] = []
            if isinstance(ends[0], AtNode) and isinstance(ends[1], AtNode):
                nodes = ends[0].node, ends[1].node
                made = self._add_across((points, normals), nodes, gaps)
            if not made:
                raise
            return made

    def _cut_between(self, a: Stop, b: Stop) -> tuple[Points, Points, tuple[End, End]]:
        """(n, 3) points and normals of the part between two stops, and what its ends are joined
        to. Samples that the nodes have come past are left out."""
        along, builder = self.along, self.builder
        step = self.length / (len(along) - 1)
        inner = np.flatnonzero((along > a.ends) & (along < b.begins))
        edge = np.interp([a.ends, b.begins], along, np.arange(len(along)))
        points, normals = interpolate_places(self.points, self.normals, edge)
        ends: list[End] = [Free(), Free()]
        for k, stop in enumerate((a, b)):
            off = 0.0
            if stop.node != NONE:
                node = builder.nodes[builder.node_now(stop.node)]
                off = float(np.linalg.norm(points[k] - node.point))
                points[k], normals[k] = node.point, node.normal
                ends[k] = AtNode(node.id)
            reach = max(AT_SAMPLE * step, off)
            close = np.linalg.norm(self.points[inner] - points[k], axis=1) < reach
            run = close if k == 0 else close[::-1]
            drop = len(run) if run.all() else int(np.argmin(run))
            inner = inner[drop:] if k == 0 else inner[: len(inner) - drop]
        return (
            np.concatenate([points[:1], self.points[inner], points[1:]]),
            np.concatenate([normals[:1], self.normals[inner], normals[1:]]),
            (ends[0], ends[1]),
        )

    def _add_across(
        self, line: tuple[Points, Points], nodes: tuple[int, int], gaps: Gaps
    ) -> list[int]:
        """Add a part (n, 3) from a node to another across what lies over it; none if there is no
        way."""
        builder = self.builder
        made: list[int] = []
        begin, at, after = 0, nodes[0], gaps[0]
        hidden = find_hidden_crossings(
            builder.nodes, builder.chains, line[0], nodes, self.near.open
        )
        for half, place, k in hidden:
            chain, place = builder.locate(half >> 1, place)
            segments = builder.chains[chain].segments
            node = builder.cut_chain(chain, place)
            # At an end of the chain, the half-chain that leaves it there.
            leaving = builder.nodes[node].ends[0]
            if chain in builder.chains:
                leaving = 2 * chain + int(2.0 * place > segments)
            left = (leaving ^ half) & 1 == 0
            finish = max(begin, int(k))
            around = after, Gap(leaving, left)
            made += self._add_step(line, (begin, finish), (at, node), around)
            begin, at, after = finish, node, Gap(leaving, not left)
        if not hidden:
            return []
        part = begin, len(line[0])
        return made + self._add_step(line, part, (at, nodes[1]), (after, gaps[1]))

    def _add_step(
        self,
        line: tuple[Points, Points],
        part: tuple[int, int],
        nodes: tuple[int, int],
        gaps: Gaps,
    ) -> list[int]:
        """Add the samples of a part that are strictly between two, from a node to another."""
        builder, near = self.builder, self.near.node
        one, two = (builder.nodes[builder.node_now(node)] for node in nodes)
        if one.id == two.id or unite_nodes(builder, one.id, two.id, gaps, near):
            return []
        inner = slice(part[0] + 1, max(part[0] + 1, min(part[1], len(line[0]) - 1)))
        points = np.concatenate([one.point[None], line[0][inner], two.point[None]])
        normals = np.concatenate([one.normal[None], line[1][inner], two.normal[None]])
        if not (points[1:] != points[:-1]).any():
            return []
        return [builder.add_chain(points, normals, AtNode(one.id), AtNode(two.id), gaps=gaps)]


def _measure_ends(chain: Chain, place: float) -> list[tuple[float, int, HalfChain]]:
    """The two ends of a chain: how far a place is from each along it, its node, and the half-chain
    that leaves it."""
    if chain.is_closed_loop:
        return []
    along = arc_length(chain.points)
    at = float(np.interp(place, np.arange(len(along)), along))
    return [(at, chain.start, 2 * chain.id), (float(along[-1]) - at, chain.end, 2 * chain.id + 1)]
