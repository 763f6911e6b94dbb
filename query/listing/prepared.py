"""A request for one boundary, prepared for its search."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from patterndb.core.patternclass import PatternClass
from query.boundary import Boundary
from query.fill import Fill
from query.listing.orders import FillOrder
from query.listing.table import Frequencies, Table
from query.request import FillRequest

#: Where at most so many fills of a pattern are listed, orders that measure fills look at so many
#: patterns at least, as far as there are.
PATTERNS_IN_POOL = 20


@dataclass(frozen=True, slots=True, eq=False)
class PreparedQuery:
    """A request for one boundary, with what a database answers it from.

    request:  its order is that of ``order``; max_boundary_irregular is 0 where it is strict.
    patterns: the class of the boundary's number of sides.
    frequencies: gives the patches in which patterns of these ids, of any class, were seen; None
              where only the class is known.
    ids:      (k,) int64, ascending: learned patterns that may be taken, by their meshes and
              licences; None for all.
    only:     the patterns that may be taken, also of constructed fills; None for all.
    known:    a fill that is not to be listed again.
    """

    request: FillRequest
    boundary: Boundary
    order: FillOrder
    patterns: PatternClass
    frequencies: Frequencies | None = None
    ids: NDArray[np.int64] | None = None
    only: frozenset[int] | None = None
    known: Fill | None = None

    def change(self, **options: Any) -> PreparedQuery:
        """Return the query with other options of its request."""
        return replace(self, request=msgspec.structs.replace(self.request, **options))

    @property
    def of_few(self) -> bool:
        """Is it for some patterns by name, so that nobody else will ask the same?"""
        return self.ids is not None or self.only is not None

    @property
    def most_looked_at(self) -> int | None:
        """The most fills of one pattern that are made: more than are listed, where an order has to
        measure them to tell which of them come first."""
        most = self.request.per_pattern
        if most is None or self.order.measure is None:
            return most
        return max(most, self.request.pool // PATTERNS_IN_POOL)

    def admit_rows(self, table: Table) -> NDArray[np.bool_]:
        """(r,) bool: which patterns of a table may be taken."""
        passes = self.request.admit_patterns(table)
        if self.ids is not None:
            passes &= np.isin(table.ids, self.ids)
        if self.only is not None:
            passes &= np.isin(table.ids, list(self.only))
        return passes
