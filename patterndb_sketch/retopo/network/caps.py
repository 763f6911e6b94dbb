"""Loops around the end of a limb: what equation 1 does not see, the ground tells.

The ring around a fingertip, or below the sharp rim of a foot, has normals that point away from its
axis: seen along them it encloses nothing. But what is beyond it is a small piece of the ground, a
disk, and empty.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.flooding import CLEAR, flooded, wall_of
from patterndb_sketch.retopo.network.structure import HalfChain, Network

#: The ground beyond a loop has at most this many times the area of the flat disk with the loop's
#: length, l^2 / 4 pi. Half a ball has 2; a fingertip, which is half a ball on a piece of the finger
#: a quarter as long as it is thick, 3. A hand beyond the wrist has some 8, a foot 12.
ROUNDNESS = 3.0

#: Of the triangles beside a loop that the flooding reached, this many times as many must be on
#: its left as on its right: else the loop parts nothing, as one around a handle.
LEFT = 3


def is_cap(network: Network, loop: tuple[HalfChain, ...], points: Points, length: float) -> bool:
    """Is the ground on the left of a loop (n, 3) an empty disk, no larger than a cap?

    False where the network knows no ground, and where the loop lies within a few triangles, which
    are flat, so that equation 1 sees it. Costs no more than looking at that much of the ground.
    """
    ground = network.ground
    if ground is None or length <= 0.0:
        return False
    wall = wall_of(ground, [(points, True)])
    if wall is None:
        return False
    most = ROUNDNESS * length**2 / (4.0 * math.pi)
    # What is crossed counts if its middle is beyond the loop.
    walls = np.flatnonzero(wall.crossed).astype(np.int32)
    most -= float(ground.surface.areas[walls[wall.side_of(ground, walls)[1] > 0.0]].sum())
    _, side = wall.side_of(ground, wall.beside)
    found = flooded(ground, wall.crossed, wall.beside[side > CLEAR], most)
    if found is None or len(found[0]) == 0:
        return False
    inside = np.zeros(len(ground.triangles), np.bool_)
    inside[found[0]] = True
    return (
        _on_left(side[inside[wall.beside]])
        and _is_disk(ground, inside | wall.crossed)
        and not _curve_within(network, {half >> 1 for half in loop}, ground, found[0], inside)
    )


def _on_left(side: NDArray[np.float64]) -> bool:
    return int((side > CLEAR).sum()) >= LEFT * int((side < -CLEAR).sum())


def _is_disk(ground: Ground, inside: NDArray[np.bool_]) -> bool:
    """Euler's formula: V - E + F = 1 of a disk; 0 where there is a hole in it, or a handle."""
    triangles = ground.triangles[inside]
    edges = ground.topology.edges.reshape(-1, 3)[inside]
    return len(np.unique(triangles)) - len(np.unique(edges)) + len(triangles) == 1


def _curve_within(
    network: Network,
    own: set[int],
    ground: Ground,
    found: Int32Array,
    inside: NDArray[np.bool_],
) -> bool:
    """Does a curve that is none of the loop's lie on the triangles?"""
    corners = ground.vertices[ground.triangles[found].ravel()]
    low, high = corners.min(axis=0), corners.max(axis=0)
    samples = [
        chain.points[[0, len(chain.points) // 2, -1]]
        for chain in network.chains.values()
        if chain.id not in own
        and (chain.points.max(axis=0) >= low).all()
        and (chain.points.min(axis=0) <= high).all()
    ]
    if not samples:
        return False
    return bool(inside[ground.nearest(np.concatenate(samples)).triangles].any())
