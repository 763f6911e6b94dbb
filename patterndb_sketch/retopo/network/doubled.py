"""Curves that lie on each other become one.

A stroke that is drawn along a curve that is there, or back along itself, crosses it at random, and
what is between are slivers: faces of two sides that lie on each other, and around the tip of a
stroke that turns back, faces of one. One curve is meant.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.structure import HalfChain
from patterndb_sketch.retopo.network.walks import successor

#: Points that distances from a curve are taken to are this part of the width apart.
FINE = 0.2

#: (n, 3) points and normals of a part of a curve.
Line = tuple[Points, Points]


def undoubled(draft: Draft, made: Iterable[int], width: float) -> list[int]:
    """Take from a draft what of a new curve lies on others, or on itself.

    made: its chains. Of two chains from node to node with nothing between, each within ``width``
    of the other all along, on the same side of a sheet, the newer goes; of a chain from a node
    back to it around nothing, whose halves lie so on each other, the first half stays. Where
    just what was there before is left, it is as it was. Returns what the curve's chains are now.
    """
    left = {chain for chain in made if chain in draft.chains}
    todo = sorted(left)
    while todo:
        chain = todo.pop(0)
        line = draft.chains.get(chain)
        if chain not in left or line is None or line.loose:
            continue
        if line.start == line.end:
            if any(_turns_back(draft, half, width) for half in (2 * chain, 2 * chain + 1)):
                draft.cut_chain(chain, line.segments // 2)
                stays, goes = draft.cuts[chain].pieces
                draft.remove_chain(goes)
                left = left - {chain} | {stays}
            continue
        others = [_across(draft, half, width) for half in (2 * chain, 2 * chain + 1)]
        gone = max([chain, *(half >> 1 for half in others if half is not None)])
        if others == [None, None] or gone not in left:
            continue
        left.discard(gone)
        for node in draft.remove_chain(gone):
            parts = {half >> 1 for half in draft.nodes[node].ends}
            _restore(draft, node)
            merged = draft.merge(node) if draft.nodes[node].cut else None
            if merged is not None and parts & left:
                left = left - parts | {merged}
                parts = {merged}
            todo += sorted(parts & left)
        todo.append(chain)
    return sorted(left)


def _across(draft: Draft, half: HalfChain, width: float) -> HalfChain | None:
    """The other side of the face on the left of a half-chain, if it has just two, and they lie on
    each other."""
    other, _ = successor(draft.nodes, draft.chains, half)
    if other in (half, half ^ 1) or successor(draft.nodes, draft.chains, other)[0] != half:
        return None
    one, two = draft.chains[half >> 1], draft.chains[other >> 1]
    if one.marks[half & 1] or two.marks[other & 1]:
        return None
    near = _on_each_other((one.points, one.normals), (two.points, two.normals), width)
    return other if near else None


def _turns_back(draft: Draft, half: HalfChain, width: float) -> bool:
    """Is a half-chain all around the face on its left, and lies its one half on the other?"""
    line = draft.chains[half >> 1]
    middle = line.segments // 2
    if successor(draft.nodes, draft.chains, half)[0] != half or middle < 1 or line.marked:
        return False
    one, two = slice(middle + 1), slice(middle, None)
    return _on_each_other(
        (line.points[one], line.normals[one]), (line.points[two], line.normals[two]), width
    )


def _on_each_other(one: Line, two: Line, width: float) -> bool:
    """Is every sample of each near the other, where the surface's normal agrees?"""
    for (points, up), other in ((one, two), (two, one)):
        others, above = _fine(other, FINE * width)
        away, k = KDTree(others).query(points)
        if away.max() > width or (np.einsum("nc,nc->n", up, above[k]) <= 0.0).any():
            return False
    return True


def _fine(line: Line, step: float) -> Line:
    """A part of a curve with points at most a step apart: where curves were drawn together or cut
    their samples may be far apart."""
    points, up = line
    along = arc_length(points)
    count = max(len(points), math.ceil(along[-1] / step) + 1)
    wanted = np.union1d(along, np.linspace(0.0, along[-1], count))
    turned = np.stack([np.interp(wanted, along, up[:, d]) for d in range(3)], axis=1)
    return at_lengths(points, wanted), turned


def _restore(draft: Draft, node: int) -> None:
    """Give a node the flags it had before, if it has the same ends as then."""
    old = draft.before.nodes.get(node)
    if old is None:
        return
    at = draft.nodes[node]
    before = tuple(draft.half_now(half) for half in old.ends)
    if len(before) == at.valence and before[0] in at.ends:
        j = at.ends.index(before[0])
        if before == at.ends[j:] + at.ends[:j]:
            flags = tuple(old.flagged[(i - j) % at.valence] for i in range(at.valence))
            draft.set_node(replace(at, flagged=flags, cut=old.cut))
