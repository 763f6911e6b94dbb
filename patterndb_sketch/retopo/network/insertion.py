"""Insert a curve that may cross the network and itself: both are cut where they cross.

A stroke that is drawn along a curve that is there, or back along itself, crosses it at random, and
what is between are slivers: faces of two sides that lie on each other, and around the tip of a
stroke that turns back, faces of one. One curve is meant (:func:`remove_doubles`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb_sketch.retopo.network.attaching import Gap, Gaps, SeparatedError, attach_chain
from patterndb_sketch.retopo.network.builder import AtNode, End, Free, NetworkBuilder
from patterndb_sketch.retopo.network.crossings import (
    find_crossings,
    find_hidden_crossings,
    find_self_crossings,
)
from patterndb_sketch.retopo.network.faces import find_successor
from patterndb_sketch.retopo.network.samples import (
    AT_SAMPLE,
    interpolate_places,
    take_chain_samples,
)
from patterndb_sketch.retopo.network.stops import (
    Nearness,
    Project,
    Stop,
    find_open_ends,
    join_passed_ends,
    make_stops,
    straighten_passed,
)
from patterndb_sketch.retopo.network.structure import Chain, HalfChain


def insert_curve(
    builder: NetworkBuilder,
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
    own = find_self_crossings(line[:last], up[:last], round_trip)
    made: list[int] = []
    joints: list[int] = []
    others = (
        find_crossings(line, up, False, take_chain_samples(builder.chains)).along
        if len(own)
        else own.along
    )
    bounds = [0.0, *_find_cuts(own.place, own.along, others), float(len(line) - 1)]
    for k, (begin, finish) in enumerate(pairwise(bounds)):
        points, normals = _cut_out(line, up, begin, finish)
        one, two = _update_end(builder, start), _update_end(builder, end)
        reach = list(near.ends)
        if k > 0:
            one, reach[0] = AtNode(builder.node_now(joints[-1])), near.node
        if k < len(bounds) - 2:
            joints.append(builder.add_node(points[-1], normals[-1]))
            two, reach[1] = AtNode(joints[-1]), near.node
        nearness = replace(near, ends=(reach[0], reach[1]))
        made += _insert_simple_curve(builder, points, normals, one, two, nearness, project)
    return _join_parts(builder, made, joints)


def insert_closed_curve(
    builder: NetworkBuilder, line: Points, up: Points, near: Nearness, project: Project
) -> list[int]:
    """The same of a closed curve (n, 3), its first point not repeated."""
    own = find_self_crossings(line, up, True)
    others = find_crossings(line, up, True, take_chain_samples(builder.chains))
    ends = find_open_ends(builder, line, up, near.open)
    places = np.sort(np.concatenate([own.along, own.place, others.along, ends]))
    if not len(places):
        return [builder.add_loop(line, up)]
    # It is builder where it is furthest from all it meets, and joined again in the end.
    gaps = np.diff(places, append=places[0] + len(line))
    widest = int(np.argmax(gaps))
    begin = float((places[widest] + 0.5 * gaps[widest]) % len(line))
    around = np.concatenate([line, line, line[:1]]), np.concatenate([up, up, up[:1]])
    points, normals = _cut_out(*around, begin, begin + len(line))
    joint = builder.add_node(points[0], normals[0])
    at = AtNode(joint)
    nearness = replace(near, ends=(near.node, near.node))
    made = insert_curve(builder, points, normals, at, at, nearness, project)
    return _join_parts(builder, made, [joint])


def _insert_simple_curve(
    builder: NetworkBuilder,
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
    first = None if isinstance(start, Free) else builder.end_node(start, line[0], up[0])
    last = None if isinstance(end, Free) else builder.end_node(end, line[-1], up[-1])
    passed = join_passed_ends(builder, line, up, along, (first, last), near.open, project)
    stems = [one.stem for one in passed]
    stops = make_stops(builder, line, up, along, (first, last), near, project, stems)
    stops = sorted([*stops, *(one.stop() for one in passed)], key=lambda stop: stop.begins)
    if first is not None:
        stops.insert(0, Stop(first, 0.0, 0.0))
    if last is not None:
        stops.append(Stop(last, whole, whole))
    stops = _gather_stops(stops, near, (first is not None, last is not None), whole)
    made: list[int] = []
    for one, two in _pair_stops(stops, (first is None, last is None), whole, near.node):
        made += _add_piece(builder, line, up, along, one, two, near)
    straighten_passed(builder, passed)
    return made


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


def _pair_stops(
    stops: list[Stop], free: tuple[bool, bool], whole: float, shortest: float
) -> list[tuple[Stop | float, Stop | float]]:
    """The parts of an open curve: from stop to stop, or from or to a loose end (arc length)."""
    if not stops:
        return [(0.0, whole)]
    found: list[tuple[Stop | float, Stop | float]] = []
    if free[0] and stops[0].begins > shortest:
        found.append((0.0, stops[0]))
    found += pairwise(stops)
    if free[1] and whole - stops[-1].ends > shortest:
        found.append((stops[-1], whole))
    return found


def _add_piece(
    builder: NetworkBuilder,
    line: Points,
    up: Points,
    along: NDArray[np.float64],
    a: Stop | float,
    b: Stop | float,
    near: Nearness,
) -> list[int]:
    """Add the part of the curve between two stops; nothing beyond a marked side.

    Nodes of two stops that are no further apart than ``near.node`` become one, if they can. Raises
    SeparatedError if what is between is further off than ``near.open``.
    """
    if (isinstance(a, Stop) and a.outside[1]) or (isinstance(b, Stop) and b.outside[0]):
        return []
    begin = a.ends if isinstance(a, Stop) else a
    finish = b.begins if isinstance(b, Stop) else b
    gaps = (
        a.after if isinstance(a, Stop) else None,
        b.before if isinstance(b, Stop) else None,
    )
    if isinstance(a, Stop) and isinstance(b, Stop) and finish - begin <= near.node:
        one, two = builder.node_now(a.node), builder.node_now(b.node)
        if one == two or _unite_nodes(builder, one, two, gaps, near.node):
            return []
    step = float(along[-1]) / (len(along) - 1)
    inner = np.flatnonzero((along > begin) & (along < finish))
    edge = np.interp([begin, finish], along, np.arange(len(along)))
    points, normals = interpolate_places(line, up, edge)
    ends: list[End] = [Free(), Free()]
    for k, stop in enumerate((a, b)):
        off = 0.0
        if isinstance(stop, Stop):
            node = builder.nodes[builder.node_now(stop.node)]
            off = float(np.linalg.norm(points[k] - node.point))
            points[k], normals[k] = node.point, node.normal
            ends[k] = AtNode(node.id)
        # Samples that the node has come past.
        close = np.linalg.norm(line[inner] - points[k], axis=1) < max(AT_SAMPLE * step, off)
        run = close if k == 0 else close[::-1]
        drop = len(run) if run.all() else int(np.argmin(run))
        inner = inner[drop:] if k == 0 else inner[: len(inner) - drop]
    line = np.concatenate([points[:1], line[inner], points[1:]])
    up = np.concatenate([normals[:1], up[inner], normals[1:]])
    if (line[0] == line[-1]).all() and len(inner) < 2:
        return []
    try:
        return [builder.add_chain(line, up, ends[0], ends[1], gaps=gaps)]
    except SeparatedError:
        one, two = ends
        if not (isinstance(one, AtNode) and isinstance(two, AtNode)):
            raise
        made = _add_across(builder, line, up, one.node, two.node, gaps, near)
        if not made:
            raise
        return made


def _add_across(
    builder: NetworkBuilder,
    line: Points,
    up: Points,
    first: int,
    last: int,
    gaps: Gaps,
    near: Nearness,
) -> list[int]:
    """Add a part (n, 3) from a node to another across what is between."""
    made: list[int] = []
    at, after = first, gaps[0]
    begin = 0
    for half, place, k in find_hidden_crossings(
        builder.nodes, builder.chains, line, (first, last), near.open
    ):
        chain, place = builder.locate(half >> 1, place)
        line_of = builder.chains[chain]
        node = builder.cut_chain(chain, place)
        # At an end of the chain, the half-chain that leaves it there.
        leaving = builder.nodes[node].ends[0]
        if chain in builder.chains:
            leaving = 2 * chain + int(2.0 * place > line_of.segments)
        left = (leaving ^ half) & 1 == 0
        finish = max(begin, int(k))
        around = after, Gap(leaving, left)
        made += _add_step(builder, line, up, (begin, finish), (at, node), around, near.node)
        at, after, begin = node, Gap(leaving, not left), finish
    if after is gaps[0]:
        return []
    return made + _add_step(
        builder, line, up, (begin, len(line)), (at, last), (after, gaps[1]), near.node
    )


def _add_step(
    builder: NetworkBuilder,
    line: Points,
    up: Points,
    part: tuple[int, int],
    nodes: tuple[int, int],
    gaps: Gaps,
    near: float,
) -> list[int]:
    """Add the samples of a part that are strictly between two, from a node to another."""
    one, two = (builder.nodes[builder.node_now(node)] for node in nodes)
    if one.id == two.id or _unite_nodes(builder, one.id, two.id, gaps, near):
        return []
    inner = slice(part[0] + 1, max(part[0] + 1, min(part[1], len(line) - 1)))
    points = np.concatenate([one.point[None], line[inner], two.point[None]])
    normals = np.concatenate([one.normal[None], up[inner], two.normal[None]])
    if not (points[1:] != points[:-1]).any():
        return []
    return [builder.add_chain(points, normals, AtNode(one.id), AtNode(two.id), gaps=gaps)]


#: A curve from a node back to it is nothing if it is no longer than this many times what counts as
#: near: it goes round the node at most.
AROUND = 4.0

#: Fewest points of a chain from a node back to it.
ROUND = 4


def _contract_chain(builder: NetworkBuilder, chain: int) -> int:
    """Let a chain between two nodes go, and make them one; returns the node.

    The node on a marked chain stays where it is, else the older; the chains of the other are led
    there. A wedge beside the chain is a corner if it was at either end.
    """
    line = builder.chains.pop(chain)
    builder.touched_chains.discard(chain)
    marked = {
        node: any(
            builder.chains[h >> 1].marked for h in builder.nodes[node].ends if h >> 1 != chain
        )
        for node in (line.start, line.end)
    }
    stays, goes = sorted((line.start, line.end), key=lambda node: (not marked[node], node))
    half = 2 * chain if line.start == stays else 2 * chain + 1
    one, two = builder.nodes[stays], builder.nodes[goes]
    j, k = one.ends.index(half), two.ends.index(half ^ 1)
    outer, inner = one.ends[j + 1 :] + one.ends[:j], two.ends[k + 1 :] + two.ends[:k]
    beyond, within = one.flagged[j:] + one.flagged[:j], two.flagged[k:] + two.flagged[:k]
    # The wedges on either side of the chain, at its two ends, are one now.
    left, right = within[-1] or beyond[0], within[0] or beyond[-1]
    if outer and inner:
        flags = (*within[1:-1], left, *beyond[1:-1], right)
    else:
        flags = (*within[1:-1], *beyond[1:-1], left or right)
    ends = inner + outer
    for end in inner:
        old = builder.chains[end >> 1]
        builder.chains[old.id] = replace(old, **({"end": stays} if end & 1 else {"start": stays}))
    builder.drop_node(goes)
    builder.same[goes] = stays
    cut = one.cut and two.cut
    builder.set_node(replace(one, ends=ends, flagged=flags if len(ends) > 1 else (False,), cut=cut))
    builder.move_node(stays, one.point, one.normal)
    return stays


def _unite_nodes(builder: NetworkBuilder, one: int, two: int, gaps: Gaps, near: float) -> bool:
    """Make one node of two that a curve passes, next to each other; was that possible?

    gaps: those by which the curve leaves the one and comes to the other. near: how far apart
    they are at most. A chain that leads from the one to the other, no longer than AROUND times
    that, is what the curve follows, and nothing changes. Not possible where a border would be
    taken along, or a chain be left without length.
    """
    a, b = builder.nodes[one], builder.nodes[two]
    if np.linalg.norm(a.point - b.point) > near or not (a.ends and b.ends):
        return False
    both = {half >> 1 for half in a.ends} & {half >> 1 for half in b.ends}
    lines = [builder.chains[chain] for chain in both]
    if any(line.length <= AROUND * near for line in lines):
        return True
    if all(any(builder.chains[h >> 1].marked for h in at.ends) for at in (a, b)):
        return False
    # Chains from the one to the other go round then; of others an end moves.
    ends = [builder.chains[half >> 1].directed(half)[0][1:] for half in (*a.ends, *b.ends)]
    still = any((line == at.point).all() for line in ends for at in (a, b))
    if still or any(len(line.points) < ROUND for line in lines):
        return False
    chain = builder.new_id()
    points, normals = np.stack([a.point, b.point]), np.stack([a.normal, b.normal])
    builder.chains[chain] = Chain(chain, one, two, points, normals)
    attach_chain(builder, chain, near, gaps)
    _contract_chain(builder, chain)
    return True


#: Points that distances from a curve are taken to are this part of the width apart.
FINE = 0.2

#: (n, 3) points and normals of a part of a curve.
Line = tuple[Points, Points]


def remove_doubles(builder: NetworkBuilder, made: Iterable[int], width: float) -> list[int]:
    """Take from an open network what of a new curve lies on others, or on itself.

    made: its chains. Of two chains from node to node, each within ``width`` of the other all along,
    on the same side of a sheet, the newer goes; of a chain from a node
    back to it around nothing, whose halves lie so on each other, the first half stays. Where
    just what was there before is left, it is as it was. Returns what the curve's chains are now.
    """
    left = {chain for chain in made if chain in builder.chains}
    todo = sorted(left)
    while todo:
        chain = todo.pop(0)
        line = builder.chains.get(chain)
        if chain not in left or line is None or line.loose:
            continue
        if line.start == line.end:
            if any(_turns_back(builder, half, width) for half in (2 * chain, 2 * chain + 1)):
                builder.cut_chain(chain, line.segments // 2)
                stays, goes = builder.cuts[chain].pieces
                builder.remove_chain(goes)
                left = left - {chain} | {stays}
            continue
        doubles = [
            half >> 1
            for half in (
                _find_double(builder, 2 * chain, width),
                _find_double(builder, 2 * chain + 1, width),
                _find_twisted_double(builder, chain, width),
            )
            if half is not None
        ]
        gone = max([chain, *doubles])
        if not doubles or gone not in left:
            continue
        left.discard(gone)
        for node in builder.remove_chain(gone):
            parts = {half >> 1 for half in builder.nodes[node].ends}
            _restore_flags(builder, node)
            merged = builder.merge(node) if builder.nodes[node].cut else None
            if merged is not None and parts & left:
                left = left - parts | {merged}
                parts = {merged}
            todo += sorted(parts & left)
        todo.append(chain)
    return sorted(left)


def _find_double(builder: NetworkBuilder, half: HalfChain, width: float) -> HalfChain | None:
    """The other side of the face on the left of a half-chain, if it has just two, and they lie on
    each other."""
    other, _ = find_successor(builder.nodes, builder.chains, half)
    if other in (half, half ^ 1) or find_successor(builder.nodes, builder.chains, other)[0] != half:
        return None
    one, two = builder.chains[half >> 1], builder.chains[other >> 1]
    if one.marks[half & 1] or two.marks[other & 1]:
        return None
    near = _lie_on_each_other((one.points, one.normals), (two.points, two.normals), width)
    return other if near else None


def _find_twisted_double(builder: NetworkBuilder, chain: int, width: float) -> HalfChain | None:
    """The half-chain between the same two nodes that lies on a chain, whatever is between them.

    What the ends of both say on which side of them others leave may disagree there: at one end the
    curve was joined on the left of what it follows, at the other on its right.
    """
    line = builder.chains[chain]
    for half in builder.nodes[line.start].ends:
        other = builder.chains[half >> 1]
        if {other.start, other.end} != {line.start, line.end} or other.id == chain:
            continue
        if other.marked or line.marked:
            continue
        ours, theirs = (line.points, line.normals), (other.points, other.normals)
        if _lie_on_each_other(ours, theirs, width):
            return half
    return None


def _turns_back(builder: NetworkBuilder, half: HalfChain, width: float) -> bool:
    """Is a half-chain all around the face on its left, and lies its one half on the other?"""
    line = builder.chains[half >> 1]
    middle = line.segments // 2
    if find_successor(builder.nodes, builder.chains, half)[0] != half or middle < 1 or line.marked:
        return False
    one, two = slice(middle + 1), slice(middle, None)
    return _lie_on_each_other(
        (line.points[one], line.normals[one]), (line.points[two], line.normals[two]), width
    )


def _lie_on_each_other(one: Line, two: Line, width: float) -> bool:
    """Is every sample of each near the other, where the surface's normal agrees?"""
    for (points, up), other in ((one, two), (two, one)):
        others, above = _refine(other, FINE * width)
        away, k = KDTree(others).query(points)
        if away.max() > width or (np.einsum("nc,nc->n", up, above[k]) <= 0.0).any():
            return False
    return True


