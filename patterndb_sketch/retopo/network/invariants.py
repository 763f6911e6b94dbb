"""What always holds of a network, what an edit must leave as it is, and when two are the same.

Faces of a mesh that was given, triangles and larger polygons, stay as they are. Each is a face of
the network: a loop of chains that are marked FACE on its side, each of one edge, pinned. So the
curves around it are neither erased nor moved, no patch is ever there.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.faces import count_genus, count_handles, walk_face
from patterndb_sketch.retopo.network.patches import is_patch, may_be_patch
from patterndb_sketch.retopo.network.structure import FACE, MARKS, NONE, Chain, HalfChain, Network
from patterndb_sketch.retopo.wording import format_place

#: Lengths of normals are 1 to this.
UNIT = 1e-6


class BrokenNetworkError(PatternDBError, AssertionError):
    """An invariant of a network does not hold: an edit went wrong, or a file was changed."""


def check_network(network: Network, patches: bool = True) -> None:
    """Raise BrokenNetworkError, naming the place, for the first invariant that does not hold.

    patches: must every loop that encloses be a patch, too? Not after chains moved: patches then
    stay as they are.
    """
    _check_ids(network)
    for chain in network.chains.values():
        where = f"chain {chain.id}"
        least = 3 if chain.is_closed_loop else 2
        _hold(chain.points.shape == (len(chain.points), 3), where, "points are not (n, 3)")
        _hold(chain.normals.shape == chain.points.shape, where, "a normal for each point")
        _hold(len(chain.points) >= least, where, f"fewer than {least} points")
        _hold(bool(np.isfinite(chain.points).all()), where, "a point is not finite")
        lengths = np.linalg.norm(chain.normals, axis=1)
        _hold(bool((abs(lengths - 1.0) <= UNIT).all()), where, "a normal has not length 1")
        _hold(chain.length > 0.0, where, "it has no length")
        _hold(chain.count >= 0, where, "its count is below 0")
        _hold(chain.count > 0 or not chain.pinned, where, "pinned without a count")
        _hold(set(chain.marks) <= set(MARKS), where, f"unknown marks {chain.marks}")
        _hold((chain.start == NONE) == (chain.end == NONE), where, "one end without a node")
        if chain.is_closed_loop:
            continue
        for half, node, k in ((2 * chain.id, chain.start, 0), (2 * chain.id + 1, chain.end, -1)):
            _hold(node in network.nodes, where, f"node {node} is not there")
            at = network.nodes[node]
            _hold(at.ends.count(half) == 1, where, f"not once among the ends of node {node}")
            same = (chain.points[k] == at.point).all() and (chain.normals[k] == at.normal).all()
            _hold(bool(same), where, f"does not end exactly at node {node}")
    for node in network.nodes.values():
        where = f"node {node.id}"
        _hold(len(node.ends) > 0, where, "no chain ends there")
        _hold(len(node.corner_flags) == len(node.ends), where, "not a flag for each wedge")
        for half in node.ends:
            _hold((half >> 1) in network.chains, where, f"half-chain {half} is not there")
            _hold(network.origin(half) == node.id, where, f"half-chain {half} leaves another")
        _hold(any(node.corner_flags) != node.open, where, "flags: none at an open end, else one")
    genus = count_genus(network.nodes, network.chains)
    if genus and network.surface is not None:
        handles = count_handles(network.surface)
        wrong = f"it goes round {genus} handles, and the surface has {handles}"
        _hold(genus <= handles, "the order around nodes", wrong)
    _check_patches(network)
    if patches:
        _check_loops(network)


def _check_ids(network: Network) -> None:
    for name, things in (
        ("node", network.nodes),
        ("chain", network.chains),
        ("patch", network.patches),
    ):
        for key, thing in things.items():
            _hold(key == thing.id, f"{name} {key}", f"is kept as {thing.id}")
            _hold(0 <= key < network.next_id, f"{name} {key}", "is not below next_id")
    count = len(network.nodes) + len(network.chains) + len(network.patches)
    different = len({*network.nodes, *network.chains, *network.patches})
    _hold(count == different, "the network", "an id is used twice")


def _check_patches(network: Network) -> None:
    seen: set[HalfChain] = set()
    for patch in network.patches.values():
        where = f"patch {patch.id}"
        for half in patch.loop:
            _hold((half >> 1) in network.chains, where, f"half-chain {half} is not there")
        walked = walk_face(network.nodes, network.chains, patch.loop[0])
        _hold(walked == (patch.loop, patch.corners), where, "its loop is not a face")
        _hold(may_be_patch(network, *walked), where, "open end, mark, or fewer than 2 corners")
        _hold(seen.isdisjoint(patch.loop), where, "shares a half-chain with another")
        seen.update(patch.loop)


def _check_loops(network: Network) -> None:
    seen = set(network.patch_of())
    for chain in network.chains:
        for half in (2 * chain, 2 * chain + 1):
            if half not in seen:
                loop, corners = walk_face(network.nodes, network.chains, half)
                seen.update(loop)
                wrong = is_patch(network, loop, corners)
                _hold(not wrong, f"half-chain {half}", "its loop encloses, and is no patch")


def are_equal(one: Network, two: Network) -> bool:
    """Are two networks the same, bit for bit: ids, arrays, flags, counts, patches, order and
    density?"""
    if (one.next_id, one.longest, one.density) != (two.next_id, two.longest, two.density):
        return False
    pairs: tuple[tuple[Mapping[int, object], Mapping[int, object]], ...] = (
        (one.nodes, two.nodes),
        (one.chains, two.chains),
        (one.patches, two.patches),
    )
    return all(a.keys() == b.keys() and all(_equal(a[key], b[key]) for key in a) for a, b in pairs)


def _equal(one: object, two: object) -> bool:
    if one is two:
        return True
    if type(one) is not type(two):
        return False
    for name in type(one).__slots__:  # pyright: ignore[reportAttributeAccessIssue]
        a, b = getattr(one, name), getattr(two, name)
        if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
            if a.shape != b.shape or a.tobytes() != b.tobytes():
                return False
        elif a != b:
            return False
    return True


def _hold(condition: bool, where: str, what: str) -> None:
    if not condition:
        raise BrokenNetworkError(f"{where}: {what}")


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
                    f"{format_place(corners.mean(axis=0))}: it stays as it is; draw next to it"
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
