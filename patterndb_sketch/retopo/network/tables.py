"""The nodes and chains of a network while they change, and what old names mean now."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.cutting import Cut
from patterndb_sketch.retopo.network.gaps import Gap
from patterndb_sketch.retopo.network.structure import HalfChain, Network, Node


class Tables:
    """What a draft changes in place.

    before: the network that it began with. nodes, chains: as they are now.
    cuts:   of chains that were cut, by their ids. same: of nodes that went into another.
    gaps:   of ends whose gaps were given.
    touched_nodes:  whose ends, flags or place changed. touched_chains: that are new or run
                    elsewhere.
    """

    def __init__(self, network: Network) -> None:
        self.before = network
        self.nodes = dict(network.nodes)
        self.chains = dict(network.chains)
        self.next_id = network.next_id
        self.cuts: dict[int, Cut] = {}
        self.same: dict[int, int] = {}
        self.gaps: dict[HalfChain, Gap] = {}
        self.touched_nodes: set[int] = set()
        self.touched_chains: set[int] = set()

    # What old names mean now

    def located(self, chain: int, place: float) -> tuple[int, float]:
        """The chain and place that a chain and place, perhaps of before a cut, are now."""
        while chain in self.cuts:
            chain, place = self.cuts[chain].moved(place)
        if chain not in self.chains:
            raise InvalidRetopoError(f"there is no chain {chain} in the network")
        return chain, place

    def pieces(self, chains: Iterable[int]) -> set[int]:
        """What chains, perhaps of before cuts, are now."""
        found: set[int] = set()
        left = list(chains)
        while left:
            chain = left.pop()
            if chain in self.cuts:
                left += self.cuts[chain].pieces
            elif chain in self.chains:
                found.add(chain)
        return found

    def half_now(self, half: HalfChain) -> HalfChain:
        """The half-chain that leaves the same node as one of before a cut."""
        while (half >> 1) in self.cuts:
            pieces = self.cuts[half >> 1].pieces
            half = 2 * pieces[-(half & 1)] + (half & 1)
        return half

    def node_now(self, node: int) -> int:
        """The node that a node is now, if it went into another."""
        while node in self.same:
            node = self.same[node]
        return node

    # Changes that all others are made of

    def new_id(self) -> int:
        self.next_id += 1
        return self.next_id - 1

    def new_node(self, point: Points, normal: Points, cut: bool) -> int:
        node = self.new_id()
        self.set_node(Node(node, np.array(point), np.array(normal), cut=cut))
        return node

    def set_node(self, node: Node) -> None:
        self.nodes[node.id] = node
        self.touched_nodes.add(node.id)

    def drop_node(self, node: int) -> None:
        del self.nodes[node]
        self.touched_nodes.discard(node)

    def rename_end(self, node: int, old: HalfChain, new: HalfChain) -> None:
        at = self.nodes[node]
        if old in self.gaps:
            self.gaps[new] = self.gaps.pop(old)
        self.set_node(replace(at, ends=tuple(new if half == old else half for half in at.ends)))
