"""Polychords: the strips of quads that run through opposite edges.

Every quad lies on two strands (edges 0 and 2, edges 1 and 3); a polychord is a maximal
chain of strands. It is open, between two border edges, or a loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.polychord import trace
from patterndb.core.halfedge import Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class Polychords:
    """All polychords of a quad complex; open ones are numbered first.

    of_edge: (4q,) int32, the polychord that crosses each half-edge.
    n_open:  number of open polychords, 0..n_open - 1.
    n_loops: number of loops, n_open..n_open + n_loops - 1.
    crosses_itself: (n_open + n_loops,) bool, does it pass a quad twice?
    """

    of_edge: Int32Array
    n_open: int
    n_loops: int
    crosses_itself: NDArray[np.bool_]

    @property
    def n(self) -> int:
        return self.n_open + self.n_loops

    @property
    def of_strand(self) -> Int32Array:
        """(q, 2) int32 polychord through edges 0 and 2, and through edges 1 and 3."""
        return self.of_edge.reshape(-1, 4)[:, :2]


def polychords(twin: Int32Array) -> Polychords:
    """Trace all polychords; open ones in order of their first border half-edge."""
    of_edge, n_open, n_total = trace(twin)
    strands = of_edge.reshape(-1, 4)
    crosses = np.zeros(n_total, np.bool_)
    crosses[strands[strands[:, 0] == strands[:, 1], 0]] = True
    return Polychords(of_edge, n_open, n_total - n_open, crosses)
