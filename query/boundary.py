"""The boundary to be filled: how many edges each side has, and what its corners are."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from patterndb.errors import InvalidBoundaryError
from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import (
    MAX_EDGES,
    MIN_EDGES,
    edge_counts,
    join_sides,
    sample_polyline,
)

CornerKind = Literal["convex", "reflex", "full"]

#: Quads that a strict fill has at a corner of each kind. A pattern's corner with four or
#: more quads is reflex too, but not what a reflex corner asks for: its extra quads would
#: be an irregular vertex on the boundary. At a full corner, which loops of meshes have where
#: nothing but their own two edges meets outside, four are asked for; only strict fills have one.
QUADS_AT: dict[CornerKind, int] = {"convex": 1, "reflex": 3, "full": 4}

#: Limits of the number of edges around a boundary; see :mod:`patterndb.geometry.polyline`.
MIN_PERIMETER = MIN_EDGES
MAX_PERIMETER = MAX_EDGES


@dataclass(frozen=True, slots=True)
class Boundary:
    """N sides, counter-clockwise.

    lengths: edges of every side, each >= 1. Side i runs from corner i to corner i + 1.
    corners: "convex" or "reflex" for every corner; corner i is where side i begins. All
             are convex by default. ``corners=()`` with one length is one closed side
             (N = 0), see :meth:`closed`.
    points:  (P, 3) float64, where the boundary vertices lie, 0 where side 0 begins, or None.
             Given as (P, 2) they lie in the plane z = 0. They decide how fills are ranked
             and placed, not which there are; boundaries compare without them.

    Raises InvalidBoundaryError, with what would mend it, for an odd perimeter, one below
    MIN_PERIMETER or above MAX_PERIMETER, a length that is no whole number >= 1, for
    numbers of sides and corners that do not go together, and for points that are not P
    finite ones, each apart from the next.

    >>> Boundary((3, 4, 5)).perimeter
    12
    """

    lengths: tuple[int, ...]
    corners: tuple[CornerKind, ...]
    points: Points | None = field(compare=False, repr=False)

    def __init__(
        self,
        lengths: Iterable[SupportsIndex | float],
        corners: Iterable[CornerKind] | None = None,
        points: ArrayLike | None = None,
    ) -> None:
        whole = tuple(_whole(length, side) for side, length in enumerate(lengths))
        kinds = ("convex",) * len(whole) if corners is None else tuple(corners)
        object.__setattr__(self, "lengths", whole)
        object.__setattr__(self, "corners", kinds)
        self._refuse_counts()
        self._refuse_lengths()
        object.__setattr__(self, "points", None if points is None else self._placed(points))

    @classmethod
    def closed(cls, length: SupportsIndex | float, points: ArrayLike | None = None) -> Boundary:
        """One closed side of ``length`` edges without any corner: N = 0."""
        return cls((length,), corners=(), points=points)

    @classmethod
    def from_polylines(
        cls,
        sides: Sequence[ArrayLike],
        *,
        lengths: Iterable[SupportsIndex | float] | None = None,
        edge_length: float | None = None,
        corners: Iterable[CornerKind] | None = None,
    ) -> Boundary:
        """The boundary that runs along polylines, in edges of equal arc length.

        sides: a (k, 3) or (k, 2) polyline per side, k >= 2, counter-clockwise, each ending
        where the next begins; with ``corners=()`` one closed polyline. lengths: edges of every
        side; or edge_length: about how long an edge shall be, in the units of the points. Then
        the side that suffers least has one edge more or fewer if the perimeter were odd.
        Raises InvalidBoundaryError for polylines that do not join, have no length, or are not
        finite, and where neither or both of lengths and edge_length are given.
        """
        if (lengths is None) == (edge_length is None):
            raise InvalidBoundaryError("give either the lengths of the sides or an edge_length")
        corners = None if corners is None else tuple(corners)
        chains = join_sides(sides, corners == ())
        if lengths is None:
            assert edge_length is not None
            lengths = edge_counts(chains, edge_length)
        unplaced = cls(lengths, corners)
        if len(unplaced.lengths) != len(chains):
            raise InvalidBoundaryError(
                f"{len(chains)} polylines have {len(unplaced.lengths)} lengths; give one for each"
            )
        along = [
            sample_polyline(chain, length)[:-1]
            for chain, length in zip(chains, unplaced.lengths, strict=True)
        ]
        return cls(unplaced.lengths, unplaced.corners, np.concatenate(along))

    @classmethod
    def from_vertices(
        cls, sides: Sequence[ArrayLike], *, corners: Iterable[CornerKind] | None = None
    ) -> Boundary:
        """The boundary whose vertices are the points of polylines, bit for bit.

        sides: as for :meth:`from_polylines`, but that nothing is placed anew: a polyline of k
        points has k - 1 edges. Raises InvalidBoundaryError for polylines that do not join, and
        as the class does.
        """
        corners = None if corners is None else tuple(corners)
        chains = join_sides(sides, corners == ())
        along = [chain[:-1] for chain in chains]
        return cls([len(chain) for chain in along], corners, np.concatenate(along))

    def __repr__(self) -> str:
        lengths = ", ".join(map(str, self.lengths))
        what = f"sides {lengths}" if self.corners else f"one closed side of {lengths}"
        others = [f"{kind} at {i}" for i, kind in enumerate(self.corners) if kind != "convex"]
        corners = f", {', '.join(others)}" if others else ""
        placed = "" if self.points is None else ", placed"
        return f"<Boundary of {what}: {self.perimeter:,} edges{corners}{placed}>"

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
        """Has it no corner but convex ones?"""
        return all(kind == "convex" for kind in self.corners)

    @property
    def n_reflex(self) -> int:
        """How many corners have more than two quads."""
        return sum(kind != "convex" for kind in self.corners)

    @property
    def side_starts(self) -> tuple[int, ...]:
        """The boundary vertex at which every side begins, and the perimeter after the last."""
        return (0, *accumulate(self.lengths))

    def _placed(self, points: ArrayLike) -> Points:
        placed = as_points(points, "points")
        if len(placed) != self.perimeter:
            raise InvalidBoundaryError(
                f"{len(placed)} points for {self.perimeter} boundary vertices; give one for "
                "each, a corner once"
            )
        short = np.flatnonzero((placed == np.roll(placed, -1, axis=0)).all(axis=1))
        if len(short):
            at = int(short[0])
            raise InvalidBoundaryError(
                f"boundary vertices {at} and {(at + 1) % len(placed)} are at one point; "
                "move them apart"
            )
        placed.flags.writeable = False
        return placed

    def _refuse_counts(self) -> None:
        if not self.lengths:
            raise InvalidBoundaryError(
                "a boundary needs at least one side; for one closed side of 8 edges "
                "write Boundary.closed(8)"
            )
        for i, kind in enumerate(self.corners):
            if kind not in QUADS_AT:
                raise InvalidBoundaryError(
                    f'corner {i} is {kind!r}; a corner is "convex", "reflex" or "full"'
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
