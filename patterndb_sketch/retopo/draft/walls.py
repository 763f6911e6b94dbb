"""Borders and the seam of symmetry, which a network has as chains before anything is drafted."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.draft.assembly import OnWall
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Network, find_nearest_place
from patterndb_sketch.retopo.network.samples import Samples, take_chain_samples

#: Lines end no nearer to the end of a chain than so many of its samples.
OFF_ENDS = 0.25


@dataclass(frozen=True, eq=False)
class Walls:
    """network: what is there, marked chains alone."""

    network: Network

    @cached_property
    def _samples(self) -> Samples:
        return take_chain_samples(self.network.chains)

    @cached_property
    def _tangents(self) -> Points:
        """(m, 3) where the samples go."""
        of = self._samples
        return units(np.roll(of.points, -1, axis=0) - np.roll(of.points, 1, axis=0))

    def find_place(self, point: Points, ahead: Points) -> OnWall:
        """The place nearest to a point (3,), where a chain runs along a direction (3,) or against
        it: of two borders that nearly touch, the one that is meant."""
        of = self._samples
        if not len(of.points):
            raise RefusedError("a border of the surface is not among the curves; draw on it anew")
        away = np.linalg.norm(of.points - point, axis=1)
        along = np.abs(self._tangents @ ahead) > 0.5 * np.linalg.norm(ahead)
        near = int(np.where(along | ~along.any(), away, np.inf).argmin())
        # Seen by the normal there, not by the mesh's: at a sharp border they may be opposed.
        found = find_nearest_place(of, point, of.normals[near], np.inf)
        assert found is not None
        chain = self.network.chains[found.chain]
        place = found.place
        if chain.loose:
            place %= len(chain.points)
        else:
            place = min(max(place, OFF_ENDS), len(chain.points) - 1 - OFF_ENDS)
        return OnWall(chain.id, place, chain.marks[0] == "")
