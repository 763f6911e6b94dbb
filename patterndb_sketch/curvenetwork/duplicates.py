"""Strokes that were drawn over each other: the stretches that two curves have in common.

The cuts of each become cuts of the other there, so that their pieces are copies of one another.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb_sketch.curvenetwork.meetings import Joins
from patterndb_sketch.curvenetwork.polylines import PackedCurves
from patterndb_sketch.curvenetwork.survey import Survey

#: A meeting is a stretch in common if it is longer than so many tolerances on both curves.
LONG = 2.0

#: Closed curves whose distance, at SAMPLES places, varies by less than this share of it, and is
#: more than APART times what meets exactly, run beside each other: they are two.
EVEN = 0.3
SAMPLES = 39
APART = 10.0

#: A cut is carried over to a curve within so many tolerances.
NEAR = 2.0


@dataclass(frozen=True, slots=True)
class Stretches:
    """Stretches that pairs of curves have in common.

    curves: (k, 2). spans: (k, 2, 2) on each of the two the arc lengths where it begins and ends.
    """

    curves: Int64Array = field(repr=False)
    spans: Floats = field(repr=False)

    def __len__(self) -> int:
        return len(self.curves)


def find_stretches(approaches: Joins, tolerance: float) -> Stretches:
    """Find the meetings that are longer than LONG tolerances on both of two curves."""
    order = np.argsort(approaches.meetings, kind="stable")
    first = np.flatnonzero(np.r_[True, np.diff(approaches.meetings[order]) > 0][: len(order)])
    if not len(first):
        return Stretches(np.empty((0, 2), np.int64), np.empty((0, 2, 2)))
    lengths = approaches.lengths[order]
    begins, ends = np.minimum.reduceat(lengths, first), np.maximum.reduceat(lengths, first)
    curves = approaches.curves[order[first]]
    long = (ends - begins).min(axis=1) > LONG * tolerance
    long &= curves[:, 0] != curves[:, 1]
    return Stretches(curves[long], np.stack([begins, ends], axis=2)[long])


def find_duplicates(
    curves: PackedCurves, stretches: Stretches, joins: Joins, survey: Survey, exact: float
) -> Stretches:
    """Find the stretches that are one stroke drawn twice, not two drawn beside each other.

    Of a stroke drawn twice one of the joins of the stretch is among those that are meant. Curves
    that are both placed exactly at their ends meet there anyway: joins that are exact do not count
    then. Closed curves at an even distance are two.
    """
    placed = survey.placed & ~curves.closed
    counts = (joins.gaps > exact) | ~placed[joins.curves].all(axis=1)
    meant = joins.curves[counts] @ [len(curves), 1]
    kept = np.isin(stretches.curves @ [len(curves), 1], meant)
    both_closed = curves.closed[stretches.curves].all(axis=1)
    for k in np.flatnonzero(kept & both_closed).tolist():
        kept[k] = not _runs_evenly(curves, stretches, k, exact)
    return Stretches(stretches.curves[kept], stretches.spans[kept])


def _runs_evenly(curves: PackedCurves, stretches: Stretches, number: int, exact: float) -> bool:
    """Are two closed curves about as far apart all along a stretch?"""
    one, other = stretches.curves[number].tolist()
    begin, end = stretches.spans[number, 0].tolist()
    at = np.linspace(begin, end, SAMPLES + 2)[1:-1]
    places = curves.locate(np.full(SAMPLES, one), at)
    whole = 0.0, float(curves.lasts[other])
    gaps = np.array([curves.find_nearest(other, place, whole)[1] for place in places])
    mean = float(gaps.mean())
    return mean > APART * exact and float(np.ptp(gaps)) < EVEN * mean


def is_within_duplicate(
    curves: PackedCurves, joins: Joins, stretches: Stretches, margin: float
) -> NDArray[np.bool_]:
    """Which joins without an end are crossings of two strokes within a stretch of both.

    margin: how far within.
    """
    within = np.zeros(len(joins), bool)
    pair = joins.curves @ [len(curves), 1]
    inner = ~curves.is_open_end(joins.curves, joins.lengths).any(axis=1)
    for both, spans in zip(stretches.curves, stretches.spans, strict=True):
        some = np.flatnonzero(inner & (pair == both @ [len(curves), 1]))
        lengths = joins.lengths[some]
        between = (spans[:, 0] + margin < lengths) & (lengths < spans[:, 1] - margin)
        within[some] |= between.all(axis=1)
    return within


def is_on_duplicate(joins: Joins, stretches: Stretches) -> NDArray[np.bool_]:
    """Which joins have a curve that is drawn twice there, whatever the other curve is."""
    result = np.zeros(len(joins), bool)
    for both, spans in zip(stretches.curves, stretches.spans, strict=True):
        for curve, (begin, end) in zip(both, spans, strict=True):
            on = (joins.curves == curve) & (begin <= joins.lengths) & (joins.lengths <= end)
            result |= on.any(axis=1)
    return result


def carry_cuts_over(
    curves: PackedCurves, joins: Joins, stretches: Stretches, tolerance: float
) -> Joins:
    """Return joins that give each curve of a stretch the cuts that the other has within it."""
    curve, length = joins.curves.reshape(-1).astype(float), joins.lengths.reshape(-1)
    rows = np.unique(np.stack([curve, length], axis=1), axis=0)
    begins = np.searchsorted(rows[:, 0], np.arange(len(curves) + 1))
    pairs: list[tuple[int, int]] = []
    lengths: list[tuple[float, float]] = []
    for both, spans in zip(stretches.curves.tolist(), stretches.spans.tolist(), strict=True):
        for (one, other), (here, there) in ((both, spans), (both[::-1], spans[::-1])):
            of_one: Floats = rows[begins[one] : begins[one + 1], 1]
            some = of_one[(here[0] <= of_one) & (of_one <= here[1])]
            for at, place in zip(
                some.tolist(), curves.locate(np.full(len(some), one), some), strict=True
            ):
                near, gap = curves.find_nearest(other, place, (there[0], there[1]))
                if gap <= NEAR * tolerance:
                    pairs.append((one, other))
                    lengths.append((at, near))
    n = len(pairs)
    return Joins(
        np.array(pairs, np.int64).reshape(-1, 2),
        np.array(lengths).reshape(-1, 2),
        np.zeros(n),
        np.arange(n),
    )
