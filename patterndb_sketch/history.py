"""Keep the steps of what is edited: values, one of them now, others before and after it."""

from __future__ import annotations

from typing import Generic, TypeVar

#: Steps that can be undone, as in the released program of Takayama et al. 2013.
DEPTH = 150

Value = TypeVar("Value")


class History(Generic[Value]):
    """A line of immutable values; one of them is now."""

    def __init__(self, value: Value) -> None:
        self._past: list[Value] = []
        self._now = value
        self._future: list[Value] = []

    def copy(self) -> History[Value]:
        """The same line of values, which steps of this one do not change."""
        other = History(self._now)
        other._past, other._future = [*self._past], [*self._future]
        return other

    @property
    def now(self) -> Value:
        return self._now

    @property
    def undoable(self) -> int:
        """Steps back that there are."""
        return len(self._past)

    @property
    def redoable(self) -> int:
        """Steps forward that there are."""
        return len(self._future)

    def step(self, value: Value) -> None:
        """A new value after an action; what had been undone is gone."""
        before, self._now = self._now, value
        self.keep(before)

    def keep(self, before: Value) -> None:
        """Have a step lead to the value now, from one before: all that was settled between."""
        self._past = [*self._past[-(DEPTH - 1) :], before]
        self._future = []

    def settle(self, value: Value) -> None:
        """The value now, with what is no step of its own."""
        self._now = value

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
