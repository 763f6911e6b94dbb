"""Borders, the seam of symmetry and curves that are drawn: chains that a network has before
anything is drafted, and on which lines end."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.draft.assembly import BEYOND, InWedge, OnWall
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Chain, HalfChain, Network, find_nearest_place
from patterndb_sketch.retopo.network.samples import Samples, take_chain_samples

#: Lines end no nearer to the end of a chain than so many of its samples.
OFF_ENDS = 0.25

#: What ends beside a node, as far as ends are taken to it, is by this much in its order from what
#: ends at the node itself; no vertex has more triangles.
FAR = 1e3


@dataclass(frozen=True, eq=False)
class Walls:
    """network: what is there. snap: what is nearer than this to a node that a drawn curve ends in
    is at the node."""

    network: Network
    snap: float = 0.0

    @cached_property
    def drawn(self) -> frozenset[int]:
        """The nodes that curves end in which are drawn."""
        return frozenset(
            node
            for chain in self.network.chains.values()
            if not (chain.marked or chain.loose)
            for node in (chain.start, chain.end)
        )

    @cached_property
    def bare(self) -> bool:
        """Are there borders and the seam alone?"""
        return all(chain.marked for chain in self.network.chains.values())

    @cached_property
    def _samples(self) -> Samples:
        return take_chain_samples(self.network.chains)

    @cached_property
    def _tangents(self) -> Points:
        """(m, 3) where the samples go."""
        of = self._samples
        return units(np.roll(of.points, -1, axis=0) - np.roll(of.points, 1, axis=0))

    def find_place(self, point: Points, ahead: Points, middle: Points) -> OnWall | InWedge:
        """The place nearest to a point (3,) of a side of the field's mesh, where a chain runs along
        its direction (3,) or against it: of two borders that nearly touch, the one that is meant.

        middle: (3,) of that side, which tells curves apart that meet in a node."""
        of = self._samples
        if not len(of.points):
            raise RefusedError("a border of the surface is not among the curves; draw on it anew")
        if not self.bare:
            return self._find_drawn(point, ahead, middle)
        away = np.linalg.norm(of.points - point, axis=1)
        along = np.abs(self._tangents @ ahead) > 0.5 * np.linalg.norm(ahead)
        near = int(np.where(along | ~along.any(), away, np.inf).argmin())
        # Seen by the normal there, not by the mesh's: at a sharp border they may be opposed.
        found = find_nearest_place(of, point, of.normals[near], np.inf)
        assert found is not None
        chain = self.network.chains[found.chain]
        return OnWall(chain.id, _keep_off_ends(chain, found.place), chain.marks[0] == "")

    def _find_drawn(self, point: Points, ahead: Points, middle: Points) -> OnWall | InWedge:
        """See :meth:`find_place`, where curves are drawn."""
        chain = self.network.chains[self._find_chain(middle, ahead)]
        # At the middle of the side: at its end the curve may turn.
        k = int(np.linalg.norm(chain.points - middle, axis=1).argmin())
        forth = _runs_along(chain, k, ahead)
        at = self._find_node(chain, point, 2 * chain.id + (not forth))
        if at is not None:
            return at
        of = take_chain_samples({chain.id: chain})
        near = int(np.linalg.norm(of.points - point, axis=1).argmin())
        found = find_nearest_place(of, point, of.normals[near], np.inf)
        assert found is not None
        # The mesh is on the left of its border's sides.
        left = chain.marks[0] == "" if chain.marked else forth
        return OnWall(chain.id, _keep_off_ends(chain, found.place), left)

    def _find_chain(self, point: Points, ahead: Points) -> int:
        """The chain nearest to a point that runs along a direction, or against it."""
        of = self._samples
        away = np.linalg.norm(of.points - point, axis=1)
        along = np.abs(self._tangents @ ahead) > 0.5 * np.linalg.norm(ahead)
        near = int(np.where(along | ~along.any(), away, np.inf).argmin())
        found = find_nearest_place(of, of.points[near], of.normals[near], np.inf)
        assert found is not None
        return found.chain

    def _find_node(self, chain: Chain, point: Points, half: HalfChain) -> InWedge | None:
        """The wedge at an end of a chain, if that is near and a drawn curve ends there; half: that
        has the mesh on its left."""
        if chain.loose:
            return None
        for end in (half, half ^ 1):
            node = self.network.nodes[self.network.origin(end)]
            away = float(np.linalg.norm(node.point - point))
            if node.id in self.drawn and away <= self.snap:
                # What comes to the curve further from the node lies closer beside the curve: at its
                # start first of its wedge, at its end last.
                far = FAR * away / self.snap
                if end == half:
                    return InWedge(node.id, end, -far)
                return InWedge(node.id, node.ends[node.wedge_before(end)], BEYOND + far)
        return None


def _runs_along(chain: Chain, k: int, ahead: Points) -> bool:
    """Does a chain run along a direction (3,) at its sample k, rather than against it?"""
    n = len(chain.points)
    if chain.loose:
        low, high = (k - 2) % n, (k + 2) % n
    else:
        low, high = max(k - 2, 0), min(k + 2, n - 1)
    return bool((chain.points[high] - chain.points[low]) @ ahead > 0.0)


def _keep_off_ends(chain: Chain, place: float) -> float:
    if chain.loose:
        return place % len(chain.points)
    return min(max(place, OFF_ENDS), len(chain.points) - 1 - OFF_ENDS)
