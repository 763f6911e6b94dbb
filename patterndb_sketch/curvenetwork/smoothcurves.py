"""The smooth curves that drawn samples stand for: guessed between samples, and followed finely."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.curvenetwork.meetings import Joins, find_joins
from patterndb_sketch.curvenetwork.polylines import (
    CORNER_ANGLE,
    PackedCurves,
    measure_angles,
    pack_curves,
)

#: Curves are followed until edges are off by this share of the diagonal: a hundredth of what
#: strokes are off by at least.
FOLLOWED = 5e-5

#: The most edges that follow the curve between two samples.
MOST_EDGES = 12

#: A smooth curve of few samples turns by up to this at each of them, in radians, if its neighbours
#: turn by more than EVENLY as much; a corner stands out.
SPARSE_ANGLE = math.radians(60)
EVENLY = 0.5


#: Guessed curves meet if they come as near to each other as this share of their sagittas: of an
#: arc sampled every 20 degrees the guess is off by 0.01 of it. Beside ends and corners, where the
#: second derivative is that of the next sample, and of two curves that are drawn exactly, END_FIT.
FIT = 0.05
END_FIT = 0.3


@dataclass(frozen=True, slots=True)
class GuessedCurves:
    """Curves between the samples of polylines, as cubics; n samples, an edge from each to the next.

    sagitta: (n,) how far every edge may be from its curve. fit: (n,) how far the curve may be
    from its guess. bends: (n, 3) second derivatives by arc length at the samples, as seen from the
    edge that begins there; after: (n, 3) likewise at its end.
    """

    points: Points = field(repr=False)
    sagitta: Floats = field(repr=False)
    fit: Floats = field(repr=False)
    bends: Points = field(repr=False)
    after: Points = field(repr=False)

    def locate(self, edges: Int64Array, shares: Floats) -> tuple[Points, Points]:
        """The places (k, 3) at shares (k,) of edges on the curves, and their derivatives."""
        start = self.points[edges]
        step = self.points[edges + 1] - start
        s = shares[:, None]
        r = 1.0 - s
        scale = (step * step).sum(axis=1)[:, None] / 6.0
        bends, after = self.bends[edges], self.after[edges]
        at = start + s * step - scale * (bends * (r - r**3) + after * (s - s**3))
        slope = step - scale * (bends * (3.0 * r**2 - 1.0) + after * (1.0 - 3.0 * s**2))
        return at, slope


def guess_curves(curves: PackedCurves, smooth: NDArray[np.bool_] | None = None) -> GuessedCurves:
    """Guess the curves between the samples of polylines.

    smooth: (n,) which samples are not corners; by default those that turn by no more than
    CORNER_ANGLE. Ends of open curves never are.
    """
    points = curves.points
    before, after, inner = find_neighbours(curves)
    here = np.flatnonzero(inner)
    steps = points[here] - points[before[here]], points[after[here]] - points[here]
    sizes = [np.linalg.norm(step, axis=1)[:, None] for step in steps]
    # Steps so short in comparison that their squares vanish have no direction.
    units = [
        step / np.where(size > 0.0, size, 1.0) for step, size in zip(steps, sizes, strict=True)
    ]
    both = sizes[0] + sizes[1]
    bends = np.zeros_like(points)
    bends[here] = 2.0 * (units[1] - units[0]) / np.where(both > 0.0, both, 1.0)
    turning = measure_sample_turning(curves)
    smooth = inner & (turning <= CORNER_ANGLE if smooth is None else smooth)
    bends[~smooth] = 0.0
    turning[~smooth] = 0.0
    # A corner is as its neighbour across the edge.
    start, end = np.arange(len(points) - 1), np.arange(1, len(points))
    bends_start = np.where(smooth[start, None], bends[start], bends[end])
    bends_end = np.where(smooth[end, None], bends[end], bends[start])
    size = np.linalg.norm(points[end] - points[start], axis=1)
    sagitta = size * np.maximum(turning[start], turning[end]) / 8.0
    sagitta[curves.starts[1:-1] - 1] = 0.0
    fit = np.where(smooth[start] & smooth[end], FIT, END_FIT) * sagitta
    none = np.zeros((1, 3))
    return GuessedCurves(
        points,
        np.r_[sagitta, 0.0],
        np.r_[fit, 0.0],
        np.concatenate([bends_start, none]),
        np.concatenate([bends_end, none]),
    )


def find_neighbours(curves: PackedCurves) -> tuple[Int64Array, Int64Array, NDArray[np.bool_]]:
    """Find the samples (n,) before and after every sample, and which samples have both.

    Closed curves go on beyond their seam. An end of an open curve is its own neighbour.
    """
    first, last = curves.starts[:-1], curves.starts[1:] - 1
    before, after = np.arange(len(curves.points)) - 1, np.arange(len(curves.points)) + 1
    before[first] = np.where(curves.closed, last - 1, first)
    after[last] = np.where(curves.closed, first + 1, last)
    inner = np.ones(len(curves.points), bool)
    inner[first] = inner[last] = curves.closed
    return before, after, inner


def measure_sample_turning(curves: PackedCurves) -> Floats:
    """(n,) by how much polylines turn at their samples, in radians; at open ends 0."""
    before, after, inner = find_neighbours(curves)
    here = np.flatnonzero(inner)
    points = curves.points
    turning = np.zeros(len(points))
    turning[here] = measure_angles(
        points[here] - points[before[here]], points[after[here]] - points[here]
    )
    return turning


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
