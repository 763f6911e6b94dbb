"""What a construction asks of a table of fills: how good a part can be, and then the part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary


@dataclass(frozen=True, slots=True)
class PartFill:
    """Quads that fill a part.

    quads:       (q, 4) int32, counter-clockwise. Boundary vertices are 0..P-1 in the order
                 of the boundary asked for, 0 where its side 0 begins; interior ones follow.
    n_irregular: vertices, interior and boundary, whose number of quads is not what their
                 place asks for.
    """

    quads: Int32Array
    n_irregular: int


class Lookup(Protocol):
    """The best known fills of boundaries with few sides, such as a table of marked patterns."""

    @property
    def max_sides(self) -> int:
        """It is asked about boundaries of 2 to so many sides; the fewest it may say is 4."""
        ...

    def count(self, boundary: Boundary, *, strict: bool = False) -> int | None:
        """The irregular vertices of the best fill, None where it knows none.

        strict: only fills whose corners are exactly as asked. This is asked often and
        should be quick; nothing need be expanded for it.
        """
        ...

    def best(self, boundary: Boundary, *, strict: bool = False) -> PartFill | None:
        """The best fill, with as many irregular vertices as :meth:`count` says."""
        ...
