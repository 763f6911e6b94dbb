"""Caps: patches beyond the rings that a cylinder joins."""

from __future__ import annotations

from typing import Literal, get_args

from patterndb_sketch.retopo.network import Draft, HalfChain, Network, face, is_end
from patterndb_sketch.retopo.tools.cylinder.rings import Ring

Caps = Literal["auto", "always", "never"]
CAPS = get_args(Caps)


def wants_cap(network: Network, ring: Ring, caps: Caps) -> bool:
    """Is there to be a patch on the other side of a ring?

    Never where that side has a patch, a mark or other curves; else always, or, by itself, where
    the loop encloses a part of the surface there as a patch does, or the end of a limb.
    """
    if caps == "never":
        return False
    beyond = tuple(half ^ 1 for half in reversed(ring.edge.halves))
    if any(half in network.patch_of() or network.mark(half) for half in beyond):
        return False
    loop, _ = face(network.nodes, network.chains, beyond[0])
    if set(loop) != set(beyond):
        return False
    return caps == "always" or is_end(network, loop)


def flag_beyond(draft: Draft, node: int, join: HalfChain) -> HalfChain:
    """Make the wedge at a node across from a join a corner; the half-chain on its right."""
    ends = draft.nodes[node].ends
    after = ends[(ends.index(join) + 1) % len(ends)]
    draft.flag(after, True)
    return after
