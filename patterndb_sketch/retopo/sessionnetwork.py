"""A network as a document of JSON and named arrays, as sessions keep it.

The document has what nodes, chains and patches are, in the order in which the network has them;
the arrays have their points, one after another in the same order:

- nodes (n, 6), chains (s, 6): points and normals of nodes, and of the samples of all chains;
- quads (q, 4): of the fills of all patches; codes (c,): their patterns' codes;
- lines (l, 3): points of flow lines; moved (m,), places (m, 3): vertices moved by hand.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.documents import JsonValue
from patterndb_sketch.retopo.network import (
    NONE,
    BrokenNetworkError,
    Chain,
    Network,
    Node,
    check_network,
)
from patterndb_sketch.retopo.sessionfills import (
    ARRAYS,
    MOST,
    Taken,
    entries_of,
    number,
    numbers,
    patch_document,
    patch_of,
)

KEYS = ("next_id", "longest", "nodes", "chains", "patches")
NODE_KEYS = ("id", "ends", "flagged", "cut")
CHAIN_KEYS = ("id", "start", "end", "samples", "count", "pinned", "marks")


def network_document(network: Network) -> tuple[dict[str, object], dict[str, NDArray[Any]]]:
    """A network's document and arrays; :func:`network_of` gives it back bit for bit.

    Raises InvalidRetopoError for a patch whose choice is no Filling.
    """
    parts: dict[str, list[NDArray[Any]]] = {name: [] for name in ARRAYS}
    for node in network.nodes.values():
        parts["nodes"].append(np.concatenate([node.point, node.normal])[None])
    for chain in network.chains.values():
        parts["chains"].append(np.concatenate([chain.points, chain.normals], axis=1))
    document: dict[str, object] = {
        "next_id": network.next_id,
        "longest": network.longest if math.isfinite(network.longest) else None,
        "nodes": [
            {
                "id": node.id,
                "ends": list(node.ends),
                "flagged": list(node.flagged),
                "cut": node.cut,
            }
            for node in network.nodes.values()
        ],
        "chains": [
            {
                "id": chain.id,
                "start": chain.start,
                "end": chain.end,
                "samples": len(chain.points),
                "count": chain.count,
                "pinned": chain.pinned,
                "marks": list(chain.marks),
            }
            for chain in network.chains.values()
        ],
        "patches": [patch_document(patch, parts) for patch in network.patches.values()],
    }
    return document, {name: _joined(parts[name], *ARRAYS[name]) for name in ARRAYS}


def network_of(value: JsonValue, arrays: Mapping[str, NDArray[Any]]) -> Network:
    """The network of a document and its arrays, of the types that ARRAYS says.

    Raises InvalidRetopoError that names the place for anything that is not what it must be, and
    where the invariants of networks do not hold.
    """
    entries = entries_of(value, KEYS)
    take = Taken(arrays)
    longest = math.inf
    if entries["longest"].value is not None:
        longest = entries["longest"].number()
    nodes = [_node(one, take) for one in entries["nodes"].items()]
    chains = [_chain(one, take) for one in entries["chains"].items()]
    _check_named(entries, nodes, chains)
    there = {chain.id for chain in chains}
    patches = [patch_of(one, take, there) for one in entries["patches"].items()]
    take.check_all()
    network = Network(
        {node.id: node for node in nodes},
        {chain.id: chain for chain in chains},
        {patch.id: patch for patch in patches},
        number(entries["next_id"], most=MOST),
        longest,
    )
    if sum(map(len, (nodes, chains, patches))) > sum(
        map(len, (network.nodes, network.chains, network.patches))
    ):
        value.fail("an id is used twice")
    try:
        # Patches stay as they are while chains move: not every loop need be one.
        check_network(network, patches=False)
    except BrokenNetworkError as error:
        value.fail(f"{error}; the file was changed, or a fault wrote it")
    return network


def _node(value: JsonValue, take: Taken) -> Node:
    entries = entries_of(value, NODE_KEYS)
    row = take.next("nodes", 1, value)[0]
    return Node(
        number(entries["id"]),
        row[:3].copy(),
        row[3:].copy(),
        numbers(entries["ends"]),
        tuple(one.truth() for one in entries["flagged"].items()),
        entries["cut"].truth(),
    )


def _chain(value: JsonValue, take: Taken) -> Chain:
    entries = entries_of(value, CHAIN_KEYS)
    rows = take.rows("chains", entries["samples"], least=2)
    marks = [one.text() for one in entries["marks"].items()]
    if len(marks) != 2:
        entries["marks"].fail("a chain has two marks, of its left and its right")
    return Chain(
        number(entries["id"]),
        number(entries["start"], least=NONE),
        number(entries["end"], least=NONE),
        np.ascontiguousarray(rows[:, :3]),
        np.ascontiguousarray(rows[:, 3:]),
        number(entries["count"]),
        entries["pinned"].truth(),
        (marks[0], marks[1]),
    )


def _check_named(entries: Mapping[str, JsonValue], nodes: list[Node], chains: list[Chain]) -> None:
    """Are all nodes and half-chains there that chains and nodes name?"""
    ids = {node.id for node in nodes} | {NONE}
    halves = {2 * chain.id + side for chain in chains for side in (0, 1)}
    for chain, where in zip(chains, entries["chains"].items(), strict=True):
        if not {chain.start, chain.end} <= ids:
            where.fail(f"there is no node {chain.start} or {chain.end}")
    for node, where in zip(nodes, entries["nodes"].items(), strict=True):
        if not set(node.ends) <= halves:
            where.fail(f"there is no half-chain {min(set(node.ends) - halves)}")


def _joined(parts: list[NDArray[Any]], kind: str, row: int) -> NDArray[Any]:
    empty = np.empty((0, row) if row else 0, kind)
    return np.ascontiguousarray(np.concatenate([empty, *parts]), kind)
