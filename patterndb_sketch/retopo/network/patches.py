"""Which loops of half-chains are patches, found again where a network changed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.caps import is_cap
from patterndb_sketch.retopo.network.enclosed import ROUND, Enclosed, enclosed
from patterndb_sketch.retopo.network.spanned import is_strip
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Network, Patch
from patterndb_sketch.retopo.network.walks import dead_end, face

#: A patch has this many corners or more: each of its sides is a curve of its own.
FEWEST_CORNERS = 2


def outline(network: Network, loop: Iterable[HalfChain]) -> tuple[Points, Points]:
    """(n, 3) points and normals around a loop of half-chains, no point twice."""
    points: list[Points] = []
    normals: list[Points] = []
    for half in loop:
        chain = network.chains[half >> 1]
        line, up = chain.directed(half)
        last = len(line) if chain.loose else -1
        points.append(line[:last])
        normals.append(up[:last])
    return np.concatenate(points), np.concatenate(normals)


def loop_encloses(network: Network, loop: tuple[HalfChain, ...]) -> Enclosed:
    """What equation 1 says of a loop."""
    return enclosed(*outline(network, loop))


def possible(network: Network, loop: tuple[HalfChain, ...], corners: tuple[int, ...]) -> bool:
    """May a loop be a patch, whatever it encloses: corners enough, no open end, no mark?"""
    return (
        len(corners) >= FEWEST_CORNERS
        and not any(network.mark(half) for half in loop)
        and not dead_end(network.nodes, network.chains, loop)
    )


def is_patch(network: Network, loop: tuple[HalfChain, ...], corners: tuple[int, ...]) -> bool:
    """Is a loop to be a patch?

    Source: Takayama et al. 2013, section 5.1. Differs from the paper: any number of corners
    from two on, since any such loop has fills; and what equation 1 does not see: strips that are
    bent far around a limb (:mod:`.spanned`), and the ends of limbs (:mod:`.caps`).
    """
    if not possible(network, loop, corners):
        return False
    if loop_encloses(network, loop).length > network.longest:
        return False
    return is_end(network, loop) or (len(corners) == 4 and is_strip(_sides(network, loop, corners)))


def is_end(network: Network, loop: tuple[HalfChain, ...]) -> bool:
    """Does a loop enclose by equation 1, or the end of a limb, which the ground tells?"""
    points, normals = outline(network, loop)
    found = enclosed(points, normals)
    # Clockwise around a piece of the ground seen from outside, it is around the rest of it.
    return found.encloses or (
        found.roundness > -ROUND and is_cap(network, loop, points, found.length)
    )


def _sides(
    network: Network, loop: tuple[HalfChain, ...], corners: tuple[int, ...]
) -> list[tuple[Points, Points]]:
    """(n, 3) points and normals of every side of a loop, both of its corners included."""
    found: list[tuple[Points, Points]] = []
    for begin, end in zip(corners, (*corners[1:], len(loop)), strict=True):
        lines = [network.chains[half >> 1].directed(half) for half in loop[begin:end]]
        found.append(
            (
                np.concatenate([line for line, _ in lines]),
                np.concatenate([up for _, up in lines]),
            )
        )
    return found


def with_patches(
    network: Network,
    nodes: Iterable[int],
    chains: Iterable[int],
    also: Iterable[HalfChain] = (),
    forget: bool = False,
) -> Network:
    """The network with its patches right again, after nodes and chains changed.

    nodes: ids of those whose ends, flags or places changed; chains: of those that are new or
    run elsewhere; ids that are not there any more do no harm. Patches whose loops and corners
    are as they were stay, with their ids and choices, even if their chains moved; all others
    that lost a chain or touch what changed go.

    also:   the loops on the left of these become patches whatever they enclose. Raises
            InvalidRetopoError if one cannot.
    forget: are counts that a patch used, and none does any more, forgotten? Not pinned ones.
    """
    at, lines = network.nodes, network.chains
    forced = set(also)
    starts: set[HalfChain] = set(forced)
    for node in nodes:
        if node in at:
            starts.update(half ^ 1 for half in at[node].ends)
    for chain in chains:
        if chain in lines:
            starts.update((2 * chain, 2 * chain + 1))
    old_of = network.patch_of()
    kept: set[int] = set()
    touched: set[int] = set()
    visited: set[HalfChain] = set()
    made: list[tuple[tuple[HalfChain, ...], tuple[int, ...]]] = []
    for half in sorted(starts):
        if half in visited:
            continue
        loop, corners = face(at, lines, half)
        visited.update(loop)
        touched.update(old_of[h] for h in loop if h in old_of)
        old = network.patches.get(old_of.get(loop[0], -1))
        if old is not None and old.loop == loop and old.corners == corners:
            kept.add(old.id)
        elif not forced.isdisjoint(loop):
            if not possible(network, loop, corners):
                raise InvalidRetopoError(
                    f"the loop of half-chain {loop[0]} can be no patch: it has {len(corners)} "
                    "corners, an open end or a marked side"
                )
            made.append((loop, corners))
        elif is_patch(network, loop, corners):
            made.append((loop, corners))
    gone = {p for half, p in old_of.items() if (half >> 1) not in lines} | (touched - kept)
    if not gone and not made:
        return network
    patches = {p: patch for p, patch in network.patches.items() if p not in gone}
    next_id = network.next_id
    for loop, corners in made:
        patches[next_id] = Patch(next_id, loop, corners)
        next_id += 1
    result = replace(network, patches=patches, next_id=next_id)
    if forget:
        unused = _unused(result, (network.patches[p] for p in gone))
        result = replace(result, chains={**lines, **unused})
    return result


def without_patch(network: Network, patch: int) -> Network:
    """The network with a patch less; counts that only it used, and no user chose, are forgotten."""
    patches = {p: one for p, one in network.patches.items() if p != patch}
    result = replace(network, patches=patches)
    unused = _unused(result, [network.patches[patch]])
    return replace(result, chains={**network.chains, **unused})


def _unused(network: Network, gone: Iterable[Patch]) -> dict[int, Chain]:
    """The chains of dissolved patches that no patch uses now, without their counts."""
    used = {half >> 1 for patch in network.patches.values() for half in patch.loop}
    found: dict[int, Chain] = {}
    for patch in gone:
        for chain in {half >> 1 for half in patch.loop} - used:
            line = network.chains.get(chain)
            if line is not None and line.count and not line.pinned:
                found[chain] = replace(line, count=0)
    return found
