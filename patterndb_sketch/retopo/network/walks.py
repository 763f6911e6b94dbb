"""Walks around the faces of a network: which half-chain follows which, and where corners are."""

from __future__ import annotations

from collections.abc import Mapping

from patterndb_sketch.retopo.network.structure import NONE, Chain, HalfChain, Node


def successor(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], half: HalfChain
) -> tuple[HalfChain, bool]:
    """What follows a half-chain around the face on its left, and is there a corner between?

    At an open end it is its twin; a closed chain without a node follows itself.
    """
    chain = chains[half >> 1]
    node = chain.start if half & 1 else chain.end
    if node == NONE:
        return half, False
    at = nodes[node]
    wedge = at.wedge_before(half ^ 1)
    return at.ends[wedge], at.flagged[wedge]


def face(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], half: HalfChain
) -> tuple[tuple[HalfChain, ...], tuple[int, ...]]:
    """The loop around the face on the left of a half-chain, and its corners.

    The loop begins, if it has a corner, as that of a :class:`Patch` does, else with its lowest
    half-chain; corners are the places in it before which a corner lies.
    """
    loop: list[HalfChain] = []
    leaves_corner: list[bool] = []
    at, corner = half, False
    while True:
        loop.append(at)
        leaves_corner.append(corner)
        at, corner = successor(nodes, chains, at)
        if at == half:
            leaves_corner[0] = corner
            break
    firsts = [k for k, corner in enumerate(leaves_corner) if corner] or range(len(loop))
    first = min(firsts, key=loop.__getitem__)
    loop = loop[first:] + loop[:first]
    leaves_corner = leaves_corner[first:] + leaves_corner[:first]
    return tuple(loop), tuple(k for k, corner in enumerate(leaves_corner) if corner)


def walked(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], half: HalfChain
) -> list[HalfChain]:
    """The half-chains around the face on the left of one, from that one on."""
    loop = [half]
    at, _ = successor(nodes, chains, half)
    while at != half:
        loop.append(at)
        at, _ = successor(nodes, chains, at)
    return loop


def joined_chains(nodes: Mapping[int, Node], chains: Mapping[int, Chain], chain: int) -> set[int]:
    """The chains that hang together with one, by nodes."""
    found = {chain}
    seen = {NONE}
    left = [chain]
    while left:
        line = chains[left.pop()]
        for node in (line.start, line.end):
            if node not in seen:
                seen.add(node)
                new = {half >> 1 for half in nodes[node].ends} - found
                found |= new
                left += new
    return found


def dead_end(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], loop: tuple[HalfChain, ...]
) -> bool:
    """Does a loop turn round at an open end?"""
    for half in loop:
        chain = chains[half >> 1]
        node = chain.start if half & 1 else chain.end
        if node != NONE and len(nodes[node].ends) == 1:
            return True
    return False
