"""A network while it is edited: several edits, then one network again."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from query.placing.surface import Points
from query.polyline import as_points
from sketch.retopo.errors import InvalidRetopoError, RefusedError
from sketch.retopo.network.cutting import Cut, at_place, joined, located, opened, split
from sketch.retopo.network.ends import AtChain, AtNode, End, Free
from sketch.retopo.network.gaps import Gap, beside, pointed_into
from sketch.retopo.network.patches import with_patches
from sketch.retopo.network.structure import NONE, Chain, HalfChain, Network, Node

#: Directions in which curves leave a node are taken over this many samples.
SAMPLES_AHEAD = 2.0


class Draft:
    """A network that edits change in place; :meth:`finished` gives the new network.

    Chains that were cut may still be named by their old ids and places: they stand for the
    pieces. Patches are found again when it is finished, and only where something changed.
    """

    def __init__(self, network: Network) -> None:
        self.before = network
        self.nodes = dict(network.nodes)
        self.chains = dict(network.chains)
        self.next_id = network.next_id
        self.notes: list[str] = []
        self._cuts: dict[int, Cut] = {}
        self._gaps: dict[HalfChain, Gap] = {}  # of ends whose gaps were given
        self._nodes: set[int] = set()  # whose ends, flags or place changed
        self._chains: set[int] = set()  # that are new or run elsewhere

    # Adding

    def add_node(self, point: ArrayLike, normal: ArrayLike) -> int:
        """A node without chains, for some to come; dropped at the end if none does."""
        return self._new_node(np.array(point, np.float64), np.array(normal, np.float64), False)

    def add_chain(
        self,
        points: ArrayLike,
        normals: ArrayLike,
        start: End = Free(),  # noqa: B008 (immutable)
        end: End = Free(),  # noqa: B008
        *,
        count: int = 0,
        pinned: bool = False,
        marks: tuple[str, str] = ("", ""),
        gaps: tuple[Gap | None, Gap | None] = (None, None),
    ) -> int:
        """A chain between two ends; returns its id.

        points: (n, 3) with n >= 2, normals: (n, 3) unit; their ends are set to the nodes'. It
        must cross no chain: :func:`~sketch.retopo.tools.stroke.insert` is for curves that may.
        At a node it goes into the gap that it points into, or that is given; both wedges beside
        it become corners. On a chain, that is cut; the wedge on the far side stays unflagged.

        A smooth joint makes one chain of two; the id returned then is the one of that.
        Raises InvalidRetopoError for ends that are not there and points that are none, and
        RefusedError for a chain without length.
        """
        line, up = _line(points, normals)
        first, last = self.end_node(start, line[0], up[0]), self.end_node(end, line[-1], up[-1])
        line[0], up[0] = self.nodes[first].point, self.nodes[first].normal
        line[-1], up[-1] = self.nodes[last].point, self.nodes[last].normal
        inner = (line[1:-1] != line[0]).any()
        if (line[0] == line[-1]).all() and (len(line) < 4 or not inner):
            raise RefusedError("the curve would begin and end at one place; draw it longer")
        chain = self._new_id()
        self.chains[chain] = Chain(chain, first, last, line, up, count, pinned, marks)
        self._chains.add(chain)
        reach = SAMPLES_AHEAD * self.chains[chain].length / (len(line) - 1)
        self._attach(first, 2 * chain, reach, gaps[0])
        self._attach(last, 2 * chain + 1, reach, gaps[1])
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
        """A closed chain without a node: (n, 3) points with n >= 3, the first not repeated."""
        line, up = _line(points, normals)
        if len(line) < 3:
            raise InvalidRetopoError(f"a closed chain of {len(line)} points; give 3 or more")
        chain = self._new_id()
        self.chains[chain] = Chain(chain, NONE, NONE, line, up, count, False, marks)
        self._chains.add(chain)
        return chain

    def end_node(self, end: End, point: Points, normal: Points) -> int:
        """The node of an end: that which is there, or made by cutting, or made at the point."""
        match end:
            case Free():
                return self._new_node(point, normal, False)
            case AtNode(node):
                if node not in self.nodes:
                    raise InvalidRetopoError(f"there is no node {node} in the network")
                return node
            case AtChain(chain, place):
                return self.cut_chain(chain, place)

    # Cutting, joining, removing

    def located(self, chain: int, place: float) -> tuple[int, float]:
        """The chain and place that a chain and place, perhaps of before a cut, are now."""
        while chain in self._cuts:
            chain, place = self._cuts[chain].moved(place)
        if chain not in self.chains:
            raise InvalidRetopoError(f"there is no chain {chain} in the network")
        return chain, place

    def pieces(self, chains: Iterable[int]) -> set[int]:
        """What chains, perhaps of before cuts, are now."""
        found: set[int] = set()
        left = list(chains)
        while left:
            chain = left.pop()
            if chain in self._cuts:
                left += self._cuts[chain].pieces
            elif chain in self.chains:
                found.add(chain)
        return found

    def half_now(self, half: HalfChain) -> HalfChain:
        """The half-chain that leaves the same node as one of before a cut."""
        while (half >> 1) in self._cuts:
            pieces = self._cuts[half >> 1].pieces
            half = 2 * pieces[-(half & 1)] + (half & 1)
        return half

    def cut_chain(
        self,
        chain: int,
        place: float,
        at: tuple[Points, Points] | None = None,
    ) -> int:
        """Cut a chain at a place, in samples; returns the node, a new one or that at the end.

        at: (3,) point and normal for the node if it shall not be on the chain's own polyline.
        The node's wedges are unflagged; unless that changes, or a curve is added there, the
        parts are one chain again when the draft is finished.
        """
        chain, place = self.located(chain, place)
        old = self.chains[chain]
        k, share = located(old, place)
        if not old.loose and share == 0.0 and k in (0, len(old.points) - 1):
            return old.start if k == 0 else old.end
        point, normal = at if at is not None else at_place(old, k, share)
        node = self._new_node(point, normal, True)
        point, normal = self.nodes[node].point, self.nodes[node].normal
        if old.loose:
            cut = Cut(k, share, (self._new_id(),), len(old.points))
            new = opened(old, cut, node, point, normal)
            pieces: tuple[Chain, ...] = (new,)
            ends = (2 * new.id, 2 * new.id + 1)
        else:
            cut = Cut(k, share, (self._new_id(), self._new_id()), len(old.points))
            pieces = split(old, cut, node, point, normal)
            ends = (2 * pieces[1].id, 2 * pieces[0].id + 1)
            self._rename_end(old.start, 2 * chain, 2 * pieces[0].id)
            self._rename_end(old.end, 2 * chain + 1, 2 * pieces[1].id + 1)
        del self.chains[chain]
        self._cuts[chain] = cut
        for piece in pieces:
            self.chains[piece.id] = piece
            self._chains.add(piece.id)
        self._set(replace(self.nodes[node], ends=ends, flagged=(False, False)))
        return node

    def merge(self, node: int) -> int | None:
        """Make one chain of the two that end at a node, whatever its flags; returns its id.

        None, and nothing changes, if there are not two, or if their marks differ.
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
        if marks != (last.marks[::-1] if two & 1 else last.marks):
            return None
        new = joined(first, last, one ^ 1, two, self._new_id())
        self.chains.pop(first.id)
        self.chains.pop(last.id, None)
        self.nodes.pop(node)
        self._nodes.discard(node)
        self.chains[new.id] = new
        self._chains.add(new.id)
        if not new.loose:
            self._rename_end(new.start, one ^ 1, 2 * new.id)
            self._rename_end(new.end, two ^ 1, 2 * new.id + 1)
        return new.id

    def remove_chain(self, chain: int) -> tuple[int, ...]:
        """Remove a chain; returns its nodes that are still there.

        Where it left one chain, that has an open end now; where more, the gap closes: it is a
        corner if two chains are left, or if fewer than two other corners are.
        """
        chain, _ = self.located(chain, 0.0)
        old = self.chains.pop(chain)
        if old.loose:
            return ()
        left: list[int] = []
        for node, half in ((old.start, 2 * chain), (old.end, 2 * chain + 1)):
            at = self.nodes[node]
            j = at.ends.index(half)
            ends = at.ends[:j] + at.ends[j + 1 :]
            if not ends:
                del self.nodes[node]
                self._nodes.discard(node)
                continue
            flags = list(at.flagged)
            del flags[j]
            closing = (j - 1) % len(ends)
            others = sum(flags) - flags[closing]
            flags[closing] = len(ends) > 1 and (len(ends) == 2 or others < 2)
            self._set(replace(at, ends=ends, flagged=tuple(flags)))
            left.append(node)
        return tuple(n for n in dict.fromkeys(left) if n in self.nodes)

    # Changing

    def flag(self, half: HalfChain, corner: bool) -> None:
        """Make the wedge on the left of a half-chain, where it leaves its node, a corner or not."""
        half = self.half_now(half)
        chain = self.chains[half >> 1]
        at = self.nodes[chain.end if half & 1 else chain.start]
        j = at.wedge_after(half)
        flags = (*at.flagged[:j], corner, *at.flagged[j + 1 :])
        self._set(replace(at, flagged=flags, cut=at.cut and not corner))

    def reshape_chain(self, chain: int, points: ArrayLike, normals: ArrayLike) -> None:
        """Let a chain run elsewhere between the same nodes: (n, 3) points and normals."""
        line, up = _line(points, normals)
        old = self.chains[chain]
        if not old.loose:
            line[0], up[0] = self.nodes[old.start].point, self.nodes[old.start].normal
            line[-1], up[-1] = self.nodes[old.end].point, self.nodes[old.end].normal
        self.chains[chain] = replace(old, points=line, normals=up)
        self._chains.add(chain)

    def move_node(self, node: int, point: ArrayLike, normal: ArrayLike) -> None:
        """Move a node, and with it the ends of its chains and nothing else of them."""
        new = replace(
            self.nodes[node],
            point=np.array(point, np.float64),
            normal=np.array(normal, np.float64),
        )
        self._set(new)
        for chain in {half >> 1 for half in new.ends}:
            self.reshape_chain(chain, self.chains[chain].points, self.chains[chain].normals)

    def set_count(self, chain: int, count: int, pinned: bool = False) -> None:
        """Edges along a chain, 0 for not chosen."""
        self.chains[chain] = replace(self.chains[chain], count=count, pinned=pinned)

    # Finishing

    def finished(self, also: Iterable[HalfChain] = (), forget: bool = False) -> Network:
        """The network with all edits, its patches found again where something changed.

        Nodes without chains are dropped; two chains that pass a node without a corner become one.
        also:   the loops on the left of these half-chains become patches even if they do not
                enclose by equation 1; they must have two corners and no open end.
        forget: are counts that no patch uses any more, and that no user chose, forgotten?
        """
        for node in sorted(self._nodes):
            at = self.nodes.get(node)
            if at is None:
                continue
            if not at.ends:
                del self.nodes[node]
            elif at.valence > 1 and not any(at.flagged):
                if at.valence == 2 and self.merge(node) is not None:
                    continue
                self._set(replace(at, flagged=(True,) * at.valence))
        return with_patches(
            replace(
                self.before,
                nodes=dict(self.nodes),
                chains=dict(self.chains),
                next_id=self.next_id,
            ),
            self._nodes,
            self._chains,
            tuple(map(self.half_now, also)),
            forget,
        )

    # Parts

    def _new_id(self) -> int:
        self.next_id += 1
        return self.next_id - 1

    def _new_node(self, point: Points, normal: Points, cut: bool) -> int:
        node = self._new_id()
        self._set(Node(node, np.array(point), np.array(normal), cut=cut))
        return node

    def _set(self, node: Node) -> None:
        self.nodes[node.id] = node
        self._nodes.add(node.id)

    def _rename_end(self, node: int, old: HalfChain, new: HalfChain) -> None:
        at = self.nodes[node]
        if old in self._gaps:
            self._gaps[new] = self._gaps.pop(old)
        self._set(replace(at, ends=tuple(new if half == old else half for half in at.ends)))

    def _attach(self, node: int, half: HalfChain, reach: float, gap: Gap | None) -> None:
        """Put a half-chain among the ends of its node, with a corner on either side."""
        at = self.nodes[node]
        if not at.ends:
            self._set(replace(at, ends=(half,), flagged=(False,)))
            return
        if gap is None:
            j = pointed_into(at, half, reach, self.chains, self._gaps, self.half_now)
        else:
            j = beside(at, gap, self._gaps, self.half_now)
            self._gaps[half] = gap
        self._set(
            replace(
                at,
                ends=(*at.ends[: j + 1], half, *at.ends[j + 1 :]),
                flagged=(*at.flagged[:j], True, True, *at.flagged[j + 1 :]),
            )
        )


def _line(points: ArrayLike, normals: ArrayLike) -> tuple[Points, Points]:
    line = as_points(points, "a chain's points", InvalidRetopoError)
    up = as_points(normals, "a chain's normals", InvalidRetopoError)
    if len(line) < 2 or len(up) != len(line):
        raise InvalidRetopoError(
            f"a chain of {len(line)} points with {len(up)} normals; give two or more, one each"
        )
    return line, up
