"""Keep what editing changes as one immutable value."""

from __future__ import annotations

from dataclasses import dataclass

from patterndb_sketch.retopo.network import Network, are_equal
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Plane


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """network: the curves, with counts and fills. sizes: of brushes and edges. plane: of symmetry,
    None where it is off.

    Undoing is to take an earlier state. What the user looks at, such as whether the surface is
    hidden, is not part of it.
    """

    network: Network
    sizes: Sizes
    plane: Plane | None = None

    def same(self, other: State) -> bool:
        """Are they equal, bit for bit?"""
        return (
            self.sizes == other.sizes
            and self.plane == other.plane
            and are_equal(self.network, other.network)
        )
