"""Join nodes at one place to one, and curves that lie on each other.

A stroke that is drawn along a curve that is there, or back along itself, crosses it at random, and
what is between are slivers: faces of two sides that lie on each other, and around the tip of a
stroke that turns back, faces of one. One curve is meant (:func:`remove_doubles`). The same holds of
curves between two nodes that are pulled together (:func:`join_nodes`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.attaching import (
    Gaps,
    attach_chain,
    find_wedge,
    list_departures,
    measure_reach,
)
from patterndb_sketch.retopo.network.builder import NetworkBuilder
from patterndb_sketch.retopo.network.faces import find_successor
from patterndb_sketch.retopo.network.patches import FEWEST_CORNERS
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node

#: A curve from a node back to it is nothing if it is no longer than this many times what counts as
#: near: it goes round the node at most.
AROUND = 4.0

#: Fewest points of a chain from a node back to it.
FEWEST_ROUND = 4

#: Points that distances from a curve are taken to are this part of the width apart.
FINE = 0.2

#: (n, 3) points and normals of a part of a curve.
Line = tuple[Points, Points]


def _end_there(line: Chain, half: HalfChain, node: int) -> Chain:
    """The chain with the node that one of its halves leaves named anew."""
    return replace(line, **({"end": node} if half & 1 else {"start": node}))


def _contract(
    one: Node, two: Node, half: HalfChain
) -> tuple[tuple[HalfChain, ...], tuple[bool, ...]]:
    """The ends and flags of the node that two become when the chain between them goes, those of
    ``one`` first; half: it leaves ``one``. A wedge beside the chain is a corner if it was at
    either end."""
    j, k = one.ends.index(half), two.ends.index(half ^ 1)
    first, last = one.ends[j + 1 :] + one.ends[:j], two.ends[k + 1 :] + two.ends[:k]
    a, b = one.corner_flags[j:] + one.corner_flags[:j], two.corner_flags[k:] + two.corner_flags[:k]
    # The wedges on either side of the chain, at its two ends, are one now.
    left, right = a[-1] or b[0], b[-1] or a[0]
    if first and last:
        flags = (*a[1:-1], left, *b[1:-1], right)
    else:
        flags = (*a[1:-1], *b[1:-1], left or right)
    ends = first + last
    return ends, flags if len(ends) > 1 else (False,)


def unite_nodes(builder: NetworkBuilder, one: int, two: int, gaps: Gaps, near: float) -> bool:
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
    marked = {at.id: any(builder.chains[half >> 1].marked for half in at.ends) for at in (a, b)}
    if all(marked.values()):
        return False
    # Chains from the one to the other go round then; of others an end moves.
    ends = [builder.chains[half >> 1].directed(half)[0][1:] for half in (*a.ends, *b.ends)]
    still = any((line == at.point).all() for line in ends for at in (a, b))
    if still or any(len(line.points) < FEWEST_ROUND for line in lines):
        return False
    # A chain between the two tells where around each the other's ends go.
    points, normals = np.stack([a.point, b.point]), np.stack([a.normal, b.normal])
    chain = builder.new_chain(one, two, points, normals)
    attach_chain(builder, chain, near, gaps)
    # The node on a marked chain stays where it is, else the older.
    stays, goes = sorted((one, two), key=lambda node: (not marked[node], node))
    half = 2 * chain if goes == one else 2 * chain + 1
    old, kept = builder.nodes[goes], builder.nodes[stays]
    around, flags = _contract(old, kept, half)
    del builder.chains[chain]
    builder.touched_chains.discard(chain)
    for end in old.ends:
        if end != half:
            builder.chains[end >> 1] = _end_there(builder.chains[end >> 1], end, stays)
    builder.drop_node(goes)
    builder.same[goes] = stays
    builder.set_node(replace(kept, ends=around, corner_flags=flags, cut=kept.cut and old.cut))
    builder.move_node(stays, kept.point, kept.normal)
    return True


def join_nodes(
    builder: NetworkBuilder, pulled: int, stays: int, near: float, smooth: bool = False
) -> NetworkBuilder:
    """A builder in which two nodes at one place are one: ``stays``.

    If a chain runs between them it collapses: its face loses a side, and a corner if both nodes
    were one; a patch keeps at least 2. Else the curves of the one go into a gap of the other,
    and both wedges beside them become corners. Curves that lie on each other within ``near``, from
    the one node to another, become one: that which stayed.

    Raises RefusedError where they cannot be one.
    Source: the program of Takayama et al. 2013, which wants exactly one gap without a patch at
    both. Differs from it: where there are several, that one counts into which all curves of the
    other node point; and an open end may end within a patch, as a stroke may.
    """
    one, two = builder.nodes[pulled], builder.nodes[stays]
    patch_of = _find_patches_now(builder)
    between = [half for half in one.ends if half ^ 1 in two.ends]
    both_open = one.open and two.open
    collapsed: set[int] = set()
    if between and not both_open:
        if len(between) > 1:
            raise RefusedError("several curves run between the two corners; erase one first")
        node, beside = _collapse(builder, patch_of, one, two, between[0])
        collapsed.add(between[0] >> 1)
    else:
        node, beside = _insert(builder, patch_of, one, two, near)
    chains = {k: line for k, line in builder.chains.items() if k not in collapsed}
    for half in one.ends:
        if half >> 1 in chains:
            chains[half >> 1] = _end_there(chains[half >> 1], half, stays)
    nodes = {k: at for k, at in builder.nodes.items() if k != pulled}
    nodes[stays] = node
    result = NetworkBuilder(
        replace(builder.before, nodes=nodes, chains=chains, next_id=builder.next_id)
    )
    result.move_node(stays, node.point, node.normal)
    if both_open and smooth:
        result.merge(stays)
        return result
    for half in beside:
        _merge_doubled(result, half, {h >> 1 for h in one.ends}, near)
    return result


def _collapse(
    builder: NetworkBuilder,
    patch_of: dict[HalfChain, int],
    pulled: Node,
    stays: Node,
    half: HalfChain,
) -> tuple[Node, tuple[HalfChain, ...]]:
    """The node that is left of a chain, and the ends of it whose wedges on the left are new."""
    j, k = pulled.ends.index(half), stays.ends.index(half ^ 1)
    for side, lost in (
        (half, pulled.corner_flags[j] and stays.corner_flags[k - 1]),
        (half ^ 1, pulled.corner_flags[j - 1] and stays.corner_flags[k]),
    ):
        patch = builder.before.patches.get(patch_of.get(side, -1))
        if patch is not None and len(patch.corners) - lost < FEWEST_CORNERS:
            raise RefusedError(f"a patch keeps at least {FEWEST_CORNERS} corners")
    ends, flags = _contract(stays, pulled, half ^ 1)
    last = [at.ends[at.ends.index(end) - 1] for at, end in ((stays, half ^ 1), (pulled, half))]
    beside = tuple(end for end in last if end not in (half, half ^ 1))
    return replace(stays, ends=ends, corner_flags=flags, cut=False), beside


def _insert(
    builder: NetworkBuilder,
    patch_of: dict[HalfChain, int],
    pulled: Node,
    stays: Node,
    near: float,
) -> tuple[Node, tuple[HalfChain, ...]]:
    """The node with the ends of both, and the ends of it whose wedges on the left are new."""
    into = _find_gap(builder, patch_of, stays, pulled, near)
    of = _find_gap(builder, patch_of, pulled, stays, near)
    if into is None or of is None:
        raise RefusedError("both corners need one gap without a patch, for the curves of the other")
    one = (*pulled.ends[of + 1 :], *pulled.ends[: of + 1])
    inner = (*pulled.corner_flags[of + 1 :], *pulled.corner_flags[:of])
    ends = (*stays.ends[: into + 1], *one, *stays.ends[into + 1 :])
    flags = (*stays.corner_flags[:into], True, *inner, True, *stays.corner_flags[into + 1 :])
    return replace(stays, ends=ends, corner_flags=flags), (stays.ends[into], one[-1])


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
    reach = measure_reach(builder.chains[half >> 1] for half in (*node.ends, *other.ends))
    ends = list_departures(builder.chains, node.ends)
    news = list_departures(builder.chains, other.ends)
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
        if half in node.ends and half != new and _are_double(line, builder.chains[half >> 1], near):
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
    one = builder.chains.get(half >> 1)
    other = None if one is None or one.start == one.end else _find_double(builder, half, near)
    if other is None:
        return
    gone, kept = (half, other) if half >> 1 in pulled else (other, half)
    if builder.chains[gone >> 1].marked:
        gone, kept = kept, gone
    line, stays = builder.chains[gone >> 1], builder.chains[kept >> 1]
    if line.marked:
        return
    first, last = (line.start, line.end) if gone & 1 == 0 else (line.end, line.start)
    begin, finish = builder.nodes[first], builder.nodes[last]
    j = begin.ends.index(gone)
    before, beyond = begin.ends[j - 1], begin.corner_flags[j - 1]
    after = finish.corner_flags[finish.ends.index(gone ^ 1)]
    builder.remove_chain(line.id)
    for node, end, corner in ((first, before, beyond), (last, kept, after)):
        if not builder.nodes[node].open:
            builder.flag(end, corner)
    if not stays.count and line.count:
        builder.set_count(stays.id, line.count, line.pinned)


def remove_doubles(builder: NetworkBuilder, made: Iterable[int], width: float) -> list[int]:
    """Take from a network what of a new curve lies on others, or on itself.

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
        if chain not in left or line is None or line.is_closed_loop:
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
    return other if _are_double(one, two, width) else None


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
        if not other.marked and not line.marked and _are_double(line, other, width):
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


def _are_double(one: Chain, two: Chain, width: float) -> bool:
    return _lie_on_each_other((one.points, one.normals), (two.points, two.normals), width)


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
            flags = tuple(old.corner_flags[(i - j) % at.valence] for i in range(at.valence))
            builder.set_node(replace(at, corner_flags=flags, cut=old.cut))
