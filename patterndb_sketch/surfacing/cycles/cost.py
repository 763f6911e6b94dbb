"""What speaks against a cycle, and against two cycles beside each other.

A cycle that is chosen earns REWARD times its length, and costs its length times its badness.
Lengths are in median curves of the network.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats
from patterndb_sketch.surfacing.cycles.measures import Measures
from patterndb_sketch.surfacing.network import Cycle

#: What a cycle earns per length. A cycle worse than this is left out even where nothing else
#: would bound its curves.
REWARD = 2.0

#: Badness per unit of flatness, sqrt(lambda3 / lambda1).
FLATNESS = 1.0

#: Badness per radian of bending; the bending of a patch that closes around a corner of the
#: shape, 0.6, is as bad as any: six-sided patches have more.
BENDING = 0.5
MOST_BENDING = 0.6

#: Badness if curves run into the surface at all of its nodes. One of four nodes outweighs what
#: flatness and bending say.
CUTS = 3.0

#: Badness per stroke of the cycle, and per corner beyond four.
STROKE = 0.05
CORNER = 0.15
USUAL_CORNERS = 4

#: Badness of narrowness, length / (4 sqrt(area)) - 1, 0 for a square and below; at most
#: MOST_NARROWNESS counts.
NARROWNESS = 0.3
MOST_NARROWNESS = 5.0

#: An area below this part of the squared length encloses nothing: two curves drawn twice.
NO_AREA = 1e-9

#: Two cycles at a curve fold back on each other if their surfaces there are less than acos(0.9),
#: 26 degrees, apart. FOLD is the cost of lying on each other, per length.
FOLD_COSINE = 0.9
FOLD = 1.0


def badness(measures: Measures, n_curves: Floats, n_strokes: Floats) -> Floats:
    """(k,) the badness of cycles with so many curves and strokes (k,), inf if they enclose nothing.

    A plainer cost, length (1 + 6 sqrt(lambda3 / lambda1)) (1 + 0.1 strokes), does not know a patch
    that a curve runs into.
    """
    length, area = measures.length, measures.area
    enclosing = area > NO_AREA * length**2
    narrowness = length / (4.0 * np.sqrt(np.where(enclosing, area, 1.0))) - 1.0
    bad = (
        FLATNESS * measures.flatness
        + BENDING * np.minimum(measures.bending, MOST_BENDING)
        + CUTS * measures.cuts / n_curves
        + STROKE * n_strokes
        + CORNER * np.maximum(measures.corners - USUAL_CORNERS, 0.0)
        + NARROWNESS * np.clip(narrowness, 0.0, MOST_NARROWNESS)
    )
    return np.where(enclosing, bad, np.inf)


def folds(
    cycles: Sequence[Cycle], inward: Sequence[NDArray[np.float64]], length: Floats
) -> dict[tuple[int, int], float]:
    """What pairs of cycles cost because they fold back on each other at curves they share.

    inward: per cycle the directions (steps, 3) of :class:`Measures`. length: (m,) of the
    network's curves.
    """
    at: dict[int, list[tuple[int, NDArray[np.float64]]]] = {}
    for i, (cycle, directions) in enumerate(zip(cycles, inward, strict=True)):
        for curve, direction in zip(cycle.curves, directions, strict=True):
            at.setdefault(curve, []).append((i, direction))
    cost: dict[tuple[int, int], float] = {}
    for curve, meeting in sorted(at.items()):
        directions = np.array([direction for _, direction in meeting])
        fold = np.maximum(directions @ directions.T - FOLD_COSINE, 0.0) / (1.0 - FOLD_COSINE)
        for a, b in np.argwhere(np.triu(fold, 1) > 0.0).tolist():
            pair = meeting[a][0], meeting[b][0]
            cost[pair] = cost.get(pair, 0.0) + float(FOLD * length[curve] * fold[a, b])
    return cost
