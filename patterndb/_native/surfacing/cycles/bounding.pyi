# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats

def spread_costs(
    first: Int64Array,
    member: Int64Array,
    place: Int64Array,
    start: Int64Array,
    offset: Int64Array,
    one: Int64Array,
    other: Int64Array,
    price: Floats,
    cost: Floats,
) -> None:
    """Write the costs of pairs to the tables of the curves that they share, in equal parts.

    The candidates at curve c are rows and columns of cost[offset[c] : offset[c + 1]]. What cannot
    be had costs all at each.
    """

def move_shares(
    first: Int64Array,
    member: Int64Array,
    place: Int64Array,
    start: Int64Array,
    offset: Int64Array,
    cost: Floats,
    room: Int64Array,
    whole: NDArray[np.bool_],
    shares: Floats,
    margin: Floats,
    sweeps: int,
) -> float:
    """Move shares until what the best at all curves are worth is little; returns their sum.

    margin: written for every candidate and curve: what the best there gain by having it.
    """
