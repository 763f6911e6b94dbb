"""Handles: how many the ground has, and how many of them a network goes round."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.structure import NONE, Chain, HalfChain, Node
from patterndb_sketch.retopo.network.walks import joined_chains, walked

Indices = NDArray[np.signedinteger[Any]]


def handles_of(ground: Ground) -> int:
    """How many handles a surface has, in all its parts; borders count as closed by disks.

    Of each part V - E + F = 2 - 2 g. A vertex counts for every fan of triangles around it.
    """
    triangles, across = ground.triangles, ground.topology.across
    n = 3 * len(triangles)
    side = np.arange(n)
    # A corner is named by the side that begins there.
    after = side - side % 3 + (side + 1) % 3
    inner, border = np.flatnonzero(across >= 0), np.flatnonzero(across < 0)
    other = across[inner]
    corners = triangles.ravel()
    alike = corners[inner] == corners[other]
    vertices, vertex = _joined(
        n,
        np.concatenate([inner, after[inner]]),
        np.concatenate(
            [np.where(alike, other, after[other]), np.where(alike, after[other], other)]
        ),
    )
    parts, _ = _joined(len(triangles), inner // 3, other // 3)
    ends = vertex[border], vertex[after[border]]
    _, loop = _joined(vertices, *ends)
    loops = len(np.unique(loop[ends[0]]))
    euler = vertices - (len(inner) // 2 + len(border)) + len(triangles) + loops
    return (2 * parts - euler) // 2


def genus_of(nodes: Mapping[int, Node], chains: Mapping[int, Chain]) -> int:
    """How many handles of its surface a network goes round, by Euler's formula over its faces.

    0 in the plane and on a ball: else curves cross that do not meet, or the order of ends around
    a node is not that in which they lie.
    """
    left = set(chains)
    parts = 0
    while left:
        left -= joined_chains(nodes, chains, next(iter(left)))
        parts += 1
    seen: set[HalfChain] = set()
    faces = loose = 0
    for chain in chains.values():
        loose += chain.start == NONE
        for half in (2 * chain.id, 2 * chain.id + 1):
            if half not in seen:
                seen.update(walked(nodes, chains, half))
                faces += 1
    used = sum(1 for node in nodes.values() if node.ends)
    # A closed chain without a node counts as if it had one.
    return (2 * parts - (used + loose - len(chains) + faces)) // 2


def _joined(n: int, one: Indices, two: Indices) -> tuple[int, NDArray[np.int32]]:
    """How many groups pairs of n things make, and the group of each."""
    pairs = coo_array((np.ones(len(one), np.bool_), (one, two)), (n, n))
    count, group = connected_components(pairs, directed=False)
    return int(count), group
