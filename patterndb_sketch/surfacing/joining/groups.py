"""Groups of things that become one, one pair after another."""

from __future__ import annotations


class Groups:
    """Things 0 to n - 1, each at first a group of its own (union-find)."""

    def __init__(self, n: int) -> None:
        self._parent = list(range(n))

    def find(self, thing: int) -> int:
        """Return the group of a thing: the least thing in it."""
        parent = self._parent
        while parent[thing] != thing:
            parent[thing] = parent[parent[thing]]
            thing = parent[thing]
        return thing

    def unite(self, one: int, other: int) -> int:
        """Make one group of the groups of two things, and return it."""
        first, second = sorted((self.find(one), self.find(other)))
        self._parent[second] = first
        return first
