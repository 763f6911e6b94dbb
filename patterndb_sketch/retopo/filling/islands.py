"""Islands: parts of the network that lie within a patch, joined to none of its sides.

A patch is the loop around it, whatever else is drawn in there. Its quads would lie over those of
patches within; so it has none until a curve joins both, and makes other loops of them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.retopo.filling.finding import is_within
from patterndb_sketch.retopo.filling.placing import Placed
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Network, outline
from patterndb_sketch.retopo.network.walks import joined_chains


def around_islands(
    network: Network, ground: Ground, placed: Mapping[int, Placed]
) -> dict[int, int]:
    """Placed patches within which others lie, of other parts of the network: for each one of
    those. Curves without a patch are no islands: they may be about to be joined."""
    part: dict[int, int] = {}
    for chain in sorted(network.chains):
        if chain not in part:
            part.update(dict.fromkeys(joined_chains(network.nodes, network.chains, chain), chain))
    of = {patch: part[network.patches[patch].loop[0] >> 1] for patch in sorted(placed)}
    first = {name: patch for patch, name in reversed(of.items())}
    if len(first) < 2:
        return {}
    # A part lies within a patch if any place of it does, for no curves cross.
    places = {name: _start(network, p) for name, p in first.items()}
    found: dict[int, int] = {}
    for patch, name in of.items():
        there = [other for other in first if other != name and _near(placed[patch], places[other])]
        if not there:
            continue
        border = outline(network, network.patches[patch].loop)
        for other in there:
            foot = ground.nearest(places[other][None])
            if is_within(ground, border, foot):
                found[patch] = first[other]
                break
    return found


def _start(network: Network, patch: int) -> NDArray[np.float64]:
    half = network.patches[patch].loop[0]
    return network.chains[half >> 1].directed(half)[0][0]


def _near(placed: Placed, point: NDArray[np.float64]) -> bool:
    """Is a point (3,) as near to a vertex of the quads as those on them are?"""
    corner = placed.vertices[placed.quads]
    across = max(
        float(np.linalg.norm(corner[:, k] - corner[:, k + 2], axis=1).max()) for k in (0, 1)
    )
    return float(np.linalg.norm(placed.vertices - point, axis=1).min()) <= across
