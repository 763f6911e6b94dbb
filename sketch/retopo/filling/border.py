"""The border of a patch: where its boundary vertices lie."""

from __future__ import annotations

import numpy as np

from query.placing.shape import units
from query.placing.surface import Points
from query.polyline import arc_length
from sketch.retopo.network import Chain, HalfChain, Network, Patch


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


def border(network: Network, patch: Patch) -> tuple[Points, Points]:
    """(P, 3) points and normals around a patch, from its first corner on."""
    parts = [half_divided(network, half) for half in patch.loop]
    return (
        np.concatenate([points[:-1] for points, _ in parts]),
        np.concatenate([normals[:-1] for _, normals in parts]),
    )
