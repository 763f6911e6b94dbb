"""Join two nodes in one place to one, and curves that lie on each other then, too."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network.attaching import find_wedge
from patterndb_sketch.retopo.network.builder import AtChain, AtNode, NetworkBuilder
from patterndb_sketch.retopo.network.faces import find_successor
from patterndb_sketch.retopo.network.patches import FEWEST_CORNERS
from patterndb_sketch.retopo.network.samples import find_nearest_place, take_chain_samples
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Network, Node
from patterndb_sketch.retopo.sizes import Sizes

#: Directions at a node are taken over this many samples.
SAMPLES_AHEAD = 2.0

#: The node that is made of two, and the ends of it whose wedges on the left are new.
Made = tuple[Node, tuple[HalfChain, ...]]

#: Fewest points of a chain from a node back to it.
FEWEST_ROUND = 4


@dataclass(frozen=True, slots=True)
class NodeJoint:
    """Two nodes that become one: that which was pulled, and goes, and that which stays."""

    pulled: int
    stays: int


def find_joint(
    network: Network, sizes: Sizes, node: int, point: Points, normal: Points
) -> AtNode | AtChain | None:
    """What a node that is let go at a point (3,) snaps to, None for nothing: see
    :func:`~patterndb_sketch.retopo.tools.pull.release_held`."""
    at = network.nodes[node]
    own = {half >> 1 for half in at.ends}
    far = {network.target(half) for half in at.ends} - {node}
    others = [other for other in network.nodes.values() if other.id != node]
    # Not its own curve's other end, unless the curve goes round: else it would vanish.
    barred = far if at.open and not _goes_round(network, at, sizes) else set[int]()
    for chosen in (
        [o for o in others if o.open and o.id not in barred],
        [o for o in others if o.id in far and not o.open],
        [o for o in others if o.id not in far and not o.open],
    ):
        found = _find_nearest(chosen, point, normal, sizes.snap)
        if found is not None:
            return AtNode(found.id)
    sides = {chain: line for chain, line in network.chains.items() if chain not in own}
    place = find_nearest_place(take_chain_samples(sides), point, normal, sizes.snap)
    return None if place is None else AtChain(place.chain, place.place)


def join_nodes(
    builder: NetworkBuilder, sizes: Sizes, joint: NodeJoint, smooth: bool = False
) -> NetworkBuilder | str:
    """An open network in which two nodes at one place are one, or why they cannot be.

    If a chain runs between them it collapses: its face loses a side, and a corner if both nodes
    were one; a patch keeps at least 2. Else the curves of the one go into a gap of the other,
    and both wedges beside them become corners. Curves that lie on each other within the snap
    radius, from the one node to another, become one: that which stayed.

    Source: the program of Takayama et al. 2013, which wants exactly one gap without a patch at
    both. Differs from it: where there are several, that one counts into which all curves of the
    other node point; and an open end may end within a patch, as a stroke may.
    """
    pulled, stays = builder.nodes[joint.pulled], builder.nodes[joint.stays]
    patch_of = _find_patches_now(builder)
    ends = set(pulled.ends)
    between = [half for half in pulled.ends if half ^ 1 in stays.ends]
    both_open = pulled.open and stays.open
    if between and not both_open:
        if len(between) > 1:
            return "several curves run between the two corners; erase one first"
        made = _contract(builder, patch_of, pulled, stays, between[0])
    else:
        made = _insert(builder, patch_of, pulled, stays, sizes.snap)
    if isinstance(made, str):
        return made
    node, beside = made
    collapsed = set() if both_open else {half >> 1 for half in between}
    chains = {k: line for k, line in builder.chains.items() if k not in collapsed}
    for half in ends:
        line = chains.get(half >> 1)
        if line is not None:
            end = {"end": node.id} if half & 1 else {"start": node.id}
            chains[line.id] = replace(line, **end)
    nodes = {k: at for k, at in builder.nodes.items() if k != pulled.id}
    nodes[node.id] = node
    result = NetworkBuilder(
        replace(builder.before, nodes=nodes, chains=chains, next_id=builder.next_id)
    )
    result.move_node(node.id, node.point, node.normal)
    if both_open and smooth:
        result.merge(node.id)
        return result
    for half in beside:
        _merge_doubled(result, half, {h >> 1 for h in ends}, sizes.snap)
    return result


def _contract(
    builder: NetworkBuilder,
    patch_of: dict[HalfChain, int],
    pulled: Node,
    stays: Node,
    half: HalfChain,
) -> Made | str:
    """The node that is left of a chain."""
    one, flags_one = _list_from(pulled, half)
    two, flags_two = _list_from(stays, half ^ 1)
    if not one and not two:
        return "nothing would be left of the curve; erase it instead"
    for side, lost in (
        (half, flags_one[0] and flags_two[-1]),
        (half ^ 1, flags_one[-1] and flags_two[0]),
    ):
        patch = builder.before.patches.get(patch_of.get(side, -1))
        if patch is not None and len(patch.corners) - lost < FEWEST_CORNERS:
            return f"a patch keeps at least {FEWEST_CORNERS} corners"
    left, right = flags_two[-1] or flags_one[0], flags_one[-1] or flags_two[0]
    if not one:
        flags, beside = (*flags_two[1:-1], left or right), two[-1:]
    elif not two:
        flags, beside = (*flags_one[1:-1], left or right), one[-1:]
    else:
        flags = (*flags_two[1:-1], left, *flags_one[1:-1], right)
        beside = (two[-1], one[-1])
    ends = (*two, *one)
    flags = flags if len(ends) > 1 else (False,)
    return replace(stays, ends=ends, flagged=flags, cut=False), beside


def _insert(
    builder: NetworkBuilder, patch_of: dict[HalfChain, int], pulled: Node, stays: Node, near: float
) -> Made | str:
    """The node with the ends of both."""
    into = _find_gap(builder, patch_of, stays, pulled, near)
    of = _find_gap(builder, patch_of, pulled, stays, near)
    if into is None or of is None:
        return "both corners need one gap without a patch, for the curves of the other"
    one = (*pulled.ends[of + 1 :], *pulled.ends[: of + 1])
    inner = (*pulled.flagged[of + 1 :], *pulled.flagged[:of])
    ends = (*stays.ends[: into + 1], *one, *stays.ends[into + 1 :])
    flags = (*stays.flagged[:into], True, *inner, True, *stays.flagged[into + 1 :])
    return replace(stays, ends=ends, flagged=flags), (stays.ends[into], one[-1])


def _list_from(node: Node, half: HalfChain) -> tuple[tuple[HalfChain, ...], tuple[bool, ...]]:
    """The ends of a node counter-clockwise after one, and the flags of all wedges from that which
    follows it."""
    j = node.ends.index(half)
    ends = (*node.ends[j + 1 :], *node.ends[:j])
    return ends, (*node.flagged[j:], *node.flagged[:j])


def _find_gap(
    builder: NetworkBuilder, patch_of: dict[HalfChain, int], node: Node, other: Node, near: float
) -> int | None:
    """The wedge of a node that the curves of another, at the same place, go into."""
    open_wedges = [
        j for j, half in enumerate(node.ends) if not builder.chains[half >> 1].marks[half & 1]
    ]
    empty = [j for j in open_wedges if node.ends[j] not in patch_of]
    if len(empty) == 1 and not other.open:
        return empty[0]
    wedges = open_wedges if other.open else empty
    if not wedges:
        return None
    if other.open:
        beside = _find_beside_double(builder, node, other.ends[0], near)
        if beside in wedges:
            return beside
    lines = [(builder.chains[half >> 1], bool(half & 1)) for half in (*node.ends, *other.ends)]
    reach = SAMPLES_AHEAD * max(line.length / line.segments for line, _ in lines)
    shapes = [(line.points, backwards) for line, backwards in lines]
    ends, news = shapes[: node.valence], shapes[node.valence :]
    found = {find_wedge(node.normal, ends, new, reach, wedges) for new in news}
    return found.pop() if len(found) == 1 else None


def _find_beside_double(
    builder: NetworkBuilder, node: Node, new: HalfChain, near: float
) -> int | None:
    """The wedge of a node next to a curve that a new one lies on from there to one far node, on
    the side where it is at that one: directions say nothing there."""
    line = builder.chains[new >> 1]
    far = line.start if new & 1 else line.end
    if far == node.id or far not in builder.nodes:
        return None
    around = builder.nodes[far].ends
    at = around.index(new ^ 1)
    for side, wedge in ((-1, -1), (1, 0)):
        half = around[(at + side) % len(around)] ^ 1
        if (
            half in node.ends
            and half != new
            and _are_on_each_other(line, builder.chains[half >> 1], near)
        ):
            return (node.ends.index(half) + wedge) % node.valence
    return None


def _find_patches_now(builder: NetworkBuilder) -> dict[HalfChain, int]:
    """The patch on the left of every half-chain, those of pieces of cut chains, too."""
    found: dict[HalfChain, int] = {}
    for half, patch in builder.before.patch_of().items():
        for piece in builder.pieces([half >> 1]):
            found[2 * piece + (half & 1)] = patch
    return found


def _merge_doubled(builder: NetworkBuilder, half: HalfChain, pulled: set[int], near: float) -> None:
    """If the face on the left of a half-chain has two sides, which lie on each other, make them
    one; that which was pulled goes."""
    half = builder.half_now(half)
    if half >> 1 not in builder.chains:
        return
    other, _ = find_successor(builder.nodes, builder.chains, half)
    back, _ = find_successor(builder.nodes, builder.chains, other)
    if back != half or other in (half, half ^ 1):
        return
    one, two = builder.chains[half >> 1], builder.chains[other >> 1]
    if one.start == one.end or one.marks[half & 1] or two.marks[other & 1]:
        return
    if not _are_on_each_other(one, two, near):
        return
    gone, kept = (half, other) if half >> 1 in pulled else (other, half)
    line, stays = builder.chains[gone >> 1], builder.chains[kept >> 1]
    if line.marked:
        gone, kept, line, stays = kept, gone, stays, line
    if line.marked:
        return
    first, last = (line.start, line.end) if gone & 1 == 0 else (line.end, line.start)
    begin, finish = builder.nodes[first], builder.nodes[last]
    j = begin.ends.index(gone)
    before, beyond = begin.ends[j - 1], begin.flagged[j - 1]
    after = finish.flagged[finish.ends.index(gone ^ 1)]
    builder.remove_chain(line.id)
    for node, end, corner in ((first, before, beyond), (last, kept, after)):
        if not builder.nodes[node].open:
            builder.flag(end, corner)
    if not stays.count and line.count:
        builder.set_count(stays.id, line.count, line.pinned)


def _are_on_each_other(one: Chain, two: Chain, near: float) -> bool:
    """Is every sample of each chain near one of the other?"""
    for line, of in ((one, two), (two, one)):
        if KDTree(of.points).query(line.points)[0].max() > near:
            return False
    return True


def _goes_round(network: Network, at: Node, sizes: Sizes) -> bool:
    """Does the curve of an open end, pulled to the end at its other side, leave the snap radius?"""
    points, _ = network.chains[at.ends[0] >> 1].directed(at.ends[0])
    share = np.linspace(1.0, 0.0, len(points))[:, None]
    off = np.linalg.norm(points + share * (points[-1] - points[0]) - points[-1], axis=1)
    return len(points) >= FEWEST_ROUND and bool(off.max() > sizes.snap)


def _find_nearest(
    nodes: Iterable[Node], point: Points, normal: Points, radius: float
) -> Node | None:
    """The nearest of some nodes within a radius, where normals agree."""
    best: tuple[float, Node] | None = None
    for node in nodes:
        away = float(np.linalg.norm(node.point - point))
        if away <= radius and node.normal @ normal > 0.0 and (best is None or away < best[0]):
            best = (away, node)
    return None if best is None else best[1]
