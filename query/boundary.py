"""The boundary to be filled: how many edges each side has, and what its corners are."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, SupportsIndex

from patterndb.errors import InvalidBoundaryError

CornerKind = Literal["convex", "reflex"]

#: Quads that a strict fill has at a corner of each kind. A pattern's corner with four or
#: more quads is reflex too, but not what a reflex corner asks for: its extra quads would
#: be an irregular vertex on the boundary.
QUADS_AT: dict[CornerKind, int] = {"convex": 1, "reflex": 3}

#: The fewest edges around any quad mesh: one quad.
MIN_PERIMETER = 4

#: Edges. A fill of a perimeter P has up to about P**2 / 16 quads times the crossings of the
#: polychords: beyond this a list of fills no longer fits in memory, and is surely a slip.
MAX_PERIMETER = 2_000


@dataclass(frozen=True, slots=True)
class Boundary:
    """N sides, counter-clockwise.

    lengths: edges of every side, each >= 1. Side i runs from corner i to corner i + 1.
    corners: "convex" or "reflex" for every corner; corner i is where side i begins. All
             are convex by default. ``corners=()`` with one length is one closed side
             (N = 0), see :meth:`closed`.

    Raises InvalidBoundaryError, with what would mend it, for an odd perimeter, one below
    MIN_PERIMETER or above MAX_PERIMETER, a length that is no whole number >= 1, and for
    numbers of sides and corners that do not go together.

    >>> Boundary((3, 4, 5)).perimeter
    12
    """

    lengths: tuple[int, ...]
    corners: tuple[CornerKind, ...]

    def __init__(
        self,
        lengths: Iterable[SupportsIndex | float],
        corners: Iterable[CornerKind] | None = None,
    ) -> None:
        whole = tuple(_whole(length, side) for side, length in enumerate(lengths))
        kinds = ("convex",) * len(whole) if corners is None else tuple(corners)
        object.__setattr__(self, "lengths", whole)
        object.__setattr__(self, "corners", kinds)
        self._refuse_counts()
        self._refuse_lengths()

    @classmethod
    def closed(cls, length: SupportsIndex | float) -> Boundary:
        """One closed side of ``length`` edges without any corner: N = 0."""
        return cls((length,), corners=())

    @property
    def n_sides(self) -> int:
        """N: the number of corners, 0 for one closed side."""
        return len(self.corners)

    @property
    def perimeter(self) -> int:
        """The number of edges, and of vertices, around the boundary."""
        return sum(self.lengths)

    @property
    def corner_counts(self) -> tuple[int, ...]:
        """How many quads a strict fill has at every corner."""
        return tuple(QUADS_AT[kind] for kind in self.corners)

    @property
    def convex(self) -> bool:
        """Has it no reflex corner?"""
        return "reflex" not in self.corners

    def _refuse_counts(self) -> None:
        if not self.lengths:
            raise InvalidBoundaryError(
                "a boundary needs at least one side; for one closed side of 8 edges "
                "write Boundary.closed(8)"
            )
        for i, kind in enumerate(self.corners):
            if kind not in QUADS_AT:
                raise InvalidBoundaryError(
                    f'corner {i} is {kind!r}; a corner is "convex" or "reflex"'
                )
        closed = len(self.lengths) == 1 and not self.corners
        if len(self.corners) != len(self.lengths) and not closed:
            raise InvalidBoundaryError(
                f"{len(self.lengths)} sides have {len(self.lengths)} corners, "
                f"not {len(self.corners)}; name every corner, or leave corners out"
            )

    def _refuse_lengths(self) -> None:
        for side, length in enumerate(self.lengths):
            if length < 1:
                raise InvalidBoundaryError(
                    f"side {side} has length {length}; every side needs at least 1 edge"
                )
        perimeter = self.perimeter
        if perimeter > MAX_PERIMETER:
            raise InvalidBoundaryError(
                f"the perimeter {perimeter} is above the limit of {MAX_PERIMETER} edges; "
                "split the boundary or ask for coarser sides"
            )
        if perimeter % 2:
            raise InvalidBoundaryError(
                f"the perimeter {perimeter} is odd: no quad mesh has an odd boundary; "
                "change one side by 1"
            )
        if perimeter < MIN_PERIMETER:
            raise InvalidBoundaryError(
                f"the perimeter {perimeter} is below {MIN_PERIMETER}, that of one quad; "
                "lengthen a side"
            )


def _whole(length: SupportsIndex | float, side: int) -> int:
    # JSON and arrays may carry 3 as 3.0; that is a whole number all the same.
    if isinstance(length, float) and length.is_integer():
        return int(length)
    try:
        return operator.index(length)  # pyright: ignore[reportArgumentType]
    except TypeError:
        raise InvalidBoundaryError(
            f"side {side} has length {length!r}, which is not a whole number of edges"
        ) from None
