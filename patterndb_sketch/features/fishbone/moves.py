"""How far a cut moves the curve, rib by rib."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.fishbone.fishbone import Fishbone

#: A rib tells where the feature is if its cheapest sample is at least this share as much better
#: than the worst as the middle of all ribs has it: below, neighbours have the more say.
SURE = 0.5


def moves(fishbone: Fishbone, rows: Int64Array, costs: Floats) -> tuple[Points, Int64Array]:
    """(m, 3) how far a cut at rows (m,) moves the curve at each rib, and the places (k,) in the
    fishbone of those ribs that tell that themselves.

    costs: (m, n) those that were cut, from 0 at the best sample to 1 at the worst.

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
        beside = np.interp(fishbone.ribs, fishbone.ribs[told], moved[told, c])
        moved[:, c] += (1.0 - sure) * (beside - moved[:, c])
    return moved, told
