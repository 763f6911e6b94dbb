"""A chain contracted: its two nodes become one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from patterndb_sketch.retopo.network.attaching import Gaps, attach
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.structure import Chain

#: A curve from a node back to it is nothing if it is no longer than this many times what counts as
#: near: it goes round the node at most.
AROUND = 4.0

#: Fewest points of a chain from a node back to it.
ROUND = 4


def contracted(draft: Draft, chain: int) -> int:
    """Let a chain between two nodes go, and make them one; returns the node.

    The node on a marked chain stays where it is, else the older; the chains of the other are led
    there. A wedge beside the chain is a corner if it was at either end.
    """
    line = draft.chains.pop(chain)
    draft.touched_chains.discard(chain)
    marked = {
        node: any(draft.chains[h >> 1].marked for h in draft.nodes[node].ends if h >> 1 != chain)
        for node in (line.start, line.end)
    }
    stays, goes = sorted((line.start, line.end), key=lambda node: (not marked[node], node))
    half = 2 * chain if line.start == stays else 2 * chain + 1
    one, two = draft.nodes[stays], draft.nodes[goes]
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
        old = draft.chains[end >> 1]
        draft.chains[old.id] = replace(old, **({"end": stays} if end & 1 else {"start": stays}))
    draft.drop_node(goes)
    draft.same[goes] = stays
    cut = one.cut and two.cut
    draft.set_node(replace(one, ends=ends, flagged=flags if len(ends) > 1 else (False,), cut=cut))
    draft.move_node(stays, one.point, one.normal)
    return stays


def drawn_together(draft: Draft, one: int, two: int, gaps: Gaps, near: float) -> bool:
    """Make one node of two that a curve passes, next to each other; was that possible?

    gaps: those by which the curve leaves the one and comes to the other. near: how far apart
    they are at most. A chain that leads from the one to the other, no longer than AROUND times
    that, is what the curve follows, and nothing changes. Not possible where a border would be
    taken along, or a chain be left without length.
    """
    a, b = draft.nodes[one], draft.nodes[two]
    if np.linalg.norm(a.point - b.point) > near or not (a.ends and b.ends):
        return False
    both = {half >> 1 for half in a.ends} & {half >> 1 for half in b.ends}
    lines = [draft.chains[chain] for chain in both]
    if any(line.length <= AROUND * near for line in lines):
        return True
    if all(any(draft.chains[h >> 1].marked for h in at.ends) for at in (a, b)):
        return False
    # Chains from the one to the other go round then; of others an end moves.
    ends = [draft.chains[half >> 1].directed(half)[0][1:] for half in (*a.ends, *b.ends)]
    still = any((line == at.point).all() for line in ends for at in (a, b))
    if still or any(len(line.points) < ROUND for line in lines):
        return False
    chain = draft.new_id()
    points, normals = np.stack([a.point, b.point]), np.stack([a.normal, b.normal])
    draft.chains[chain] = Chain(chain, one, two, points, normals)
    attach(draft, chain, near, gaps)
    contracted(draft, chain)
    return True
