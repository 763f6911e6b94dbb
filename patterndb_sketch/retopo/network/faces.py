"""Walk around the faces of a network, find its parts, and count the handles that it goes round."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network.structure import NONE, Chain, HalfChain, Node


def find_successor(
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
    return at.ends[wedge], at.corner_flags[wedge]


def walk_face(
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
        at, corner = find_successor(nodes, chains, at)
        if at == half:
            leaves_corner[0] = corner
            break
    firsts = [k for k, corner in enumerate(leaves_corner) if corner] or range(len(loop))
    first = min(firsts, key=loop.__getitem__)
    loop = loop[first:] + loop[:first]
    leaves_corner = leaves_corner[first:] + leaves_corner[:first]
    return tuple(loop), tuple(k for k, corner in enumerate(leaves_corner) if corner)


def list_face(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], half: HalfChain
) -> list[HalfChain]:
    """The half-chains around the face on the left of one, from that one on."""
    loop = [half]
    at, _ = find_successor(nodes, chains, half)
    while at != half:
        loop.append(at)
        at, _ = find_successor(nodes, chains, at)
    return loop


def find_joined_chains(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], chain: int
) -> set[int]:
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


def has_dead_end(
    nodes: Mapping[int, Node], chains: Mapping[int, Chain], loop: tuple[HalfChain, ...]
) -> bool:
    """Does a loop turn round at an open end?"""
    for half in loop:
        chain = chains[half >> 1]
        node = chain.start if half & 1 else chain.end
        if node != NONE and len(nodes[node].ends) == 1:
            return True
    return False


Indices = NDArray[np.signedinteger[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceParts:
    """What hangs together on a surface, across its edges.

    part: (t,) the part of each triangle, 0 to parts - 1. fan: (3t,) the fan of triangles around a
    vertex that each corner belongs to, 0 to fans - 1: where parts touch in a vertex, it has
    several.
    """

    parts: int
    part: Indices
    fans: int
    fan: Indices

    @classmethod
    def of(cls, surface: Surface) -> SurfaceParts:
        """Of a surface, in linear time."""
        return cls.of_triangles(surface.triangles, surface.adjacency.across)

    @classmethod
    def of_triangles(cls, triangles: Int32Array, across: Int32Array) -> SurfaceParts:
        """Of triangles (t, 3), and what is across their sides (3t,), -1 where that is nothing."""
        corner = triangles.ravel()
        # A corner is named by the side that begins there.
        side = np.flatnonzero(across >= 0)
        other = across[side]
        alike = corner[side] == corner[other]
        fans, fan = _group_pairs(
            len(corner),
            np.r_[side, _follow(side)],
            np.r_[
                np.where(alike, other, _follow(other)),
                np.where(alike, _follow(other), other),
            ],
        )
        parts, part = _group_pairs(len(triangles), side // 3, other // 3)
        return cls(parts, part, fans, fan)

    def count_euler(self, across: Int32Array) -> NDArray[np.intp]:
        """(parts,) of each part V - E + F: 1 of a disk, 0 with a hole in it, and 2 less for every
        handle. across: as it was made of; a vertex counts for every fan of triangles around it."""
        _, first = np.unique(self.fan, return_index=True)
        corners = np.bincount(self.part[first // 3], minlength=self.parts)
        # An inner edge has two sides.
        halves = np.bincount(
            np.repeat(self.part, 3), weights=np.where(across < 0, 2, 1), minlength=self.parts
        )
        faces = np.bincount(self.part, minlength=self.parts)
        return (corners - halves / 2.0 + faces).astype(np.intp)


def _follow(side: Indices) -> Indices:
    """The sides after these, around their triangles."""
    return side - side % 3 + (side + 1) % 3


def count_handles(surface: Surface) -> int:
    """How many handles a surface has, in all its parts; borders count as closed by disks.

    Of each part V - E + F = 2 - 2 g. A vertex counts for every fan of triangles around it.
    """
    found = SurfaceParts.of(surface)
    across = surface.adjacency.across
    border = np.flatnonzero(across < 0)
    ends = found.fan[border], found.fan[_follow(border)]
    _, loop = _group_pairs(found.fans, *ends)
    loops = len(np.unique(loop[ends[0]]))
    return (2 * found.parts - int(found.count_euler(across).sum()) - loops) // 2


def count_genus(nodes: Mapping[int, Node], chains: Mapping[int, Chain]) -> int:
    """How many handles of its surface a network goes round, by Euler's formula over its faces.

    0 in the plane and on a ball: else curves cross that do not meet, or the order of ends around
    a node is not that in which they lie.
    """
    left = set(chains)
    parts = 0
    while left:
        left -= find_joined_chains(nodes, chains, next(iter(left)))
        parts += 1
    seen: set[HalfChain] = set()
    faces = loose = 0
    for chain in chains.values():
        loose += chain.start == NONE
        for half in (2 * chain.id, 2 * chain.id + 1):
            if half not in seen:
                seen.update(list_face(nodes, chains, half))
                faces += 1
    used = sum(1 for node in nodes.values() if node.ends)
    # A closed chain without a node counts as if it had one.
    return (2 * parts - (used + loose - len(chains) + faces)) // 2


def _group_pairs(n: int, one: Indices, two: Indices) -> tuple[int, NDArray[np.int32]]:
    """How many groups pairs of n things make, and the group of each."""
    pairs = coo_array((np.ones(len(one), np.bool_), (one, two)), (n, n))
    count, group = connected_components(pairs, directed=False)
    return int(count), group
