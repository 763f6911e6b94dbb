"""The cheapest way across the ribs: the minimum cut of the fishbone's graph, exactly; the rows that
it is held at, and how far it moves the curve, rib by rib. Of a closed curve: the cheapest way that
comes back to the row it began in. :func:`track_crease` finds the cheapest way that keeps to one
crease: there the ribs are judged together, by how the surface bends at them.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.features.fishbone.cut import cheapest
from patterndb._native.features.fishbone.tracking import track
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone.fishbone import Fishbone
from patterndb_sketch.features.splines import Constraint

#: A rib tells where the feature is if its cheapest sample is at least this share as much better
#: than the worst as the middle of all ribs has it: below, neighbours have the more say.
SURE = 0.5

#: How steeply a crease runs across the rows at most, as the tangent of its angle to the backbone:
#: what goes farther from one rib to the next leaps.
SLOPE = 1.0

#: What a leap costs, as a multiple of the price of the rows that it passes.
LEAP = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class RibCut:
    """rows: (m,) int64, the sample of every rib that is cut. cost: the capacity of the cut."""

    rows: Int64Array
    cost: float


def cut(costs: ArrayLike, cross: ArrayLike, seam: int | None = None) -> RibCut:
    """The rows r with the least sum of costs[i, r_i] and of cross[i] |r_i - r_i+1|.

    costs: (m, k) float64, not negative, inf where a rib may not be cut.
    cross: (m - 1,) or one number, not negative: the capacity of one cross edge between rib i
           and rib i + 1.
    seam:  of a closed curve, as of Fishbone; cross is (m,) then, the last from the last rib to
           the first. Differs from the paper, whose curves have ends.

    This is the minimum cut of the graph of ribs: column i is a chain of k + 1 nodes whose edges
    are the samples, with capacities ``costs``; the nodes of one row in neighbouring columns are
    joined by cross edges; the first nodes are the source and the last the sink. Cutting
    neighbouring columns at rows r and r' puts the nodes of the |r - r'| rows between them on
    different sides, and so cuts that many cross edges. No cut of the graph is cheaper than the
    best with one sample per column, whatever the cross edges' capacity: where a column is cut
    three times, two of the cuts can be taken back without a cost.

    Columns are taken in turn; the best cost of each row over the column before is its lower
    envelope of cones, by one pass down and one up: O(m k) in all. Of equally cheap rows the one
    that moves less is taken.

    Source: feature curve recovery paper, section 4.3.3; Felzenszwalb and Huttenlocher 2012,
    "Distance transforms of sampled functions". Differs from the paper: dynamic programming in
    place of a maximum flow; the cut is the same, and is found a hundred times as fast. Cross
    edges need not outweigh the samples for it to be monotonic.

    Raises InvalidFeatureError for negative or nan costs, or a rib without a finite cost.
    """
    table, between = check_costs(costs, cross, seam)
    if seam is None:
        return RibCut(*cheapest(table, between))
    return RibCut(*solve_around(table, seam, lambda unrolled: cheapest(unrolled, between)))


def check_costs(
    costs: ArrayLike, cross: ArrayLike, seam: int | None = None
) -> tuple[Floats, Floats]:
    """((m, k), (m - 1,), with a seam (m,)) the costs of a cut and of its cross edges as arrays.

    Raises InvalidFeatureError for negative or nan costs, or a rib without a finite cost.
    """
    table = np.ascontiguousarray(costs, np.float64)
    if table.ndim != 2 or not table.size:
        raise InvalidFeatureError(f"the costs of a cut must be (ribs, samples), got {table.shape}")
    count = len(table) - (seam is None)
    between = np.ascontiguousarray(np.broadcast_to(np.asarray(cross, np.float64), count))
    if not ((table >= 0.0).all() and (between >= 0.0).all() and np.isfinite(between).all()):
        raise InvalidFeatureError("the costs of a cut must be numbers that are not negative")
    closed = np.flatnonzero(~np.isfinite(table).any(axis=1))
    if len(closed):
        raise InvalidFeatureError(
            f"rib {closed[0]} may be cut nowhere: its samples all cost inf; leave it out"
        )
    return table, between


def find_held_rows(fishbone: Fishbone, constraints: Sequence[Constraint]) -> NDArray[np.int64]:
    """(m,) the rows nearest to the constraints of ribs, -1 for ribs without one.

    constraints: (number of a rib, point (3,)); those of ribs that are not there hold nothing.
    """
    rows = np.full(len(fishbone.points), -1, np.int64)
    for number, place in constraints:
        target = as_points(
            np.asarray(place)[None], f"the point of rib {number}", InvalidFeatureError
        )
        for i in np.flatnonzero(fishbone.ribs == number):
            away = np.linalg.norm(fishbone.points[i] - target, axis=1)
            rows[i] = np.argmin(np.where(fishbone.valid[i], away, np.inf))
    return rows


def hold_rows(costs: NDArray[np.float64], rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m, k) costs with 0 at the held rows (m,) and inf elsewhere in their ribs.

    Source: feature curve recovery paper, section 4.3.3.
    """
    result = costs.copy()
    held = np.flatnonzero(rows >= 0)
    result[held] = np.inf
    result[held, rows[held]] = 0.0
    return result


