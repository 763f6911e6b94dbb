"""Polylines along the smooth curves that drawn samples stand for, to compare these curves."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.surfacing.joining.meetings import Joins, find_joins
from patterndb_sketch.surfacing.joining.polylines import PackedCurves, pack_curves
from patterndb_sketch.surfacing.joining.sagittas import (
    find_neighbours,
    guess_curves,
    measure_sample_turning,
)
from patterndb_sketch.surfacing.sampling import CORNER_ANGLE

#: Curves are followed until edges are off by this share of the diagonal: a hundredth of what
#: strokes are off by at least.
FOLLOWED = 5e-5

#: The most edges that follow the curve between two samples.
MOST_EDGES = 12

#: A smooth curve of few samples turns by up to this at each of them, in radians, if its neighbours
#: turn by more than EVENLY as much; a corner stands out.
SPARSE_ANGLE = math.radians(60)
EVENLY = 0.5


@dataclass(frozen=True, slots=True)
class FollowedCurves:
    """Drawn curves, followed finely.

    curves: the fine polylines. drawn: (n,) which of their points are drawn samples, or places
    where curves meet exactly. fringes: (n,) for the edge that begins at every point how far the
    drawn polyline may be from the curve there. exact: where polylines meet as they are, at points
    of both.
    """

    curves: PackedCurves
    drawn: NDArray[np.bool_] = field(repr=False)
    fringes: Floats = field(repr=False)
    exact: Joins = field(repr=False)

    def measure_fringes(self, joins: Joins) -> Floats:
        """(m,) how far the drawn polylines of both curves may be from them where they join."""
        edges = self.curves.find_edges(joins.curves.reshape(-1), joins.lengths.reshape(-1))
        return self.fringes[edges].reshape(-1, 2).sum(axis=1)


def follow_curves(lines: list[Points], exact: float, diagonal: float) -> FollowedCurves:
    """Follow the smooth curves that polylines (k, 3) stand for.

    exact: polylines that are no further apart meet.
    """
    rough = pack_curves(lines)
    joins = find_joins(rough, np.full(len(rough), exact))
    curve, length = joins.curves.reshape(-1), joins.lengths.reshape(-1)
    full = _insert_places(rough, curve, length, exact)
    guessed = guess_curves(full, _find_smooth_samples(full))
    pieces = np.ceil(np.sqrt(guessed.sagitta / (FOLLOWED * diagonal)))
    pieces = np.clip(pieces, 1, MOST_EDGES).astype(np.int64)
    first = np.r_[0, np.cumsum(pieces)]
    edges = np.repeat(np.arange(len(pieces)), pieces)
    shares = (np.arange(first[-1]) - first[edges]) / pieces[edges]
    points = full.points[edges]
    between = np.flatnonzero(shares > 0.0)
    points[between] = guessed.locate(edges[between], shares[between])[0]
    fine = pack_curves(np.split(points, first[full.starts[1:-1]]))
    drawn = np.zeros(len(points), bool)
    drawn[first[:-1]] = True
    met = fine.along[first[full.find_vertices(curve, length)]].reshape(-1, 2)
    joined = Joins(joins.curves, met, np.zeros(len(joins)), joins.meetings)
    return FollowedCurves(fine, drawn, guessed.sagitta[edges], joined)


def _insert_places(
    curves: PackedCurves, curve: NDArray[np.int64], length: Floats, exact: float
) -> PackedCurves:
    """Give curves a point at every place that has none within ``exact`` along the curve."""
    curve, length = curves.select_between_points(curve, length, exact)
    at = curves.find_edges(curve, length) + 1
    points = np.insert(curves.points, at, curves.locate(curve, length), axis=0)
    sizes = np.diff(curves.starts) + np.bincount(curve, minlength=len(curves))
    return pack_curves(np.split(points, np.cumsum(sizes)[:-1]))


def _find_smooth_samples(curves: PackedCurves) -> NDArray[np.bool_]:
    """(n,) which samples are not corners: they turn little, or about as their neighbours do."""
    turning = measure_sample_turning(curves)
    before, after, inner = find_neighbours(curves)
    least = np.minimum(
        np.where(inner[before], turning[before], turning[after]),
        np.where(inner[after], turning[after], turning[before]),
    )
    evenly = inner & (turning <= SPARSE_ANGLE) & (least > EVENLY * turning)
    return (turning <= CORNER_ANGLE) | evenly
