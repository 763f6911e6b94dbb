"""A network while it is edited: several edits, then one network again."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network.attaching import Gap, Gaps, attach_chain, measure_reach
from patterndb_sketch.retopo.network.faces import count_genus, count_handles
from patterndb_sketch.retopo.network.patches import find_patches
from patterndb_sketch.retopo.network.samples import (
    Cut,
    check_line,
    join_chains,
    locate_place,
    open_chain,
    point_at_place,
    split_chain,
)
from patterndb_sketch.retopo.network.structure import FACE, NONE, Chain, HalfChain, Network, Node


@dataclass(frozen=True, slots=True)
class Free:
    """An end of a new curve that is joined to nothing: an open end."""


@dataclass(frozen=True, slots=True)
class AtNode:
    """An end of a new curve that is joined to a node that is there.

    smooth: at an open end, the two curves become one; elsewhere it says nothing. By default
            the joint is a corner.
    """

    node: int
    smooth: bool = False


@dataclass(frozen=True, slots=True)
class AtChain:
    """An end of a new curve that is joined to a place on a chain, which is cut: a T-junction.

    place: in samples: 3.25 is a quarter of the way from sample 3 to sample 4. From 0 to n - 1,
           or, on a closed chain without a node, to n; at an end of the chain it is the node.
    """

    chain: int
    place: float


#: What an end of a new curve is joined to.
End = Free | AtNode | AtChain


class NetworkBuilder:
    """A network that edits change in place; :meth:`finish` gives the new network.

    Chains that were cut may still be named by their old ids and places: they stand for the
    pieces. Patches are found again when it is finished, and only where something changed.

    before: the network that it began with. nodes, chains: as they are now.
    cuts:   of chains that were cut, by their ids. same: of nodes that went into another.
    merged: of half-chains, the longer ones that they are parts of.
    gaps:   of ends whose gaps were given.
    touched_nodes:  whose ends, flags or place changed. touched_chains: that are new or run
                    elsewhere.
    notes:  what the user should know, in words.
    """

    def __init__(self, network: Network, surface: Surface | None = None) -> None:
        """Begin with a network; surface: what it lies on, if it does not know yet."""
        self.before = network if surface is None else replace(network, surface=surface)
        self.nodes = dict(network.nodes)
        self.chains = dict(network.chains)
        self.next_id = network.next_id
        self.cuts: dict[int, Cut] = {}
        self.same: dict[int, int] = {}
        self.merged: dict[HalfChain, HalfChain] = {}
        self.gaps: dict[HalfChain, Gap] = {}
        self.touched_nodes: set[int] = set()
        self.touched_chains: set[int] = set()
        self.notes: list[str] = []

    # Adding

    def add_node(self, point: ArrayLike, normal: ArrayLike) -> int:
        """Add a node without chains, for some to come; dropped at the end if none does."""
        return self.new_node(np.array(point, np.float64), np.array(normal, np.float64), False)

    def add_chain(
        self,
        points: ArrayLike,
        normals: ArrayLike,
        start: End = Free(),
        end: End = Free(),
        *,
        count: int = 0,
        pinned: bool = False,
        marks: tuple[str, str] = ("", ""),
        gaps: Gaps = (None, None),
    ) -> int:
        """Add a chain between two ends; returns its id.

        points: (n, 3) with n >= 2, normals: (n, 3) unit; their ends are set to the nodes'. It
        must cross no chain; curves that may are inserted by :mod:`patterndb_sketch.retopo.tools`.
        At a node it goes into the gap that it points into, or that is given; both wedges beside
        it become corners. On a chain, that is cut; the wedge on the far side stays unflagged.

        A smooth joint makes one chain of two; the id returned then is the one of that.
        Raises InvalidRetopoError for ends that are not there and points that are none, and
        RefusedError for a chain without length, or one that would pass through others.
        """
        line, up = check_line(points, normals)
        first, last = self.end_node(start, line[0], up[0]), self.end_node(end, line[-1], up[-1])
        line[0], up[0] = self.nodes[first].point, self.nodes[first].normal
        line[-1], up[-1] = self.nodes[last].point, self.nodes[last].normal
        inner = (line[1:-1] != line[0]).any()
        if (line[0] == line[-1]).all() and (len(line) < 4 or not inner):
            raise RefusedError("the curve would begin and end at one place; draw it longer")
        chain = self.new_chain(first, last, line, up)
        self.chains[chain] = replace(self.chains[chain], count=count, pinned=pinned, marks=marks)
        attach_chain(self, chain, measure_reach([self.chains[chain]]), gaps)
        for joint, node in ((start, first), (end, last)):
            if isinstance(joint, AtNode) and joint.smooth and first != last:
                merged = self.merge(node)
                chain = chain if merged is None else merged
        return chain

    def add_loop(
        self,
        points: ArrayLike,
        normals: ArrayLike,
        *,
        count: int = 0,
        marks: tuple[str, str] = ("", ""),
    ) -> int:
        """Add a closed chain without a node: (n, 3) points with n >= 3, the first not repeated."""
        line, up = check_line(points, normals)
        if len(line) < 3:
            raise InvalidRetopoError(f"a closed chain of {len(line)} points; give 3 or more")
        chain = self.new_chain(NONE, NONE, line, up)
        self.chains[chain] = replace(self.chains[chain], count=count, marks=marks)
        return chain

    def end_node(self, end: End, point: Points, normal: Points) -> int:
        """Find the node of an end: one that is there, made by cutting, or made at the point."""
        match end:
            case Free():
                return self.new_node(point, normal, False)
            case AtNode(node):
                if node not in self.nodes:
                    raise InvalidRetopoError(f"there is no node {node} in the network")
                return node
            case AtChain(chain, place):
                return self.cut_chain(chain, place)

    # Cutting, joining, removing

    def cut_chain(
        self,
        chain: int,
        place: float,
        at: tuple[Points, Points] | None = None,
    ) -> int:
        """Cut a chain at a place, in samples; returns the node, a new one or that at the end.

        at: (3,) point and normal for the node if it shall not be on the chain's own polyline.
        The node's wedges are unflagged; unless that changes, or a curve is added there, the
        parts are one chain again when the network is finished. The edge of a face that was given is
        not cut: its nearer end is the node.
        """
        chain, place = self.locate(chain, place)
        old = self.chains[chain]
        k, share = locate_place(old, place)
        if not old.is_closed_loop and share == 0.0 and k in (0, len(old.points) - 1):
            return old.start if k == 0 else old.end
        if FACE in old.marks:
            return old.start if 2.0 * place < old.segments else old.end
        point, normal = at if at is not None else point_at_place(old, k, share)
        node = self.new_node(point, normal, True)
        point, normal = self.nodes[node].point, self.nodes[node].normal
        if old.is_closed_loop:
            cut = Cut(k, share, (self.new_id(),), len(old.points))
            new = open_chain(old, cut, node, point, normal)
            pieces: tuple[Chain, ...] = (new,)
            ends = (2 * new.id, 2 * new.id + 1)
        else:
            cut = Cut(k, share, (self.new_id(), self.new_id()), len(old.points))
            pieces = split_chain(old, cut, node, point, normal)
            ends = (2 * pieces[1].id, 2 * pieces[0].id + 1)
            self.rename_end(old.start, 2 * chain, 2 * pieces[0].id)
            self.rename_end(old.end, 2 * chain + 1, 2 * pieces[1].id + 1)
        del self.chains[chain]
        self.cuts[chain] = cut
        for piece in pieces:
            self.chains[piece.id] = piece
            self.touched_chains.add(piece.id)
        self.set_node(replace(self.nodes[node], ends=ends, corner_flags=(False, False)))
        return node

    def merge(self, node: int) -> int | None:
        """Make one chain of the two that end at a node, whatever its flags; returns its id.

        None, and nothing changes, if there are not two, or if their marks differ; edges of a face
        that was given stay apart.
        """
        at = self.nodes[node]
        if at.valence != 2:
            return None
        one, two = at.ends
        # Forwards if one of them arrives so, else as the older one runs.
        if (one & 1, two & 1) == (0, 1) or (one & 1 == two & 1 and (one < two) != one & 1):
            one, two = two, one
        first, last = self.chains[one >> 1], self.chains[two >> 1]
        marks = first.marks if one & 1 else first.marks[::-1]
        if marks != (last.marks[::-1] if two & 1 else last.marks) or FACE in marks:
            return None
        new = join_chains(first, last, one ^ 1, two, self.new_id())
        for part in (one ^ 1, two):
            self.merged |= {part: 2 * new.id, part ^ 1: 2 * new.id + 1}
        self.chains.pop(first.id)
        self.chains.pop(last.id, None)
        self.drop_node(node)
        self.chains[new.id] = new
        self.touched_chains.add(new.id)
        if not new.is_closed_loop:
            self.rename_end(new.start, one ^ 1, 2 * new.id)
            self.rename_end(new.end, two ^ 1, 2 * new.id + 1)
        return new.id

    def remove_chain(self, chain: int) -> tuple[int, ...]:
        """Remove a chain; returns its nodes that are still there.

        Where it left one chain, that has an open end now; where more, the gap closes: it is a
        corner if two chains are left, or if fewer than two other corners are.
        """
        chain, _ = self.locate(chain, 0.0)
        old = self.chains.pop(chain)
        if old.is_closed_loop:
            return ()
        left: list[int] = []
        for node, half in ((old.start, 2 * chain), (old.end, 2 * chain + 1)):
            at = self.nodes[node]
            j = at.ends.index(half)
            ends = at.ends[:j] + at.ends[j + 1 :]
            if not ends:
                self.drop_node(node)
                continue
            flags = list(at.corner_flags)
            del flags[j]
            closing = (j - 1) % len(ends)
            others = sum(flags) - flags[closing]
            flags[closing] = len(ends) > 1 and (len(ends) == 2 or others < 2)
            self.set_node(replace(at, ends=ends, corner_flags=tuple(flags)))
            left.append(node)
        return tuple(n for n in dict.fromkeys(left) if n in self.nodes)

    # Changing

    def flag(self, half: HalfChain, corner: bool) -> None:
        """Make the wedge on the left of a half-chain, where it leaves its node, a corner or not."""
        half = self.half_now(half)
        chain = self.chains[half >> 1]
        at = self.nodes[chain.end if half & 1 else chain.start]
        j = at.wedge_after(half)
        flags = (*at.corner_flags[:j], corner, *at.corner_flags[j + 1 :])
        self.set_node(replace(at, corner_flags=flags, cut=at.cut and not corner))

    def reshape_chain(self, chain: int, points: ArrayLike, normals: ArrayLike) -> None:
        """Let a chain run elsewhere between the same nodes: (n, 3) points and normals."""
        line, up = check_line(points, normals)
        old = self.chains[chain]
        if not old.is_closed_loop:
            line[0], up[0] = self.nodes[old.start].point, self.nodes[old.start].normal
            line[-1], up[-1] = self.nodes[old.end].point, self.nodes[old.end].normal
        self.chains[chain] = replace(old, points=line, normals=up)
        self.touched_chains.add(chain)

    def move_node(self, node: int, point: ArrayLike, normal: ArrayLike) -> None:
        """Move a node, and with it the ends of its chains and nothing else of them."""
        new = replace(
            self.nodes[node],
            point=np.array(point, np.float64),
            normal=np.array(normal, np.float64),
        )
        self.set_node(new)
        for chain in {half >> 1 for half in new.ends}:
            self.reshape_chain(chain, self.chains[chain].points, self.chains[chain].normals)

    def set_count(self, chain: int, count: int, pinned: bool = False) -> None:
        """Set the edges along a chain, 0 for not chosen."""
        self.chains[chain] = replace(self.chains[chain], count=count, pinned=pinned)

    # Finishing

    def finish(self, also: Iterable[HalfChain] = (), forget: bool = False) -> Network:
        """Make the network with all edits, its patches found again where something changed.

        Nodes without chains are dropped; two chains that pass a node without a corner become one.
        also:   the loops on the left of these half-chains become patches even if they do not
                enclose by equation 1; they must have two corners and no open end.
        forget: are counts that no patch uses any more, and that no user chose, forgotten?

        Raises RefusedError if curves would pass through each other without a crossing.
        """
        for node in sorted(self.touched_nodes):
            at = self.nodes.get(node)
            if at is None:
                continue
            if not at.ends:
                del self.nodes[node]
            elif at.valence > 1 and not any(at.corner_flags):
                if at.valence == 2 and self.merge(node) is not None:
                    continue
                self.set_node(replace(at, corner_flags=(True,) * at.valence))
        self._refuse_crossings()
        return find_patches(
            replace(
                self.before,
                nodes=dict(self.nodes),
                chains=dict(self.chains),
                next_id=self.next_id,
            ),
            self.touched_nodes,
            self.touched_chains,
            tuple(map(self._side_now, also)),
            forget,
        )

    def _refuse_crossings(self) -> None:
        """RefusedError if the order around nodes is that of no drawing on the surface."""
        surface = self.before.surface
        if surface is None or not self.touched_nodes:
            return
        genus = count_genus(self.nodes, self.chains)
        if genus and genus > count_handles(surface):
            raise RefusedError(
                "curves would pass through each other without a crossing; erase what is in the "
                "way first, or end the curve beside it"
            )

    # What old names mean now

    def locate(self, chain: int, place: float) -> tuple[int, float]:
        """Find where a place, perhaps taken before a cut, is now."""
        while chain in self.cuts:
            chain, place = self.cuts[chain].move_place(place)
        if chain not in self.chains:
            raise InvalidRetopoError(f"there is no chain {chain} in the network")
        return chain, place

    def pieces(self, chains: Iterable[int]) -> set[int]:
        """Find what chains, perhaps of before cuts, are now."""
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

    def _side_now(self, half: HalfChain) -> HalfChain:
        """A half-chain with the same loop on its left, of a chain that was cut or merged since."""
        while (half >> 1) in self.cuts or half in self.merged:
            half = self.merged[half] if half in self.merged else self.half_now(half)
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

    def new_chain(self, start: int, end: int, points: Points, normals: Points) -> int:
        """Put a chain there that its nodes do not know yet."""
        chain = self.new_id()
        self.chains[chain] = Chain(chain, start, end, points, normals)
        self.touched_chains.add(chain)
        return chain

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
