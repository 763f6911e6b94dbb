"""What an end of a new curve is joined to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Free:
    """Nothing: an open end."""


@dataclass(frozen=True, slots=True)
class AtNode:
    """A node that is there.

    smooth: at an open end, the two curves become one; elsewhere it says nothing. By default
            the joint is a corner.
    """

    node: int
    smooth: bool = False


@dataclass(frozen=True, slots=True)
class AtChain:
    """A place on a chain, which is cut there: a T-junction.

    place: in samples: 3.25 is a quarter of the way from sample 3 to sample 4. From 0 to n - 1,
           or, on a closed chain without a node, to n; at an end of the chain it is the node.
    """

    chain: int
    place: float


End = Free | AtNode | AtChain
