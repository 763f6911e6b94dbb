"""Which approaches of drawn curves are meant as meetings."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb_sketch.surfacing.joining.following import FollowedCurves
from patterndb_sketch.surfacing.joining.meetings import Joins
from patterndb_sketch.surfacing.joining.survey import (
    Survey,
    find_nearest_at_ends,
    is_near_end,
)

#: Curves may be apart by this share more of what sparse samples leave out, at most twice as far.
LOOSE = 0.5

#: Curves that are placed exactly elsewhere pass each other on purpose, unless they are within so
#: many times what their samples leave out, or within this share of the tolerance.
SURE_FRINGE = 2.0

#: An end that is nearer to one curve than this share of the distance to another does not need the
#: other.
SATISFIED = 0.1


def measure_allowance(
    followed: FollowedCurves, survey: Survey, joins: Joins, exact: float
) -> Floats:
    """(m,) how far apart curves may be at approaches to meet there."""
    curves = followed.curves
    has_end = curves.is_open_end(joins.curves, joins.lengths).any(axis=1)
    fringes = followed.measure_fringes(joins)
    allowed = np.where(has_end, survey.ends, survey.crossings)
    allowed = allowed + np.minimum(LOOSE * fringes, allowed)
    if not survey.given:
        both = survey.placed[joins.curves].all(axis=1)
        sure = np.minimum(allowed, np.maximum(SURE_FRINGE * fringes, exact))
        allowed = np.where(both, sure, allowed)
    return allowed


def select_joins(
    followed: FollowedCurves,
    survey: Survey,
    approaches: Joins,
    copies: Int64Array,
    exact: float,
) -> Joins:
    """Select the approaches that are meant: near enough, and needed by an end if there is one.

    copies: (k, 2) pairs of curves that may be drawn over each other. exact: what is no further
    apart meets anyway.
    """
    curves = followed.curves
    allowed = measure_allowance(followed, survey, approaches, exact)
    near = approaches.take(approaches.gaps <= allowed)
    nearest = find_nearest_at_ends(curves, near.append(followed.exact), survey.ends, copies)
    # An end that goes on too far needs what its curve meets shortly before.
    needed = ~curves.is_open_end(near.curves, near.lengths).any(axis=1)
    for side in range(2):
        curve = near.curves[:, side]
        ends = is_near_end(curves, curve, near.lengths[:, side], survey.ends)
        ends &= nearest[curve] >= SATISFIED * near.gaps[:, None] - exact
        needed |= ends.any(axis=1)
    return near.take(needed)
