"""The cheapest way across the ribs that keeps to one crease: the ribs are judged together, by how
the surface bends at them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from patterndb._native.features.fishbone.tracking import track
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone.cut import (
    RibCut,
    check_costs,
    solve_around,
    unroll_table,
)
from patterndb_sketch.features.fishbone.fishbone import Fishbone

#: How steeply a crease runs across the rows at most, as the tangent of its angle to the backbone:
#: what goes farther from one rib to the next leaps.
SLOPE = 1.0

#: What a leap costs, as a multiple of the price of the rows that it passes.
LEAP = 3.0


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