def find_moves(
    fishbone: Fishbone, rows: Int64Array, costs: Floats, period: int | None = None
) -> tuple[Points, Int64Array]:
    """(m, 3) how far a cut at rows (m,) moves the curve at each rib, and the places (k,) in the
    fishbone of those ribs that tell that themselves.

    costs: (m, n) those that were cut, from 0 at the best sample to 1 at the worst. period: of a
    closed curve, how many ribs it has with those that are not in the fishbone.

    Differs from the paper: there all samples count alike. At the ends of a stroke, and where a
    feature fades, ribs miss it and are cut anywhere; a spline through few samples follows.
    The less a rib gains by its cut the more it moves as those beside it, as ribs do that have no
    contour at all.
    """
    moved = fishbone.at(rows) - fishbone.origins
    gains = 1.0 - costs[np.arange(len(rows)), rows]
    usual = SURE * float(np.median(gains))
    sure = np.clip(gains / usual, 0.0, 1.0) if usual > 0.0 else np.ones(len(rows))
    told = np.flatnonzero(sure >= 1.0)
    for c in range(3):
        beside = np.interp(fishbone.ribs, fishbone.ribs[told], moved[told, c], period=period)
        moved[:, c] += (1.0 - sure) * (beside - moved[:, c])
    return moved, told


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


def track_crease(
    costs: ArrayLike,
    cross: ArrayLike,
    bends: Points,
    change: float,
    reach: Int64Array,
    seam: int | None = None,
) -> RibCut:
    """The rows r with the least sum of costs[i, r_i] and of what each two neighbours cost.

    costs: (m, k) float64, not negative, inf where a rib may not be cut.
    cross: (m - 1,) or one number, not negative: the price of a row between ribs i and i + 1.
    bends: (m, k, 3) float64, how the surface bends at every sample: the way and by how much.
    change: at least 0, the price of a crease that is another: of bends that differ by 1.
    reach: (m - 1,) int64, rows that a crease may cross from rib i to rib i + 1.
    seam: of a closed curve, as of Fishbone; cross and reach are (m,) then, the last from the last
        rib to the first.

    Neighbours at rows r and r' within reach cost cross |r - r'| + change |b - b'|: a crease keeps
    its angle, its side and its direction, so that going over to another costs what the one loses
    and the other gains. Farther apart, or if it is cheaper, they cost LEAP cross |r - r'| +
    change (|b| + |b'|): the one crease is left and another is met.

    With change = 0 and an endless reach this is the cut. Exact dynamic programming, rib by rib, in
    O(m k reach).

    Source: feature curve recovery paper, section 4.3.3. Differs from the paper: there the sample
    of a rib costs the same whatever its neighbours are, and a crease is left for a sharper one
    beside it as soon as that saves what the rows between them cost.

    Raises InvalidFeatureError as :func:`patterndb_sketch.features.fishbone.cut` does, and for a
    change that is negative.
    """
    table, between = check_costs(costs, cross, seam)
    if not (math.isfinite(change) and change >= 0.0):
        raise InvalidFeatureError(f"the price of another crease is {change}; give 0 or more")
    ways = np.ascontiguousarray(bends, np.float64)
    if seam is None:
        return RibCut(*track(table, between, ways, change, reach, LEAP))
    around = unroll_table(ways, seam, 0.0)
    return RibCut(
        *solve_around(
            table, seam, lambda unrolled: track(unrolled, between, around, change, reach, LEAP)
        )
    )


def find_reach(fishbone: Fishbone) -> Int64Array:
    """(m - 1,) rows that a crease may cross from each rib to the next, of a closed curve (m,); see
    SLOPE."""
    step = fishbone.steps
    rows = fishbone.valid.shape[1]
    # Ribs of no length have all their samples within reach.
    wanted = np.ceil(SLOPE * fishbone.gaps / np.where(step > 0.0, step, np.nan))
    return np.nan_to_num(np.minimum(wanted, rows), nan=rows).astype(np.int64)
