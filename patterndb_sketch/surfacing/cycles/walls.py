"""Walls: cycles that stand on curves which bound two others already, such as a fin on a sheet, a
partition, or one of two sheets that cross.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from patterndb.geometry.points import Floats
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle, total_length
from patterndb_sketch.surfacing.cycles.found import list_users
from patterndb_sketch.surfacing.cycles.packing import SIDES

#: The worst badness of a wall. In the CASSIE sketches four are found, all recorded, those of every
#: second one being unchanged; up to 0.5 there are 22, of which 8 are recorded.
WORST_WALL = 0.3

#: At least this share of a wall's length runs along curves that bound less than two others.
FREE_SHARE = 0.5


def find_walls(
    network: CurveNetwork,
    cycles: Sequence[Cycle],
    bad: Floats,
    folds: Mapping[tuple[int, int], float],
    chosen: Sequence[int],
) -> list[int]:
    """The numbers of candidates that stand on the chosen ones, or on each other.

    bad: (k,) the candidates' badness. folds: what pairs of them cost that lie on each other, as
    :func:`patterndb_sketch.surfacing.cycles.measures.price_folds` has it. chosen: numbers of those
    that are.

    The best come first. A wall lies on none of the others, and shares a curve with two of them;
    where all its curves have room it was left out for other reasons.
    """
    users = {c: len(walks) for c, walks in list_users([cycles[i] for i in chosen]).items()}
    beneath: dict[int, set[int]] = {}
    for (i, j), cost in folds.items():
        if cost > 0.0:
            beneath.setdefault(i, set()).add(j)
            beneath.setdefault(j, set()).add(i)
    taken = set(chosen)
    walls: list[int] = []
    for i in np.argsort(bad, kind="stable").tolist():
        if bad[i] > WORST_WALL:
            break
        if i in taken or not taken.isdisjoint(beneath.get(i, ())):
            continue
        curves = cycles[i].curves
        free = [curve for curve in curves if users.get(curve, 0) < SIDES]
        share = total_length(network, free) / total_length(network, curves)
        if len(free) == len(curves) or share < FREE_SHARE:
            continue
        taken.add(i)
        walls.append(i)
        for curve in curves:
            users[curve] = users.get(curve, 0) + 1
    return walls
