"""What always holds of a network, and when two are the same bit for bit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from patterndb.errors import PatternDBError
from patterndb_sketch.retopo.network.faces import count_genus, count_handles, walk_face
from patterndb_sketch.retopo.network.patches import is_patch, may_be_patch
from patterndb_sketch.retopo.network.structure import MARKS, NONE, HalfChain, Network

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
        least = 3 if chain.loose else 2
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
        if chain.loose:
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
        _hold(len(node.flagged) == len(node.ends), where, "not a flag for each wedge")
        for half in node.ends:
            _hold((half >> 1) in network.chains, where, f"half-chain {half} is not there")
            _hold(network.origin(half) == node.id, where, f"half-chain {half} leaves another")
        _hold(any(node.flagged) != node.open, where, "flags: none at an open end, else one")
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
