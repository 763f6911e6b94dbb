"""What a curve crosses that it was not seen to cross, where chains lie over each other.

After curves were pulled, or drawn along each other, chains may lie over each other without a node,
and a curve may come, without crossing any, from a face to another. The chains between the two
faces tell what it must have crossed: of all ways from face to face it is that along which they
are nearest to the curve.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node
from patterndb_sketch.retopo.network.walks import walked

#: What each chain that is crossed costs beside its distance, as a part of the curve's length: of
#: two ways it is that across fewer.
CROSSED = 1e-3


def between_faces(
    nodes: Mapping[int, Node],
    chains: Mapping[int, Chain],
    line: Points,
    ends: tuple[int, int],
    reach: float,
) -> list[tuple[HalfChain, float, float]]:
    """The half-chains that a curve (n, 3) from a node to another crosses from left to right, in
    order, with the place on each chain, and the place on the curve, both in samples.

    reach: how far from the curve that is at most. Chains with a marked side are never crossed.
    Empty if there is no way.
    """
    tree = KDTree(line)
    length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    costs: dict[int, tuple[float, float, float]] = {}

    def cost(chain: int) -> tuple[float, float, float]:
        if chain not in costs:
            away, k = map(np.asarray, tree.query(chains[chain].points))
            best = int(away.argmin())
            costs[chain] = float(away[best]) + CROSSED * length, float(best), float(k[best])
        return costs[chain]

    face: dict[HalfChain, HalfChain] = {}
    loops: dict[HalfChain, list[HalfChain]] = {}

    def face_of(half: HalfChain) -> HalfChain:
        if half not in face:
            loops[half] = walked(nodes, chains, half)
            face.update(dict.fromkeys(loops[half], half))
        return face[half]

    goals = {face_of(half) for half in nodes[ends[1]].ends}
    reached: dict[HalfChain, float] = {face_of(half): 0.0 for half in nodes[ends[0]].ends}
    came: dict[HalfChain, HalfChain] = {}
    queue = [(0.0, at) for at in reached]
    heapq.heapify(queue)
    while queue:
        so_far, at = heapq.heappop(queue)
        if so_far > reached[at]:
            continue
        if at in goals:
            way: list[HalfChain] = []
            while at in came:
                way.append(came[at])
                at = face_of(came[at])
            return [(half, *cost(half >> 1)[1:]) for half in way[::-1]]
        for half in loops[at]:
            away = cost(half >> 1)[0]
            if chains[half >> 1].marked or away > reach + CROSSED * length:
                continue
            beyond = face_of(half ^ 1)
            new = so_far + away
            if new < reached.get(beyond, float("inf")):
                reached[beyond] = new
                came[beyond] = half
                heapq.heappush(queue, (new, beyond))
    return []
