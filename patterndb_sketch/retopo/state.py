"""Keep what editing changes as one immutable value, and the values before and after it."""

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


#: Steps that can be undone, as in the released program of Takayama et al. 2013.
DEPTH = 150


class History:
    """A line of states; one of them is now."""

    def __init__(self, state: State) -> None:
        self._past: list[State] = []
        self._now = state
        self._future: list[State] = []

    def copy(self) -> History:
        """The same line of states, which steps of this one do not change."""
        other = History(self._now)
        other._past, other._future = [*self._past], [*self._future]
        return other

    @property
    def now(self) -> State:
        return self._now

    @property
    def undoable(self) -> int:
        """Steps back that there are."""
        return len(self._past)

    @property
    def redoable(self) -> int:
        """Steps forward that there are."""
        return len(self._future)

    def step(self, state: State) -> None:
        """A new state after an action; what had been undone is gone."""
        self._past = [*self._past[-(DEPTH - 1) :], self._now]
        self._now = state
        self._future = []

    def settle(self, state: State) -> None:
        """The state now, with what the program chose for it; no step of its own."""
        self._now = state

    def undo(self) -> bool:
        """One step back; False if there is none."""
        if not self._past:
            return False
        self._future.append(self._now)
        self._now = self._past.pop()
        return True

    def redo(self) -> bool:
        """One step forward; False if there is none."""
        if not self._future:
            return False
        self._past.append(self._now)
        self._now = self._future.pop()
        return True