def _refine(line: Line, step: float) -> Line:
    """A part of a curve with points at most a step apart: where curves were drawn together or cut
    their samples may be far apart."""
    points, up = line
    along = arc_length(points)
    count = max(len(points), math.ceil(along[-1] / step) + 1)
    wanted = np.union1d(along, np.linspace(0.0, along[-1], count))
    turned = np.stack([np.interp(wanted, along, up[:, d]) for d in range(3)], axis=1)
    return at_lengths(points, wanted), turned


def _restore_flags(builder: NetworkBuilder, node: int) -> None:
    """Give a node the flags it had before, if it has the same ends as then."""
    old = builder.before.nodes.get(node)
    if old is None:
        return
    at = builder.nodes[node]
    before = tuple(builder.half_now(half) for half in old.ends)
    if len(before) == at.valence and before[0] in at.ends:
        j = at.ends.index(before[0])
        if before == at.ends[j:] + at.ends[:j]:
            flags = tuple(old.flagged[(i - j) % at.valence] for i in range(at.valence))
            builder.set_node(replace(at, flagged=flags, cut=old.cut))


def _gather_stops(
    stops: list[Stop], near: Nearness, joined: tuple[bool, bool], whole: float
) -> list[Stop]:
    """Neighbouring stops at one node, with next to no curve between them, as one."""
    result: list[Stop] = []
    for k, stop in enumerate(stops):
        if result and result[-1].node == stop.node:
            gap = stop.begins - result[-1].ends
            limit = AROUND * near.node
            if gap < 0.5 * whole:
                if joined[0] and len(result) == 1:
                    limit = max(limit, near.ends[0])
                if joined[1] and k == len(stops) - 1:
                    limit = max(limit, near.ends[1])
            if gap <= limit:
                result[-1] = _unite_stops(result[-1], stop)
                continue
        result.append(stop)
    return result


def _unite_stops(one: Stop, two: Stop) -> Stop:
    outside = (one.outside[0], two.outside[1])
    return Stop(one.node, one.begins, two.ends, one.before, two.after, outside)
