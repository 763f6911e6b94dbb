"""The border of a patch: where its boundary vertices lie."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import SYMMETRY, Chain, HalfChain, Network, Patch


def divided(chain: Chain) -> tuple[Points, Points]:
    """(count + 1, 3) points and normals that divide a chain evenly by arc length.

    Ends are the chain's own, bit for bit: patches on both sides, and chains at one node, share
    them.
    """
    line = chain.round
    up = np.concatenate([chain.normals, chain.normals[:1]]) if chain.loose else chain.normals
    along = arc_length(line)
    wanted = np.linspace(0.0, along[-1], chain.count + 1)
    points = np.stack([np.interp(wanted, along, line[:, d]) for d in range(3)], axis=1)
    normals = units(np.stack([np.interp(wanted, along, up[:, d]) for d in range(3)], axis=1))
    points[0], points[-1] = line[0], line[-1]
    normals[0], normals[-1] = up[0], up[-1]
    return points, normals


def half_divided(network: Network, half: HalfChain) -> tuple[Points, Points]:
    """The same in the direction of a half-chain."""
    points, normals = divided(network.chains[half >> 1])
    return (points[::-1], normals[::-1]) if half & 1 else (points, normals)


def laid_border(network: Network, patch: Patch, ground: Ground) -> Points:
    """(P, 3) points around a patch, from its first corner on, each on the ground.

    Between its samples a chain cuts across the ground's edges; points of it are taken to the
    nearest triangle that faces as they do, each by itself, so that both sides still share them.
    Nodes are on the ground already, and what is on the plane of symmetry stays there exactly.
    """
    parts: list[Points] = []
    for half in patch.loop:
        points, normals = half_divided(network, half)
        points, normals = points[:-1].copy(), normals[:-1]
        if len(points) > 1 and SYMMETRY not in network.chains[half >> 1].marks:
            points[1:] = ground.nearest_facing(points[1:], normals[1:]).points
        parts.append(points)
    return np.concatenate(parts)


def border(network: Network, patch: Patch) -> tuple[Points, Points]:
    """(P, 3) points and normals around a patch, from its first corner on."""
    parts = [half_divided(network, half) for half in patch.loop]
    return (
        np.concatenate([points[:-1] for points, _ in parts]),
        np.concatenate([normals[:-1] for _, normals in parts]),
    )
