"""Faces of a mesh that was given, triangles and larger polygons, which stay as they are.

Each is a face of the network: a loop of chains that are marked FACE on its side, each of one edge,
pinned. So the curves around it are neither erased nor moved, no patch is ever there, and nothing
but the network has to be kept.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.faces import walk_face
from patterndb_sketch.retopo.network.structure import FACE, Chain, HalfChain, Network
from patterndb_sketch.retopo.wording import format_place

#: What is nearer to a face's border than this part of its size is on it, not within.
ON_EDGE = 1e-3


def list_kept_faces(network: Network) -> list[tuple[HalfChain, ...]]:
    """The loops of half-chains around all kept faces, counter-clockwise, by their lowest."""
    seen: set[HalfChain] = set()
    found: list[tuple[HalfChain, ...]] = []
    for chain in sorted(network.chains):
        for half in (2 * chain, 2 * chain + 1):
            if network.mark(half) == FACE and half not in seen:
                loop, _ = walk_face(network.nodes, network.chains, half)
                seen.update(loop)
                found.append(loop)
    return found


def check_kept_faces(before: Network, after: Network) -> None:
    """RefusedError, with the place, if an edit changed a kept face, or drew a curve into one."""
    loops = list_kept_faces(before)
    if not loops:
        return
    there = set(list_kept_faces(after))
    for loop in loops:
        same = loop in there and all(
            _is_same(before.chains[half >> 1], after.chains[half >> 1]) for half in loop
        )
        if not same:
            raise RefusedError(
                f"a face that was given, of {len(loop)} edges at "
                f"{format_place(_corners(before, loop).mean(axis=0))}, would change: it stays as "
                "it is, one edge to each side; end curves at its corners"
            )
    new = [chain for key, chain in after.chains.items() if before.chains.get(key) is not chain]
    for loop in loops:
        corners = _corners(before, loop)
        for chain in new:
            if not chain.marked and lies_within(corners, chain.points, chain.normals).any():
                raise RefusedError(
                    f"the curve would lie in a face that was given, at "
                    f"{format_place(corners.mean(axis=0))}: it stays as it is; draw beside it"
                )


def lies_within(corners: Points, points: Points, normals: Points) -> NDArray[np.bool_]:
    """(n,) which points (n, 3) of the surface, with its normals there, are within a polygon (k, 3),
    counter-clockwise, and not on its border: seen along its normal, and no further from its plane
    than it is wide."""
    middle = corners.mean(axis=0)
    around = np.roll(corners, -1, axis=0)
    up = units(np.cross(corners - middle, around - middle).sum(axis=0)[None])[0]
    size = float(np.linalg.norm(corners - middle, axis=1).max())
    off = points - middle
    near = (np.linalg.norm(off, axis=1) < size) & (normals @ up > 0.0)
    x = units((corners[0] - middle - (corners[0] - middle) @ up * up)[None])[0]
    y = np.cross(up, x)
    flat = np.stack([off @ x, off @ y], axis=1)
    a = np.stack([(corners - middle) @ x, (corners - middle) @ y], axis=1)
    step = np.roll(a, -1, axis=0) - a
    rest = flat[:, None] - a
    share = (rest * step).sum(axis=2) / np.maximum((step**2).sum(axis=1), 1e-300)
    foot = rest - np.clip(share, 0.0, 1.0)[..., None] * step
    clear = np.linalg.norm(foot, axis=2).min(axis=1) > ON_EDGE * size
    # A ray along x meets the border an odd number of times.
    above = rest[..., 1] < 0.0
    crosses = above != np.roll(above, -1, axis=1)
    level = np.where(step[:, 1] == 0.0, 1.0, step[:, 1])
    right = a[:, 0] + step[:, 0] * (flat[:, 1:] - a[:, 1]) / level > flat[:, :1]
    return near & clear & ((crosses & right).sum(axis=1) % 2 == 1)


def _corners(network: Network, loop: tuple[HalfChain, ...]) -> Points:
    return np.stack([network.nodes[network.origin(half)].point for half in loop])


def _is_same(one: Chain, two: Chain) -> bool:
    return one is two or (
        (one.count, one.pinned, one.marks) == (two.count, two.pinned, two.marks)
        and np.array_equal(one.points, two.points)
    )
