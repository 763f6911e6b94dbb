"""What a query asks of a pattern beside its lengths."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.patternclass import PatternClass
from query.boundary import Boundary
from query.errors import InvalidQueryError

Range = tuple[int, int]

#: Interior vertices of two quads make poor meshes: refused unless asked for.
NO_DOUBLETS: Range = (3, 10_000)


class Columns(Protocol):
    """What filters look at: (r,) arrays over patterns."""

    @property
    def ids(self) -> NDArray[np.int64]: ...
    @property
    def frequency(self) -> NDArray[np.int64]: ...
    @property
    def n_quads(self) -> Int32Array: ...
    @property
    def n_loops(self) -> Int32Array: ...
    @property
    def min_valence(self) -> Int32Array: ...
    @property
    def max_valence(self) -> Int32Array: ...


@dataclass(frozen=True, slots=True)
class Filters:
    """What may be asked for; None asks for nothing.

    max_irregular: the most irregular vertices, interior and boundary.
    valence:  (least, greatest) valence of every irregular interior vertex. A pattern without
              any passes.
    max_quads: the most quads of a fill.
    corners:  (least, greatest) number of corners of the pattern.
    has_loop: has the pattern a loop polychord?
    min_frequency: the fewest patches in which the pattern was seen.
    max_boundary_irregular: the most irregular vertices on the boundary.
    ids:      (k,) int64, ascending: patterns that may be taken, see
              :meth:`patterndb.store.Database.pattern_ids`.

    Raises InvalidQueryError for a negative bound or an empty range.
    """

    max_irregular: int | None = None
    valence: Range | None = None
    max_quads: int | None = None
    corners: Range | None = None
    has_loop: bool | None = None
    min_frequency: int | None = None
    max_boundary_irregular: int | None = None
    ids: NDArray[np.int64] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        if self.max_irregular is not None and self.max_irregular < 0:
            raise InvalidQueryError(
                f"max_irregular is {self.max_irregular}; 0 asks for regular fills only"
            )
        if self.max_boundary_irregular is not None and self.max_boundary_irregular < 0:
            raise InvalidQueryError(
                f"max_boundary_irregular is {self.max_boundary_irregular}; 0 asks for strict "
                "fills only"
            )
        if self.valence is not None and not 1 <= self.valence[0] <= self.valence[1]:
            raise InvalidQueryError(
                f"valence is {self.valence}; write (least, greatest), such as (3, 5)"
            )
        if self.corners is not None and not 0 <= self.corners[0] <= self.corners[1]:
            raise InvalidQueryError(
                f"corners is {self.corners}; write (least, greatest), such as (4, 6)"
            )
        for name, value in (("max_quads", self.max_quads), ("min_frequency", self.min_frequency)):
            if value is not None and value < 1:
                raise InvalidQueryError(f"{name} is {value}; the least is 1, None leaves it open")

    def rows(self, patterns: PatternClass, boundary: Boundary) -> NDArray[np.int64]:
        """(r,) int64 rows, ascending, that pass and have the boundary's corner kinds in number."""
        same_kinds = patterns.n_reflex == boundary.n_reflex
        return np.flatnonzero(same_kinds & self.passing(patterns))

    def passing(self, patterns: PatternClass) -> NDArray[np.bool_]:
        """(p,) bool: which patterns of the class pass, as strict fills."""
        passes = self.admitted(patterns, np.full(len(patterns), patterns.n_sides, np.int32))
        if self.max_irregular is not None:
            passes &= patterns.n_irregular <= self.max_irregular
        return passes

    def admitted(self, patterns: Columns, n_corners: Int32Array) -> NDArray[np.bool_]:
        """(r,) bool: which patterns pass, whatever their fills' irregular vertices.

        n_corners: (r,) their corners.
        """
        passes = np.ones(len(patterns.ids), np.bool_)
        if self.valence is not None:
            # Without irregular vertices both bounds are 4.
            least, greatest = self.valence
            within = (patterns.min_valence >= least) & (patterns.max_valence <= greatest)
            passes &= within | ((patterns.min_valence == 4) & (patterns.max_valence == 4))
        if self.max_quads is not None:
            passes &= patterns.n_quads <= self.max_quads
        if self.corners is not None:
            passes &= (n_corners >= self.corners[0]) & (n_corners <= self.corners[1])
        if self.has_loop is not None:
            passes &= (patterns.n_loops > 0) == self.has_loop
        if self.min_frequency is not None:
            passes &= patterns.frequency >= self.min_frequency
        if self.ids is not None:
            passes &= np.isin(patterns.ids, self.ids)
        return passes
