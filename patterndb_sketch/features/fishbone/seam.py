"""The cheapest way across the ribs of a closed curve, which comes back to the row it began in."""

from __future__ import annotations

import heapq
from collections.abc import Callable

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats

#: Finds the cheapest rows of a table of costs (m, k), and what they cost.
RowSolver = Callable[[Floats], tuple[Int64Array, float]]


def unroll_table(table: Floats, seam: int, fill: float) -> Floats:
    """(m + 1, k + abs(seam), ...) the ribs of a table (m, k, ...) and the first once more, rows so
    that those that belong together at the seam are the same; fill where there is no sample."""
    m, k = table.shape[:2]
    result = np.full((m + 1, k + abs(seam), *table.shape[2:]), fill)
    begin, again = max(seam, 0), max(-seam, 0)
    result[:m, begin : begin + k] = table
    result[m, again : again + k] = table[0]
    return result


def solve_around(costs: Floats, seam: int, solve: RowSolver) -> tuple[Int64Array, float]:
    """((m,), cost) the cheapest rows that go round: from the last rib on to the first.

    costs: (m, k) of samples, inf where a rib may not be cut. seam: as of Fishbone. solve: finds the
    cheapest way from end to end through an unrolled table, see :func:`unroll_table`.

    Exact, by branch and bound: unrolled, the first rib is there twice. A way that is in the same
    row of both is the cheapest round; one that is not costs at most as much as that. Then the rows
    of the first rib are divided between the two, and the cheaper half is looked at first. A curve
    along a crease comes back to its row at once.
    """
    first = max(seam, 0)
    rows = np.flatnonzero(np.isfinite(costs[0]))
    unrolled = unroll_table(costs, seam, np.inf)
    again = max(-seam, 0)
    order = 0

    def solve_within(allowed: Int64Array) -> tuple[float, int, Int64Array, Int64Array]:
        nonlocal order
        table = unrolled.copy()
        table[0], table[-1] = np.inf, np.inf
        table[0, allowed + first] = costs[0, allowed]
        # What the first rib costs has been counted.
        table[-1, allowed + again] = 0.0
        found, cost = solve(table)
        order += 1
        return cost, order, found, allowed

    open_ = [solve_within(rows)]
    while True:
        cost, _, found, allowed = heapq.heappop(open_)
        begin, end = int(found[0]) - first, int(found[-1]) - again
        if begin == end:
            return found[:-1] - first, cost
        # Between the two: neither half has both.
        part = (begin + end) // 2
        for half in (allowed[allowed <= part], allowed[allowed > part]):
            heapq.heappush(open_, solve_within(half))
