"""What a query asks of a pattern beside its lengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.patternclass import PatternClass
from query.boundary import Boundary
from query.errors import InvalidQueryError


@dataclass(frozen=True, slots=True)
class Filters:
    """Bounds on the irregular vertices; None is no bound.

    max_irregular: the most irregular vertices.
    valence: (least, greatest) valence of every irregular vertex. A pattern without any
             passes.

    Raises InvalidQueryError for a negative bound or an empty range.
    """

    max_irregular: int | None = None
    valence: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.max_irregular is not None and self.max_irregular < 0:
            raise InvalidQueryError(
                f"max_irregular is {self.max_irregular}; 0 asks for regular fills only"
            )
        if self.valence is not None and not 1 <= self.valence[0] <= self.valence[1]:
            raise InvalidQueryError(
                f"valence is {self.valence}; write (least, greatest), such as (3, 5)"
            )

    def rows(self, patterns: PatternClass, boundary: Boundary) -> NDArray[np.int64]:
        """(r,) int64 rows, ascending, that pass and have the boundary's corner kinds in number."""
        same_kinds = patterns.n_reflex == boundary.corners.count("reflex")
        return np.flatnonzero(same_kinds & self.passing(patterns))

    def passing(self, patterns: PatternClass) -> NDArray[np.bool_]:
        """(p,) bool: which patterns of the class pass."""
        passes = np.ones(len(patterns), np.bool_)
        if self.max_irregular is not None:
            passes = passes & (patterns.n_irregular <= self.max_irregular)
        if self.valence is not None:
            least, greatest = self.valence
            within = (patterns.min_valence >= least) & (patterns.max_valence <= greatest)
            passes = passes & (within | (patterns.n_irregular == 0))
        return passes
